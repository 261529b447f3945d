#include "face/scene.h"

#include "src/base/check.h"

namespace zygoma {

void Scene::check() const {
  head.check();
  identity.check();
  tissue.lattice.check();
  tissue.muscles.check();
  check_effects(tissue.effects);
  settle.check();
  motion.check();
}

Simulator make_simulator(const Scene& scene, std::shared_ptr<const Anatomy> anatomy) {
  require(scene.solver == SolverKind::kEquilibrium,
          "solver \"explicit\": not available yet, expected \"equilibrium\"");
  return Simulator(std::move(anatomy), scene.tissue, scene.settle);
}

}  // namespace zygoma
