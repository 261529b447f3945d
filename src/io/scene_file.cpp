#include "src/io/scene_file.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "face/facs.h"
#include "face/muscle_table.h"
#include "src/base/names.h"
#include "src/io/json_input.h"
#include "src/io/text.h"

namespace zygoma {
namespace {

using nlohmann::json;

constexpr const char* kScene = R"(a scene file (JSON) like {"motion": {"keys": [...]}})";
constexpr const char* kAuto = "auto";
constexpr const char* kKeyframes =
    R"(keyframes (JSON) like {"keys": [{"time_s": 0}, {"time_s": 1, "pose": "6+12"}]})";

double number_from(const std::string& where, const json& value) {
  if (!value.is_number() || !std::isfinite(value.get<double>())) complain(where, value, "a number");
  return value.get<double>();
}

// One object of the file. Remembers which keys it was asked for, so that done() knows the others.
class Section {
 public:
  Section(std::string where, const json& value) : where_(std::move(where)), value_(value) {
    if (!value.is_object()) complain(where_, value, "an object {...}");
  }

  std::string path(const std::string& key) const { return where_ + separator() + key; }

  const json* find(const std::string& key) {
    known_.push_back(key);
    const auto at = value_.find(key);
    return at == value_.end() ? nullptr : &*at;
  }

  void number(const std::string& key, double& target) {
    if (const json* value = find(key)) target = number_from(path(key), *value);
  }

  template <typename Integer>
  void integer(const std::string& key, Integer& target) {
    const json* value = find(key);
    if (value == nullptr) return;
    using Limits = std::numeric_limits<Integer>;
    const double given = value->is_number() ? value->get<double>() : 0.5;
    if (given != std::floor(given) || given < static_cast<double>(Limits::lowest()) ||
        given > static_cast<double>(Limits::max())) {
      complain(path(key), *value, "a whole number");
    }
    target = static_cast<Integer>(given);
  }

  void colour(const std::string& key, Eigen::Vector3f& target) {
    const json* value = find(key);
    if (value == nullptr) return;
    if (!value->is_array() || value->size() != 3) {
      complain(path(key), *value, "three numbers [red, green, blue] in [0, 1]");
    }
    for (int k = 0; k < 3; ++k) {
      const std::string place = path(key) + "[" + std::to_string(k) + "]";
      target[k] = static_cast<float>(number_from(place, (*value)[k]));
    }
  }

  // One of the words, by its place among them.
  template <typename Choice>
  void choice(const std::string& key, const std::vector<std::string>& words, Choice& target) {
    if (const json* value = find(key)) target = static_cast<Choice>(place(key, *value, words));
  }

  int place(const std::string& key, const json& value, const std::vector<std::string>& words) {
    const int place = value.is_string() ? find_name(words, value.get<std::string>()) : -1;
    if (place < 0) complain(path(key), value, "one of " + joined_names(words));
    return place;
  }

  // Whatever has not been asked for is unknown.
  void done() const {
    for (const auto& [key, value] : value_.items()) require_name(where_ + ":", known_, key);
  }

 private:
  const char* separator() const { return where_.ends_with(":") ? " " : "."; }

