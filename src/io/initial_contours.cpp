#include <cmath>
#include <nlohmann/json.hpp>

#include "src/base/names.h"
#include "src/io/contours_file.h"
#include "src/io/json_input.h"
#include "src/io/text.h"
#include "tracker/feature_schema.h"

namespace zygoma {
namespace {

using nlohmann::json;

constexpr const char* kKind =
    R"(a contours JSON file like {"frame": 0, "contours": {"brow_left": [[x, y], ...]}})";

double coordinate(const std::string& where, const json& value) {
  const bool is_finite = value.is_number() && std::isfinite(value.get<double>());
  if (!is_finite) complain(where, value, "a number of pixels");
  return value.get<double>();
}

Contour contour_from(const std::string& where, std::string_view name, const json& points) {
  if (!points.is_array() || points.size() < 2) {
    complain(where, points, "a list of at least two points [x, y]");
  }
  Contour contour{std::string(name), {}, 1.0, false};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const json& point = points[i];
    const std::string here = where + "[" + std::to_string(i) + "]";
    if (!point.is_array() || point.size() != 2) complain(here, point, "a point [x, y]");
    contour.points_px.emplace_back(coordinate(here, point[0]), coordinate(here, point[1]));
  }
  return contour;
}

}  // namespace

ContourSet read_initial_contours(const std::string& path) {
  const json document = parse_json<json>(path, kKind);
  if (!document.is_object()) complain(path, document, kKind);
  const auto given = document.find("contours");
  require(given != document.end() && given->is_object() && !given->empty(),
          path + ": has no contours, expected " + kKind);

  ContourSet set;
  if (const auto frame = document.find("frame"); frame != document.end()) {
    const bool is_index = frame->is_number_unsigned() && frame->get<std::uint64_t>() < 1u << 31;
    if (!is_index) complain(path + ": frame", *frame, "the number of a frame, from 0");
    set.frame_index = frame->get<int>();
  }
  for (const auto& [name, points] : given->items()) {
    require_name(path + ": contours:", kFeatureSchema, name);
  }
  for (const Feature& feature : kFeatureSchema) {
    const std::string name(feature.name);
    const auto points = given->find(name);
    set.contours.push_back(points == given->end()
                               ? Contour{name, {}, 0.0, false}
                               : contour_from(path + ": contours." + name, name, *points));
  }
  return set;
}

}  // namespace zygoma
