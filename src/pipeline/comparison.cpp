#include "src/pipeline/comparison.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <map>

#include "src/base/names.h"
#include "tracker/feature_schema.h"

namespace zygoma {
namespace {

// From the nearest point of a segment to p.
Point2 from_segment(const Point2& p, const Point2& a, const Point2& b) {
  const Point2 ab = b - a;
  const double length2 = ab.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
  return p - a - t * ab;
}

// Of every node from the nearest place of the target, positive to the right of its walk.
std::vector<double> signed_distances(const Contour& contour, const Contour& target) {
  std::vector<double> distances;
  const std::vector<Point2>& line = target.points_px;
  for (const Point2& p : contour.points_px) {
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < line.size(); ++i) {
      const Point2 off = from_segment(p, line[i - 1], line[i]);
      if (off.norm() >= std::abs(best)) continue;
      const Point2 walk = line[i] - line[i - 1];
      best = std::copysign(off.norm(), walk.x() * off.y() - walk.y() * off.x());
    }
    distances.push_back(line.size() > 1 ? best : (p - line.front()).norm());
  }
  return distances;
}

double mean_size(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += std::abs(value);
  return sum / static_cast<double>(values.size());
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const double k = q * static_cast<double>(values.size() - 1);
  const auto i = static_cast<std::size_t>(k);
  const std::size_t j = std::min(i + 1, values.size() - 1);
  return values[i] + (values[j] - values[i]) * (k - static_cast<double>(i));
}

// Per frame the mean size of the distances, each less its node's median over all frames.
std::vector<double> sizes_about_medians(std::vector<std::vector<double>> frames) {
  std::vector<double> sizes;
  std::vector<double> column(frames.size());
  for (std::size_t k = 0; !frames.empty() && k < frames.front().size(); ++k) {
    for (std::size_t t = 0; t < frames.size(); ++t) column[t] = frames[t][k];
    const double middle = quantile(column, 0.5);
    for (auto& frame : frames) frame[k] -= middle;
  }
  for (const auto& frame : frames) sizes.push_back(mean_size(frame));
  return sizes;
}

ContractionError error_of(const std::string& control,
                          const std::vector<double>& estimate,
                          const std::vector<double>& truth) {
  ContractionError error;
  error.control = control;
  error.num_frames = static_cast<int>(truth.size());
  if (truth.empty()) return error;
  const auto n = static_cast<double>(truth.size());
  double mean_e = 0.0;
  double mean_t = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    mean_e += estimate[i] / n;
    mean_t += truth[i] / n;
  }
  double square = 0.0;
  double see = 0.0;
  double stt = 0.0;
  double set = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    square += (estimate[i] - truth[i]) * (estimate[i] - truth[i]);
    see += (estimate[i] - mean_e) * (estimate[i] - mean_e);
    stt += (truth[i] - mean_t) * (truth[i] - mean_t);
    set += (estimate[i] - mean_e) * (truth[i] - mean_t);
  }
  error.rms = std::sqrt(square / n);
  const auto [low, high] = std::minmax_element(truth.begin(), truth.end());
  error.truth_range = *high - *low;
  if (see > 0.0 && stt > 0.0) error.correlation = set / std::sqrt(see * stt);
  return error;
}

}  // namespace

std::vector<ContractionError> compare_contractions(const ContractionTrack& estimate,
                                                   const ContractionTrack& truth) {
  std::map<int, const Contractions*> by_frame;
  for (const Contractions& frame : estimate.frames) by_frame[frame.frame_index] = &frame;

  using Value = std::function<double(const Contractions&)>;
  const auto compare = [&](const std::string& control, const Value& estimated, const Value& known) {
    std::vector<double> e;
    std::vector<double> t;
    for (const Contractions& frame : truth.frames) {
      const auto found = by_frame.find(frame.frame_index);
      if (found == by_frame.end() || found->second->value.empty() || frame.value.empty()) continue;
      e.push_back(estimated(*found->second));
      t.push_back(known(frame));
    }
    return error_of(control, e, t);
  };

  std::vector<ContractionError> errors;
  const Value jaw = [](const Contractions& frame) { return frame.jaw; };
  errors.push_back(compare("jaw", jaw, jaw));
  for (std::size_t m = 0; m < truth.muscles.size(); ++m) {
    const int k = find_name(estimate.muscles, truth.muscles[m]);
    if (k < 0) continue;
    errors.push_back(compare(
        truth.muscles[m],
        [k](const Contractions& frame) { return frame.value[k]; },
        [m](const Contractions& frame) { return frame.value[m]; }));
  }
  return errors;
}

std::vector<ContourError> compare_contours(const std::vector<ContourSet>& estimate,
                                           const std::vector<ContourSet>& truth) {
  std::map<int, const ContourSet*> by_frame;
  for (const ContourSet& set : estimate) by_frame[set.frame_index] = &set;
  std::vector<ContourError> errors;
  for (const Feature& feature : kFeatureSchema) {
    std::vector<double> distances;
    std::vector<std::vector<double>> of_nodes;
    int num_true = 0;
    for (const ContourSet& set : truth) {
      const Contour* target = set.visible(feature.name);
      if (target == nullptr) continue;
      ++num_true;
      const auto found = by_frame.find(set.frame_index);
      if (found == by_frame.end()) continue;
      const Contour* contour = found->second->visible(feature.name);
      if (contour == nullptr) continue;
      of_nodes.push_back(signed_distances(*contour, *target));
      distances.push_back(mean_size(of_nodes.back()));
    }
    if (num_true == 0) continue;
    ContourError error;
    error.contour = feature.name;
    error.median_px = quantile(distances, 0.5);
    error.p90_px = quantile(distances, 0.9);
    const std::vector<double> moved = sizes_about_medians(of_nodes);
    error.motion_median_px = quantile(moved, 0.5);
    error.motion_p90_px = quantile(moved, 0.9);
    error.cover = static_cast<double>(distances.size()) / num_true;
    errors.push_back(error);
  }
  return errors;
}

double overall_rms(const std::vector<ContractionError>& errors) {
  double square = 0.0;
  for (const ContractionError& e : errors) square += e.rms * e.rms;
  return errors.empty() ? 0.0 : std::sqrt(square / static_cast<double>(errors.size()));
}

std::string contraction_table(const std::vector<ContractionError>& errors) {
  std::string table = "  control                                       RMS      r  true range\n";
  for (const ContractionError& e : errors) {
    char line[160];
    if (e.truth_range >= 0.05) {
      std::snprintf(line,
                    sizeof line,
                    "  %-42s %6.3f  %5.2f  %10.2f\n",
                    e.control.c_str(),
                    e.rms,
                    e.correlation,
                    e.truth_range);
    } else {
      std::snprintf(line,
                    sizeof line,
                    "  %-42s %6.3f      -  %10.2f\n",
                    e.control.c_str(),
                    e.rms,
                    e.truth_range);
    }
    table += line;
  }
  if (!errors.empty()) {
    char line[160];
    std::snprintf(line, sizeof line, "  %-42s %6.3f\n", "all", overall_rms(errors));
    table += line;
  }
  return table;
}

std::string contour_table(const std::vector<ContourError>& errors) {
  std::string table = "  contour       median px   90 % px   cover\n";
  for (const ContourError& e : errors) {
    char line[120];
    std::snprintf(line,
                  sizeof line,
                  "  %-13s %9.2f %9.2f   %5.2f\n",
                  e.contour.c_str(),
                  e.median_px,
                  e.p90_px,
                  e.cover);
    table += line;
  }
  return table;
}

}  // namespace zygoma
