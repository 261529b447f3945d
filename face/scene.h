// Everything a simulation depends on: a head, what its tissue is made of, what acts on it, how it
// is solved and how it moves. Read from a file by src/io/scene_file.h.
#pragma once

#include "face/energy.h"
#include "face/generic_head.h"
#include "face/motion.h"
#include "face/simulator.h"

namespace zygoma {

// kEquilibrium: implicit steps, or equilibrium where nothing has a memory. kExplicit: the explicit
// procedure of the paper.
enum class SolverKind { kEquilibrium, kExplicit };

struct Scene {
  HeadOptions head;
  Identity identity;
  TissueModel tissue;
  SolverKind solver = SolverKind::kEquilibrium;
  SettleOptions settle;
  Motion motion;

  // Throws InputError naming the first value that cannot be used.
  void check() const;
};

// The simulator a scene asks for.
Simulator make_simulator(const Scene& scene, std::shared_ptr<const Anatomy> anatomy);

}  // namespace zygoma
