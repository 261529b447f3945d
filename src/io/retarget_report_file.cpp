#include "src/io/retarget_report_file.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "face/muscle.h"
#include "src/base/names.h"
#include "src/io/atomic_file.h"
#include "src/io/svg_plot.h"

namespace zygoma {
namespace {

using json = nlohmann::ordered_json;

double rounded(double value) { return std::round(value * 1e4) / 1e4; }

json control_json(const ControlEvidence& control) {
  json explained = json::object();
  for (int c = 0; c < kNumContours; ++c) {
    const double share = control.share[static_cast<std::size_t>(c)];
    if (share < 0.005) continue;
    explained[std::string(kFeatureSchema[static_cast<std::size_t>(c)].name)] = rounded(share);
  }
  return {{"control", control.control},
          {"strongest", rounded(control.strongest)},
          {"strongest_frame", control.frame_index},
          {"observed_share", rounded(control.observed_share)},
          {"explained_by", explained}};
}

// A curve and its sigma in a frame.
using Reading = std::function<double(const Contractions&)>;

PlotSeries curve_of(const ContractionTrack& track, const Reading& value, int colour) {
  PlotSeries series;
  series.colour = colour;
  for (const Contractions& frame : track.frames) {
    series.x.push_back(frame.time_s);
    series.y.push_back(frame.value.empty() ? std::nan("") : value(frame));
  }
  return series;
}

// Once along the upper edge and back along the lower one.
PlotSeries band_of(const ContractionTrack& track,
                   const Reading& value,
                   const Reading& sigma,
                   int colour) {
  PlotSeries series;
  series.mark = PlotMark::kBand;
  series.colour = colour;
  const auto add = [&](const Contractions& frame, double sign) {
    if (frame.sigma.empty()) return;
    series.x.push_back(frame.time_s);
    series.y.push_back(std::clamp(value(frame) + sign * 2.0 * sigma(frame), 0.0, 1.0));
  };
  for (const Contractions& frame : track.frames) add(frame, 1.0);
  for (auto t = track.frames.rbegin(); t != track.frames.rend(); ++t) add(*t, -1.0);
  return series;
}

struct PlottedCurve {
  Reading value;
  Reading sigma;
  std::string label;
  int colour = 0;
};

PlotPanel panel_of(const std::string& title,
                   const ContractionTrack& track,
                   const ContractionTrack* smooth,
                   const std::vector<PlottedCurve>& curves) {
  PlotPanel panel{title, {"time (s)", false}, {"contraction", false}, {}};
  for (const PlottedCurve& c : curves) {
    panel.series.push_back(band_of(track, c.value, c.sigma, c.colour));
  }
  for (const PlottedCurve& c : curves) {
    panel.series.push_back(curve_of(track, c.value, c.colour));
    panel.series.back().label = c.label;
    if (smooth == nullptr) continue;
    panel.series.push_back(curve_of(*smooth, c.value, c.colour));
    panel.series.back().mark = PlotMark::kDashes;
  }
  // All panels have the same scale.
  const double begin = track.frames.empty() ? 0.0 : track.frames.front().time_s;
  panel.series.push_back({{}, {begin, begin}, {0.0, 1.0}, PlotMark::kLine, 4});
  return panel;
}

}  // namespace

void write_retarget_report(const std::string& path,
                           const RetargetReview& review,
                           const RetargetReport& report) {
  json contours = json::array();
  for (const ContourFit& fit : review.contours) {
    contours.push_back({{"contour", fit.contour},
                        {"frames", fit.num_frames},
                        {"median_px", rounded(fit.median_px)},
                        {"p90_px", rounded(fit.p90_px)},
                        {"median_percent_of_face", rounded(fit.median_percent)}});
  }
  json controls = json::array();
  for (const ControlEvidence& control : review.controls) controls.push_back(control_json(control));
  json suspects = json::array();
  for (const SuspectFrame& suspect : review.suspects) {
    suspects.push_back({{"frame", suspect.frame_index},
                        {"timestamp", suspect.time_s},
                        {"badness", rounded(suspect.badness)},
                        {"reason", suspect.reason}});
  }
  json neutral_frame = nullptr;
  if (report.neutral_frame >= 0) neutral_frame = report.neutral_frame;
  const json document{{"schema", "zygoma-retarget/1"},
                      {"neutral_frame", neutral_frame},
                      {"neutral_doubts", report.neutral_doubts},
                      {"frames_estimated", report.frames_estimated},
                      {"frames_not_converged", report.frames_not_converged},
                      {"face_unit_px", rounded(report.face_unit_px)},
                      {"jaw_carry", rounded(report.jaw_carry)},
                      {"contours", contours},
                      {"controls", controls},
                      {"frames_to_look_at", suspects}};
  AtomicFile file(path);
  file.stream() << document.dump(1) << '\n';
  file.commit();
}

void write_contraction_plot(const std::string& path,
                            const ContractionTrack& track,
                            const ContractionTrack* smooth) {
  constexpr int kLeft = 0;
  constexpr int kRight = 1;
  constexpr int kMiddle = 2;
  std::vector<PlotPanel> panels;
  panels.push_back(panel_of("jaw",
                            track,
                            smooth,
                            {{[](const Contractions& c) { return c.jaw; },
                              [](const Contractions& c) { return c.jaw_sigma; },
                              "jaw",
                              kMiddle}}));
  const auto curve = [](std::size_t i, const std::string& label, int colour) {
    return PlottedCurve{[i](const Contractions& c) { return c.value[i]; },
                        [i](const Contractions& c) { return c.sigma[i]; },
                        label,
                        colour};
  };
  for (std::size_t i = 0; i < track.muscles.size(); ++i) {
    const std::string& name = track.muscles[i];
    if (name.ends_with("_R")) continue;  // with its left one
    const std::string base(without_side(name));
    std::vector<PlottedCurve> curves{curve(i, name == base ? "" : "left", kLeft)};
    const int right = find_name(track.muscles, base + "_R");
    if (right >= 0) curves.push_back(curve(static_cast<std::size_t>(right), "right", kRight));
    panels.push_back(panel_of(base, track, smooth, curves));
  }
  write_svg_plot(path, panels, 2);
}

}  // namespace zygoma
