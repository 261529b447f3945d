#include "src/cli/effect_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "src/base/names.h"

namespace zygoma {
namespace {

double number_from(const std::string& setting, const std::string& text) {
  double value = 0.0;
  const char* last = text.data() + text.size();
  const auto result = std::from_chars(text.data(), last, value);
  require(result.ec == std::errc() && result.ptr == last && std::isfinite(value),
          "--with: " + quote_value(setting) + " has no number, expected parameter=value");
  return value;
}

// NAME or NAME:parameter=value,parameter=value
EffectChoice choice_from(const std::string& text) {
  const auto colon = text.find(':');
  EffectChoice choice{text.substr(0, colon), {}};
  std::string rest = colon == std::string::npos ? "" : text.substr(colon + 1);
  while (!rest.empty()) {
    const auto comma = rest.find(',');
    const std::string setting = rest.substr(0, comma);
    rest.erase(0, comma == std::string::npos ? comma : comma + 1);
    const auto equals = setting.find('=');
    require(equals != std::string::npos,
            "--with: " + quote_value(setting) + " in " + quote_value(text) +
                ", expected EFFECT or EFFECT:parameter=value,...");
    const double value = number_from(setting, setting.substr(equals + 1));
    require(choice.values.emplace(setting.substr(0, equals), value).second,
            "--with: " + quote_value(text) + " sets a parameter twice");
  }
  return choice;
}

}  // namespace

void EffectOptions::declare(OptionSink& options) {
  options.texts("--with",
                with_,
                "EFFECT",
                "an effect to add, or NAME:parameter=value,... to set it; may be repeated");
  options.texts("--without", without_, "EFFECT", "an effect to leave out; may be repeated");
}

void EffectOptions::declare_choice(OptionSink& options) {
  declare(options);
  options.choice("--effects",
                 effects_,
                 {"scene", "auto"},
                 "as the scene says, or auto: every effect there is, where a moment calls for it");
  options.number("--effects-tolerance",
                 tolerance_mm_,
                 {1e-6, 10.0},
                 "mm that `--effects auto` may leave out against simulating everything");
}

void EffectOptions::apply(Scene& scene) const {
  if (effects_ == "auto") {
    require(scene.settle.solver == Solver::kImplicit,
            "--effects auto: goes with solver.kind equilibrium, the scene says explicit");
    for (const EffectChoice& usual : usual_effects()) {
      std::vector<EffectChoice>& effects = scene.tissue.effects;
      if (find_name(effects, usual.name) < 0) effects.push_back(usual);
    }
    scene.settle.choose_mm = tolerance_mm_;
  }
  apply(scene.tissue.effects);
}

void EffectOptions::apply(std::vector<EffectChoice>& effects) const {
  for (const std::string& name : without_) {
    require_name("--without:", all_effects(), name);
    std::erase_if(effects, [&](const EffectChoice& choice) { return choice.name == name; });
  }
  for (const std::string& text : with_) {
    const EffectChoice wanted = choice_from(text);
    const int there = find_name(effects, wanted.name);
    EffectChoice& choice = there < 0 ? effects.emplace_back() : effects[there];
    choice.name = wanted.name;
    for (const auto& [name, value] : wanted.values) choice.values[name] = value;
    try {
      check_effects(effects);
    } catch (const InputError& error) {
      throw InputError("--with: " + std::string(error.what()));
    }
  }
}

}  // namespace zygoma