  std::string where_;
  const json& value_;
  std::vector<std::string> known_;
};

void read_head(Section section, HeadOptions& head, Identity& identity) {
  section.integer("surface_vertices", head.num_surface_vertices);
  section.integer("skin_levels", head.skin_levels);
  section.integer("albedo_size_px", head.albedo_size_px);
  if (const json* value = section.find("identity")) {
    Section person(section.path("identity"), *value);
    person.number("face_width", identity.face_width);
    person.number("face_height", identity.face_height);
    person.number("jaw_width", identity.jaw_width);
    person.number("nose_length", identity.nose_length);
    person.number("nose_width", identity.nose_width);
    person.number("lip_fullness", identity.lip_fullness);
    person.number("brow_height_mm", identity.brow_height_mm);
    person.number("eye_distance", identity.eye_distance);
    person.number("chin_length", identity.chin_length);
    person.number("stubble", identity.stubble);
    person.colour("skin_tone", identity.skin_tone);
    person.colour("hair_tone", identity.hair_tone);
    person.integer("texture_seed", identity.texture_seed);
    person.done();
  }
  section.done();
}

TissueLayer layer_from(Section section) {
  TissueLayer layer;
  const json* name = section.find("name");
  if (name == nullptr || !name->is_string()) {
    complain(section.path("name"), name ? *name : json(), "a name");
  }
  layer.name = name->get<std::string>();
  section.number("bottom_share", layer.bottom_share);
  section.number("modulus_kpa", layer.modulus_kpa);
  section.number("stiff_ratio", layer.stiff_ratio);
  section.number("bulk_ratio", layer.bulk_ratio);
  section.number("alpha_mn_per_mm", layer.alpha_mn_per_mm);
  section.done();
  return layer;
}

void read_layers(Section& section, LatticeOptions& lattice) {
  constexpr std::size_t kMostLayers = 16;
  const json* value = section.find("layers");
  if (value == nullptr) return;
  if (!value->is_array()) {
    const int place = section.place("layers", *value, {"tri", "bi"});
    lattice.layers = place == 0 ? tri_layer() : bi_layer();
    return;
  }
  if (value->size() < 2 || value->size() > kMostLayers) {
    complain(section.path("layers"), *value, "2 to " + std::to_string(kMostLayers) + " layers");
  }
  lattice.layers.clear();
  for (std::size_t k = 0; k < value->size(); ++k) {
    const std::string place = section.path("layers") + "[" + std::to_string(k) + "]";
    lattice.layers.push_back(layer_from({place, (*value)[k]}));
  }
}

void read_tissue(Section section, LatticeOptions& lattice) {
  section.choice("topology", {"prisms", "centroids"}, lattice.topology);
  section.choice("stiffness", {"calibrated", "constant"}, lattice.stiffness);
  section.choice("law", {"smooth", "literal"}, lattice.law);
  read_layers(section, lattice);
  section.number("epidermis_modulus_kpa", lattice.epidermis_modulus_kpa);
  section.number("epidermis_thickness_mm", lattice.epidermis_thickness_mm);
  section.number("epidermis_stiff_ratio", lattice.epidermis_stiff_ratio);
  section.number("epidermis_alpha_mn_per_mm", lattice.epidermis_alpha_mn_per_mm);
  if (const json* value = section.find("region_stiffness")) {
    Section regions(section.path("region_stiffness"), *value);
    const auto factor = [&](const char* name, Region region) {
      regions.number(name, lattice.region_stiffness[static_cast<std::size_t>(region)]);
    };
    factor("face", Region::kFace);
    factor("upper_lip", Region::kUpperLip);
    factor("lower_lip", Region::kLowerLip);
    factor("upper_lid", Region::kUpperLid);
    factor("lower_lid", Region::kLowerLid);
    regions.done();
  }
  section.number("density_kg_per_mm3", lattice.density_kg_per_mm3);
  section.number("smallest_fill", lattice.smallest_fill);
  section.done();
}

void read_muscles(Section section, MuscleOptions& muscles) {
  section.number("hold_kpa_per_mm", muscles.hold_kpa_per_mm);
  section.number("slip_hold_ratio", muscles.slip_hold_ratio);
  section.number("slip_elsewhere", muscles.slip_elsewhere);
  section.number("slip_reach_mm", muscles.slip_reach_mm);
  section.number("rim_hold_ratio", muscles.rim_hold_ratio);
  section.done();
}

// "auto", or effects by name. "auto" among the names: these, where they are called for.
void read_effects(const std::string& where,
                  const json& value,
                  std::vector<EffectChoice>& effects,
                  SettleOptions& settle) {
  if (value == kAuto) {
    effects = usual_effects();
    settle.choose_mm = SettleOptions::kUsualChooseMm;
    return;
  }
  if (!value.is_object()) complain(where, value, R"("auto" or an object like {"volume": {}})");
  effects.clear();
  for (const auto& [name, parameters] : value.items()) {
    if (name == kAuto) {
      Section section(where + "." + name, parameters);
      settle.choose_mm = SettleOptions::kUsualChooseMm;
      section.number("tolerance_mm", settle.choose_mm);
      section.done();
      require(settle.choose_mm > 0.0 && settle.choose_mm <= SettleOptions::kMostChooseMm,
              where + ".auto.tolerance_mm is " + shortest_text(settle.choose_mm) +
                  ", expected above 0, at most " + shortest_text(SettleOptions::kMostChooseMm));
      continue;
    }
    const Effect& effect = all_effects()[require_name(where + ":", all_effects(), name)];
    const std::string place = where + "." + name;
    if (!parameters.is_object()) complain(place, parameters, "an object of its parameters");
    EffectChoice choice{name, {}};
    for (const auto& [parameter, number] : parameters.items()) {
      require_name(place + ":", effect.parameters, parameter);
      choice.values[parameter] = number_from(place + "." + parameter, number);
    }
    effects.push_back(std::move(choice));
  }
  if (settle.choose_mm > 0.0 && effects.empty()) effects = usual_effects();
}

void read_solver(Section section, SettleOptions& settle) {
  section.choice("kind", {"equilibrium", "explicit"}, settle.solver);
  section.number("relative_residual", settle.relative_residual);
  section.integer("max_iterations", settle.max_iterations);
  section.number("still_mm", settle.still_mm);
  section.done();
}

// A muscle, or a pair of them by the name without a side.
void read_contractions(const std::string& where,
                       const json& value,
                       std::map<std::string, double>& contraction) {
  if (!value.is_object()) complain(where, value, R"(an object like {"zygomaticus_major": 0.5})");
  for (const auto& [name, number] : value.items()) {
    const std::vector<std::string> muscles = muscles_meant(where + ": ", name);
    const double c = number_from(where + "." + name, number);
    for (const std::string& muscle : muscles) {
      require(contraction.emplace(muscle, c).second,
              where + ": muscle " + muscle + " is there twice, alone and in a pair");
    }
  }
}

// An expression, action units or muscle=value, in one text.
void read_pose(const std::string& where, const json& value, MotionKey& key) {
  if (!value.is_string()) complain(where, value, R"(a text like "surprise" or "1+2+5B+26")");
  try {
    Pose pose = pose_of(value.get<std::string>());
    key.contraction = std::move(pose.contraction);
    key.jaw = pose.jaw;
  } catch (const InputError& error) {
    throw InputError(where + ": " + error.what());
  }
}

void read_motion(Section section, Motion& motion) {
  section.number("frames_per_s", motion.frames_per_s);
  section.number("duration_s", motion.duration_s);
  const json* keys = section.find("keys");
  section.done();
  if (keys == nullptr || !keys->is_array() || keys->empty()) {
    complain(section.path("keys"), keys ? *keys : json(), "a list of at least one pose");
  }
  for (std::size_t k = 0; k < keys->size(); ++k) {
    Section pose(section.path("keys") + "[" + std::to_string(k) + "]", (*keys)[k]);
    MotionKey key;
    const json* time = pose.find("time_s");
    if (time == nullptr) complain(pose.path("time_s"), json(), "the time of the pose, s");
    key.time_s = number_from(pose.path("time_s"), *time);
    if (const json* value = pose.find("pose")) read_pose(pose.path("pose"), *value, key);
    pose.number("jaw", key.jaw);
    if (const json* value = pose.find("contractions")) {
      std::map<std::string, double> given;
      read_contractions(pose.path("contractions"), *value, given);
      for (const auto& [muscle, contraction] : given) key.contraction[muscle] = contraction;
    }
    pose.done();
    motion.keys.push_back(std::move(key));
  }
}

// The struct's own check says what is wrong, this where.
template <typename Checked>
void check_section(const std::string& where, const Checked& check) {
  try {
    check();
  } catch (const InputError& error) {
    throw InputError(where + error.what());
  }
}

}  // namespace

Scene read_scene(const std::string& path) {
  const json document = parse_json<json>(path, kScene);
  const std::string root = path + ":";
  Section section(root, document);
  Scene scene;
  const auto part = [&](const char* name, const auto& read) {
    if (const json* value = section.find(name)) read(section.path(name), *value);
  };
  if (const json* about = section.find("about"); about != nullptr && !about->is_string()) {
    complain(section.path("about"), *about, "a text");
  }
  part("head", [&](const std::string& where, const json& value) {
    read_head({where, value}, scene.head, scene.identity);
  });
  part("tissue", [&](const std::string& where, const json& value) {
    read_tissue({where, value}, scene.tissue.lattice);
  });
  part("muscles", [&](const std::string& where, const json& value) {
    read_muscles({where, value}, scene.tissue.muscles);
  });
  part("effects", [&](const std::string& where, const json& value) {
    read_effects(where, value, scene.tissue.effects, scene.settle);
  });
  part("solver", [&](const std::string& where, const json& value) {
    read_solver({where, value}, scene.settle);
  });
  const json* motion = section.find("motion");
  section.done();
  if (motion == nullptr) complain(section.path("motion"), json(), "what the face does");
  read_motion({section.path("motion"), *motion}, scene.motion);

  check_section(root + " ", [&] { scene.head.check(); });
  check_section(root + " head.", [&] { scene.identity.check(); });
  check_section(root + " tissue: ", [&] { scene.tissue.lattice.check(); });
  check_section(root + " ", [&] { scene.tissue.muscles.check(); });
  check_section(root + " effects: ", [&] { check_effects(scene.tissue.effects); });
  check_section(root + " solver.", [&] { scene.settle.check(); });
  require(scene.settle.choose_mm == 0.0 || scene.settle.solver == Solver::kImplicit,
          root + " effects: auto goes with solver.kind equilibrium, not with explicit");
  check_section(root + " motion.", [&] { scene.motion.check(); });
  return scene;
}

Motion read_keyframes(const std::string& path) {
  const json document = parse_json<json>(path, kKeyframes);
  const std::string root = path + ":";
  Motion motion;
  read_motion({root, document}, motion);
  check_section(root + " ", [&] { motion.check(); });
  return motion;
}

}  // namespace zygoma
