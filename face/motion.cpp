#include "face/motion.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "face/muscle.h"
#include "src/base/names.h"

namespace zygoma {
namespace {

constexpr double kLongest_s = 3600.0;
constexpr double kSmallestGap_s = 1e-6;

double duration_of(const Motion& motion) {
  return motion.duration_s > 0.0 ? motion.duration_s : motion.keys.back().time_s;
}

// Of the curve at key k.
double slope_at(const std::vector<double>& time, const std::vector<double>& value, std::size_t k) {
  if (k == 0 || k + 1 == time.size()) return 0.0;
  const double before = time[k] - time[k - 1];
  const double after = time[k + 1] - time[k];
  const double rise_before = (value[k] - value[k - 1]) / before;
  const double rise_after = (value[k + 1] - value[k]) / after;
  if (rise_before * rise_after <= 0.0) return 0.0;
  return 3.0 * (before + after) /
         ((2.0 * after + before) / rise_before + (after + 2.0 * before) / rise_after);
}

}  // namespace

void Motion::check() const {
  require_range("frames_per_s", frames_per_s, 1.0, 1000.0);
  require_range("duration_s", duration_s, 0.0, kLongest_s);
  require(!keys.empty(), "keys: none, expected at least one pose");
  for (std::size_t k = 0; k < keys.size(); ++k) {
    const std::string name = "keys[" + std::to_string(k) + "]";
    require_range(name + ".time_s", keys[k].time_s, 0.0, kLongest_s);
    if (k > 0) {
      const double before_s = keys[k - 1].time_s;
      require(keys[k].time_s >= before_s + kSmallestGap_s,
              name + ".time_s is " + shortest_text(keys[k].time_s) +
                  ", expected later than the key before (" + shortest_text(before_s) + ")");
    }
    require_range(name + ".jaw", keys[k].jaw, 0.0, 1.0);
    for (const auto& [muscle, value] : keys[k].contraction) {
      require_range(name + ".contractions." + muscle, value, 0.0, 1.0);
    }
  }
  const double num_frames = duration_of(*this) * frames_per_s;
  require(num_frames < kMostFrames,
          "duration_s x frames_per_s is " + shortest_text(num_frames) + " frames, expected below " +
              std::to_string(kMostFrames));
}

double monotone_curve(const std::vector<double>& time,
                      const std::vector<double>& value,
                      double at) {
  if (at <= time.front()) return value.front();
  if (at >= time.back()) return value.back();
  const std::size_t k = std::upper_bound(time.begin(), time.end(), at) - time.begin() - 1;
  const double length = time[k + 1] - time[k];
  const double t = (at - time[k]) / length;
  const double rise = value[k + 1] - value[k];
  const double d0 = length * slope_at(time, value, k);
  const double d1 = length * slope_at(time, value, k + 1);
  const double curve =
      value[k] + t * (d0 + t * (3.0 * rise - 2.0 * d0 - d1 + t * (d0 + d1 - 2.0 * rise)));
  const auto [low, high] = std::minmax(value[k], value[k + 1]);
  return std::clamp(curve, low, high);  // of rounding alone
}

std::vector<std::string> muscles_used(const Motion& motion,
                                      const std::vector<std::string>& muscles) {
  std::set<std::string_view> pairs;
  for (const MotionKey& key : motion.keys) {
    for (const auto& [muscle, value] : key.contraction) pairs.insert(without_side(muscle));
  }
  std::vector<std::string> used;
  for (const std::string& muscle : muscles) {
    if (pairs.contains(without_side(muscle))) used.push_back(muscle);
  }
  return used.empty() ? muscles : used;
}

ContractionTrack sample_motion(const Motion& motion, const std::vector<std::string>& muscles) {
  motion.check();
  std::vector<double> times;
  std::vector<double> jaw;
  std::vector<std::vector<double>> values(muscles.size());
  for (const MotionKey& key : motion.keys) {
    times.push_back(key.time_s);
    jaw.push_back(key.jaw);
    for (std::vector<double>& value : values) value.push_back(0.0);
    for (const auto& [muscle, value] : key.contraction) {
      const int at = find_name(muscles, muscle);
      require(at >= 0, "muscle '" + muscle + "': this face has no muscle of that name");
      values[at].back() = value;
    }
  }
  ContractionTrack track{muscles, {}};
  const int last = static_cast<int>(std::lround(duration_of(motion) * motion.frames_per_s));
  for (int i = 0; i <= last; ++i) {
    Contractions frame;
    frame.frame_index = i;
    frame.time_s = i / motion.frames_per_s;
    frame.confidence = 1.0;
    frame.success = true;
    frame.jaw = monotone_curve(times, jaw, frame.time_s);
    for (const auto& value : values) {
      frame.value.push_back(monotone_curve(times, value, frame.time_s));
    }
    track.frames.push_back(std::move(frame));
  }
  return track;
}

}  // namespace zygoma
