// Effects: what may act on the tissue beyond springs, muscles and bone, each present only in scenes
// that ask for it.
//
// An effect is one file, face/effects/NAME.cpp, with one function make_NAME_effect() that describes
// it. The build lists the files; nothing else has to be changed to add one. An effect may change
// the lattice while it is built (`shape`), and may add terms (`build`). Terms are filed by the
// phases they take part in, which is known at compile time: a phase that nobody uses is an empty
// loop, and no flag is asked per node.
#pragma once

#include <concepts>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "face/anatomy.h"
#include "face/energy_term.h"
#include "face/lattice.h"

namespace zygoma {

struct EffectParameter {
  std::string name;  // with its unit
  double usual = 0.0;
  double lowest = 0.0;
  double highest = 0.0;
  std::string help;  // what it does, and what goes wrong at the ends
};

// An effect as a scene asks for it; parameters that are not given have their usual values.
struct EffectChoice {
  std::string name;
  std::map<std::string, double> values;
  bool operator==(const EffectChoice&) const = default;
};

// Every parameter of an effect with the value it has in this scene.
class EffectValues {
 public:
  explicit EffectValues(std::map<std::string, double> values) : values_(std::move(values)) {}
  double operator[](const std::string& name) const { return values_.at(name); }

 private:
  std::map<std::string, double> values_;
};

struct Effect;

// The terms of a scene's effects, by phase.
class Effects {
 public:
  // What one effect of the scene consists of.
  struct Part {
    const Effect* effect = nullptr;
    EffectValues values;
    std::vector<std::shared_ptr<EnergyTerm>> energy;
    std::vector<std::shared_ptr<MemoryTerm>> memory;
    bool acts = true;
  };

  // Terms filed from now on are of this effect.
  void open(const Effect& effect, const EffectValues& values) {
    parts_.push_back({&effect, values, {}, {}});
  }
  template <typename Term>
  requires std::derived_from<Term, EnergyTerm> || std::derived_from<Term, MemoryTerm>
  void file(std::shared_ptr<Term> term) {
    if constexpr (std::derived_from<Term, EnergyTerm>) parts_.back().energy.push_back(term);
    if constexpr (std::derived_from<Term, MemoryTerm>) parts_.back().memory.push_back(term);
    gather();
  }
  const std::vector<Part>& parts() const { return parts_; }

  // A part that does not act is in none of the lists below: it executes nothing.
  void set_acts(std::size_t part, bool acts) {
    parts_[part].acts = acts;
    gather();
  }
  const std::vector<std::shared_ptr<EnergyTerm>>& energy() const { return energy_; }
  const std::vector<std::shared_ptr<MemoryTerm>>& memory() const { return memory_; }

 private:
  void gather();

  std::vector<Part> parts_;
  std::vector<std::shared_ptr<EnergyTerm>> energy_;
  std::vector<std::shared_ptr<MemoryTerm>> memory_;
};

// How the tissue is about to move in a frame, as far as its controls tell.
struct ExpectedMotion {
  double step_s = 0.0;
  double moved_mm = 0.0;    // what moves furthest
  double changed_mm = 0.0;  // of that against the frame before: moved by its speed of then
  double sag_mm = 0.0;      // what the mass of the tissue gives way to an acceleration of 1 mm/s^2
};

struct Effect {
  std::string name;
  std::string what;  // one line: what it adds, and when a scene needs it
  std::vector<EffectParameter> parameters;
  // Acts between nodes only: its forces and torques add up to zero. Else it acts from outside.
  bool internal = true;
  // Why no scene has it that does not ask for it by name; empty = it can be of use to any.
  std::string only_if_asked;
  // For scenes that leave the choice to the program (effect_chooser.h). When a moment calls for the
  // effect, as half a sentence; empty = it is always there.
  std::string called_for_when;
  // mm that it could change in a frame, told from the motion alone. Without this its forces are
  // asked, which must not look back then.
  double (*could_change_mm)(const EffectValues& values, const ExpectedMotion& motion) = nullptr;
  void (*shape)(const EffectValues& values, const Anatomy& anatomy, Lattice& lattice) = nullptr;
  // Anatomy and lattice outlive the terms.
  void (*build)(const EffectValues& values,
                const Anatomy& anatomy,
                const Lattice& lattice,
                Effects& effects) = nullptr;
};

// All there are, by name.
const std::vector<Effect>& all_effects();

// All effects but those that have to be asked for, with their usual values.
std::vector<EffectChoice> usual_effects();

// Throws InputError naming the effect or parameter, its value and what was expected, if a choice
// names no effect, one twice, an unknown parameter or a value outside its range.
void check_effects(const std::vector<EffectChoice>& choices);

// The values of an effect as `choices` have it, or its usual ones.
EffectValues effect_values(const std::string& name, const std::vector<EffectChoice>& choices);

// Lets every chosen effect shape the lattice, then builds the terms.
Effects make_effects(const std::vector<EffectChoice>& choices,
                     const Anatomy& anatomy,
                     Lattice& lattice);

}  // namespace zygoma
