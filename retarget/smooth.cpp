#include "retarget/smooth.h"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "src/base/check.h"
#include "src/base/names.h"

namespace zygoma {
namespace {

// One curve of a track.
struct Curve {
  std::function<double(const Contractions&)> value;
  std::function<double(const Contractions&)> sigma;
  std::function<void(Contractions&, double)> set;
};

double unit(double value) { return std::clamp(value, 0.0, 1.0); }

std::vector<Curve> curves_of(const ContractionTrack& track) {
  std::vector<Curve> curves;
  const auto even = [](const Contractions&) { return 1.0; };
  for (std::size_t i = 0; i < track.muscles.size(); ++i) {
    curves.push_back({[i](const Contractions& c) { return c.value[i]; },
                      [i](const Contractions& c) { return c.sigma.empty() ? 1.0 : c.sigma[i]; },
                      [i](Contractions& c, double v) { c.value[i] = unit(v); }});
  }
  curves.push_back({[](const Contractions& c) { return c.jaw; },
                    [](const Contractions& c) { return c.sigma.empty() ? 1.0 : c.jaw_sigma; },
                    [](Contractions& c, double v) { c.jaw = unit(v); }});
  curves.push_back({[](const Contractions& c) { return c.head.x_px; },
                    even,
                    [](Contractions& c, double v) { c.head.x_px = v; }});
  curves.push_back({[](const Contractions& c) { return c.head.y_px; },
                    even,
                    [](Contractions& c, double v) { c.head.y_px = v; }});
  curves.push_back({[](const Contractions& c) { return c.head.scale; },
                    even,
                    [](Contractions& c, double v) { c.head.scale = v; }});
  curves.push_back({[](const Contractions& c) { return c.head.roll_rad; },
                    even,
                    [](Contractions& c, double v) { c.head.roll_rad = v; }});
  return curves;
}

std::vector<const Contractions*> estimated(const ContractionTrack& track) {
  std::vector<const Contractions*> frames;
  for (const Contractions& frame : track.frames) {
    if (!frame.value.empty()) frames.push_back(&frame);
  }
  return frames;
}

// The parabola through the neighbourhood of frame t, at t.
double local_value(const std::vector<const Contractions*>& frames,
                   std::size_t t,
                   const Curve& curve,
                   double width_s) {
  constexpr double kReach = 3.0;  // widths
  constexpr double kLeastSigma = 1e-3;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  int count = 0;
  const auto add = [&](std::size_t s) {
    const double x = (frames[s]->time_s - frames[t]->time_s) / width_s;
    if (std::abs(x) > kReach) return false;
    const double sigma = std::max(kLeastSigma, curve.sigma(*frames[s]));
    const double weight = std::exp(-0.5 * x * x) / (sigma * sigma);
    const Eigen::Vector3d power(1.0, x, x * x);
    normal += weight * power * power.transpose();
    right += weight * curve.value(*frames[s]) * power;
    ++count;
    return true;
  };
  for (std::size_t s = t + 1; s-- > 0;) {
    if (!add(s)) break;
  }
  for (std::size_t s = t + 1; s < frames.size(); ++s) {
    if (!add(s)) break;
  }
  if (count < 4) return curve.value(*frames[t]);
  // The end of a clip has neighbours on one side only: a parabola would swing there.
  const double scale = normal(0, 0);
  normal(1, 1) += 1e-3 * scale;
  normal(2, 2) += 1e-2 * scale;
  return normal.inverse().row(0).dot(right);
}

}  // namespace

const std::vector<std::string>& smooth_intent_names() {
  static const std::vector<std::string> names{"responsive", "balanced", "stable"};
  return names;
}

SmoothIntent parse_smooth_intent(const std::string& name) {
  const auto& names = smooth_intent_names();
  const int place = find_name(names, name);
  require(place >= 0, "smoothing is '" + name + "'; expected responsive, balanced or stable");
  return static_cast<SmoothIntent>(place);
}

double smoothing_width_s(SmoothIntent intent) {
  switch (intent) {
    case SmoothIntent::kResponsive:
      return 0.03;
    case SmoothIntent::kBalanced:
      return 0.06;
    case SmoothIntent::kStable:
      return 0.12;
  }
  return 0.06;
}

ContractionTrack smooth_track(const ContractionTrack& track, SmoothIntent intent) {
  ContractionTrack result = track;
  const std::vector<const Contractions*> frames = estimated(track);
  for (const Curve& curve : curves_of(track)) {
    std::size_t t = 0;
    for (Contractions& out : result.frames) {
      if (out.value.empty()) continue;
      curve.set(out, local_value(frames, t, curve, smoothing_width_s(intent)));
      ++t;
    }
  }
  return result;
}

OneEuroOptions one_euro_options(SmoothIntent intent) {
  switch (intent) {
    case SmoothIntent::kResponsive:
      return {3.0, 3.0, 1.0};
    case SmoothIntent::kBalanced:
      return {1.5, 1.5, 1.0};
    case SmoothIntent::kStable:
      return {0.7, 0.7, 1.0};
  }
  return {};
}

double OneEuro::operator()(double value, double time_s) {
  if (!has_last_) {
    has_last_ = true;
    last_time_s_ = time_s;
    return value_ = value;
  }
  constexpr double kLeastStep_s = 1e-6;
  const double step_s = std::max(kLeastStep_s, time_s - last_time_s_);
  const auto share = [&](double cutoff_hz) {
    return 1.0 / (1.0 + 1.0 / (2.0 * std::numbers::pi * cutoff_hz * step_s));
  };
  const double speed = (value - value_) / step_s;
  speed_ += share(options_.speed_cutoff_hz) * (speed - speed_);
  const double cutoff_hz = options_.lowest_cutoff_hz + options_.beta * std::abs(speed_);
  value_ += share(cutoff_hz) * (value - value_);
  last_time_s_ = time_s;
  return value_;
}

ContractionTrack smooth_track_live(const ContractionTrack& track, SmoothIntent intent) {
  ContractionTrack result = track;
  for (const Curve& curve : curves_of(track)) {
    OneEuro filter(one_euro_options(intent));
    for (Contractions& out : result.frames) {
      if (!out.value.empty()) curve.set(out, filter(curve.value(out), out.time_s));
    }
  }
  return result;
}

}  // namespace zygoma
