#include "face/effect.h"

#include "src/base/names.h"

namespace zygoma {

#define ZYGOMA_PLUGIN(make) Effect make();
#include "generated/face_list.inc"
#undef ZYGOMA_PLUGIN

const std::vector<Effect>& all_effects() {
  static const std::vector<Effect> effects{
#define ZYGOMA_PLUGIN(make) make(),
#include "generated/face_list.inc"
#undef ZYGOMA_PLUGIN
  };
  return effects;
}

namespace {

const Effect& find_effect(const std::string& name) {
  return all_effects()[require_name("effect", all_effects(), name)];
}

EffectValues values_of(const Effect& effect, const EffectChoice& choice) {
  std::map<std::string, double> values;
  for (const EffectParameter& p : effect.parameters) {
    const auto given = choice.values.find(p.name);
    const double value = given == choice.values.end() ? p.usual : given->second;
    require_range("effect " + effect.name + ": " + p.name, value, p.lowest, p.highest);
    values[p.name] = value;
  }
  for (const auto& [name, value] : choice.values) {
    require_name("effect " + effect.name + ": parameter", effect.parameters, name);
  }
  return EffectValues(std::move(values));
}

}  // namespace

void Effects::gather() {
  energy_.clear();
  memory_.clear();
  for (const Part& part : parts_) {
    if (!part.acts) continue;
    energy_.insert(energy_.end(), part.energy.begin(), part.energy.end());
    memory_.insert(memory_.end(), part.memory.begin(), part.memory.end());
  }
}

std::vector<EffectChoice> usual_effects() {
  std::vector<EffectChoice> choices;
  for (const Effect& effect : all_effects()) {
    if (effect.only_if_asked.empty()) choices.push_back({effect.name, {}});
  }
  return choices;
}

void check_effects(const std::vector<EffectChoice>& choices) {
  for (std::size_t k = 0; k < choices.size(); ++k) {
    values_of(find_effect(choices[k].name), choices[k]);
    require(find_name(choices, choices[k].name) == static_cast<int>(k),
            "effect " + choices[k].name + ": asked for twice");
  }
}

EffectValues effect_values(const std::string& name, const std::vector<EffectChoice>& choices) {
  const int at = find_name(choices, name);
  return values_of(find_effect(name), at < 0 ? EffectChoice{name, {}} : choices[at]);
}

Effects make_effects(const std::vector<EffectChoice>& choices,
                     const Anatomy& anatomy,
                     Lattice& lattice) {
  check_effects(choices);
  // In the order of all_effects(), so that the order of a scene's list has no effect.
  const auto for_each_chosen = [&](const auto& use) {
    for (const Effect& effect : all_effects()) {
      for (const EffectChoice& choice : choices) {
        if (choice.name == effect.name) use(effect, values_of(effect, choice));
      }
    }
  };
  for_each_chosen([&](const Effect& effect, const EffectValues& values) {
    if (effect.shape) effect.shape(values, anatomy, lattice);
  });
  Effects effects;
  for_each_chosen([&](const Effect& effect, const EffectValues& values) {
    effects.open(effect, values);
    if (effect.build) effect.build(values, anatomy, lattice, effects);
  });
  return effects;
}

}  // namespace zygoma
