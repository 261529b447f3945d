#include "src/io/profile_file.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "retarget/observe.h"
#include "src/base/names.h"
#include "src/io/atomic_file.h"
#include "src/io/json_input.h"
#include "src/io/text.h"

namespace zygoma {
namespace {

using json = nlohmann::ordered_json;

constexpr const char* kSchema = "zygoma-profile/1";
constexpr const char* kKind = "a performer's profile, as `--save-profile` writes it";

json contour_json(const StackedContours& contours, int contour) {
  json points = json::array();
  for (int k = first_node(contour); k <= last_node(contour); ++k) {
    points.push_back({contours.nodes(0, k), contours.nodes(1, k)});
  }
  return {{"confidence", contours.confidence[static_cast<std::size_t>(contour)]},
          {"points_px", points}};
}

double number_in(const std::string& where, const json& value, double low, double high) {
  const bool fits = value.is_number() && std::isfinite(value.get<double>()) &&
                    value.get<double>() >= low && value.get<double>() <= high;
  if (!fits) {
    std::string expected = "a number in [";
    append_fixed(expected, low, 2);
    expected += ", ";
    append_fixed(expected, high, 2);
    complain(where, value, expected + "]");
  }
  return value.get<double>();
}

const json& member(const std::string& where, const json& object, const char* name) {
  require(object.is_object() && object.contains(name),
          where + ": has no " + name + ", expected " + kKind);
  return object[name];
}

void read_contour(const std::string& where, const json& given, int c, StackedContours& contours) {
  constexpr double kFarthest_px = 1e6;
  const auto index = static_cast<std::size_t>(c);
  contours.confidence[index] =
      number_in(where + ".confidence", member(where, given, "confidence"), 0.0, 1.0);
  const json& points = member(where, given, "points_px");
  const std::string here = where + ".points_px";
  if (!points.is_array() || static_cast<int>(points.size()) != num_nodes(c)) {
    complain(here, points, "a list of " + std::to_string(num_nodes(c)) + " points [x, y]");
  }
  for (int k = 0; k < num_nodes(c); ++k) {
    const json& point = points[static_cast<std::size_t>(k)];
    const std::string at = here + "[" + std::to_string(k) + "]";
    if (!point.is_array() || point.size() != 2) complain(at, point, "a point [x, y]");
    for (int axis = 0; axis < 2; ++axis) {
      contours.nodes(axis, first_node(c) + k) =
          number_in(at, point[static_cast<std::size_t>(axis)], -kFarthest_px, kFarthest_px);
    }
  }
}

}  // namespace

void write_profile(const std::string& path, const PerformerProfile& profile) {
  json contours = json::object();
  for (int c = 0; c < kNumContours; ++c) {
    const std::string name(kFeatureSchema[static_cast<std::size_t>(c)].name);
    if (profile.neutral.contours.visible(c)) {
      contours[name] = contour_json(profile.neutral.contours, c);
    }
  }
  json range = json::object();
  for (const auto& [name, value] : profile.range) range[name] = value;
  const json document{{"schema", kSchema},
                      {"neutral_frame", profile.neutral.frame_index},
                      {"neutral", contours},
                      {"range", range}};
  AtomicFile file(path);
  file.stream() << document.dump(1) << '\n';
  file.commit();
}

PerformerProfile read_profile(const std::string& path) {
  const json document = parse_json<json>(path, kKind);
  const json& schema = member(path, document, "schema");
  if (schema != kSchema) complain(path + ": schema", schema, kSchema);
  PerformerProfile profile;
  profile.neutral.frame_index = -1;  // of another clip
  const json& neutral = member(path, document, "neutral");
  if (!neutral.is_object()) complain(path + ": neutral", neutral, "contours by name");
  for (const auto& [name, value] : neutral.items()) {
    require_name(path + ": neutral:", kFeatureSchema, name);
  }
  for (int c = 0; c < kNumContours; ++c) {
    const std::string name(kFeatureSchema[static_cast<std::size_t>(c)].name);
    if (!neutral.contains(name)) continue;
    read_contour(path + ": neutral." + name, neutral[name], c, profile.neutral.contours);
  }
  require(is_usable(profile.neutral.contours),
          path + ": neutral shows too few contours, expected brows or lips and at least three");
  const json& range = member(path, document, "range");
  if (!range.is_object()) complain(path + ": range", range, "an object of numbers by muscle");
  for (const auto& [name, value] : range.items()) {
    profile.range.emplace_back(name,
                               number_in(path + ": range." + name,
                                         value,
                                         PerformerProfile::kLeastRange,
                                         PerformerProfile::kLargestRange));
  }
  return profile;
}

}  // namespace zygoma
