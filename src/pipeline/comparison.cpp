#include "src/pipeline/comparison.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <map>

#include "tracker/feature_schema.h"

namespace zygoma {
namespace {

double segment_distance(const Point2& p, const Point2& a, const Point2& b) {
  const Point2 ab = b - a;
  const double length2 = ab.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * ab).norm();
}

double mean_distance(const Contour& contour, const Contour& target) {
  double sum = 0.0;
  for (const Point2& p : contour.points_px) {
    double best = (p - target.points_px.front()).norm();
    for (std::size_t i = 1; i < target.points_px.size(); ++i) {
      best = std::min(best, segment_distance(p, target.points_px[i - 1], target.points_px[i]));
    }
    sum += best;
  }
  return sum / static_cast<double>(contour.points_px.size());
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const double k = q * static_cast<double>(values.size() - 1);
  const auto i = static_cast<std::size_t>(k);
  const std::size_t j = std::min(i + 1, values.size() - 1);
  return values[i] + (values[j] - values[i]) * (k - static_cast<double>(i));
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
    const auto found =
        std::find(estimate.muscles.begin(), estimate.muscles.end(), truth.muscles[m]);
    if (found == estimate.muscles.end()) continue;
    const auto k = static_cast<std::size_t>(found - estimate.muscles.begin());
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
    int num_true = 0;
    for (const ContourSet& set : truth) {
      const Contour* target = set.visible(feature.name);
      if (target == nullptr) continue;
      ++num_true;
      const auto found = by_frame.find(set.frame_index);
      if (found == by_frame.end()) continue;
      const Contour* contour = found->second->visible(feature.name);
      if (contour != nullptr) distances.push_back(mean_distance(*contour, *target));
    }
    if (num_true == 0) continue;
    ContourError error;
    error.contour = feature.name;
    error.median_px = quantile(distances, 0.5);
    error.p90_px = quantile(distances, 0.9);
    error.cover = static_cast<double>(distances.size()) / num_true;
    errors.push_back(error);
  }
  return errors;
}

std::string contraction_table(const std::vector<ContractionError>& errors) {
  std::string table = "  control                                       RMS      r  true range\n";
  double square = 0.0;
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
    square += e.rms * e.rms;
  }
  if (!errors.empty()) {
    char line[160];
    std::snprintf(line,
                  sizeof line,
                  "  %-42s %6.3f\n",
                  "all",
                  std::sqrt(square / static_cast<double>(errors.size())));
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
