#include "retarget/smooth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "src/base/check.h"

namespace zygoma {
namespace {

constexpr double kStep_s = 1.0 / 30.0;

ContractionTrack track_of(const std::vector<double>& curve) {
  ContractionTrack track;
  track.muscles = {"zygomaticus_major_L", "zygomaticus_major_R"};
  for (std::size_t t = 0; t < curve.size(); ++t) {
    Contractions frame;
    frame.frame_index = static_cast<int>(t);
    frame.time_s = static_cast<double>(t) * kStep_s;
    frame.value = {curve[t], 0.0};
    frame.sigma = {0.1, 0.1};
    frame.jaw_sigma = 0.1;
    track.frames.push_back(frame);
  }
  return track;
}

double pulse(double t) { return 0.8 * std::exp(-std::pow((t - 1.5) / 0.25, 2)); }

std::vector<double> pulses(double noise) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0.0, 1.0);
  std::vector<double> curve;
  for (int t = 0; t < 90; ++t) {
    curve.push_back(std::clamp(pulse(t * kStep_s) + noise * normal(random), 0.0, 1.0));
  }
  return curve;
}

double rms_from_pulse(const ContractionTrack& track) {
  double sum = 0.0;
  for (const Contractions& frame : track.frames) {
    sum += std::pow(frame.value[0] - pulse(frame.time_s), 2);
  }
  return std::sqrt(sum / static_cast<double>(track.frames.size()));
}

double peak_time(const ContractionTrack& track) {
  double moment = 0.0;
  double mass = 0.0;
  for (const Contractions& frame : track.frames) {
    moment += frame.value[0] * frame.time_s;
    mass += frame.value[0];
  }
  return moment / mass;
}

TEST(SmoothTrack, TakesNoiseAwayWithoutDelay) {
  const ContractionTrack raw = track_of(pulses(0.05));
  const ContractionTrack smooth = smooth_track(raw, SmoothIntent::kBalanced);
  EXPECT_LT(rms_from_pulse(smooth), 0.7 * rms_from_pulse(raw));
  const ContractionTrack clean = track_of(pulses(0.0));
  EXPECT_NEAR(peak_time(smooth_track(clean, SmoothIntent::kStable)), peak_time(clean), 1e-3);
}

TEST(SmoothTrack, StrongerIntentsAreSmoother) {
  const ContractionTrack raw = track_of(std::vector<double>(pulses(0.05)));
  const auto roughness = [](const ContractionTrack& track) {
    double sum = 0.0;
    for (std::size_t t = 1; t + 1 < track.frames.size(); ++t) {
      sum += std::abs(track.frames[t - 1].value[0] - 2.0 * track.frames[t].value[0] +
                      track.frames[t + 1].value[0]);
    }
    return sum;
  };
  const double responsive = roughness(smooth_track(raw, SmoothIntent::kResponsive));
  const double balanced = roughness(smooth_track(raw, SmoothIntent::kBalanced));
  const double stable = roughness(smooth_track(raw, SmoothIntent::kStable));
  EXPECT_LT(responsive, roughness(raw));
  EXPECT_LT(balanced, responsive);
  EXPECT_LT(stable, balanced);
}

TEST(SmoothTrack, UncertainFramesDoNotPullSureOnes) {
  ContractionTrack track = track_of(std::vector<double>(60, 0.2));
  for (std::size_t t = 30; t < 33; ++t) {
    track.frames[t].value[0] = 0.9;
    track.frames[t].sigma[0] = 2.0;
  }
  const ContractionTrack smooth = smooth_track(track, SmoothIntent::kBalanced);
  EXPECT_NEAR(smooth.frames[28].value[0], 0.2, 0.01);
  EXPECT_NEAR(smooth.frames[31].value[0], 0.2, 0.05);
}

TEST(SmoothTrack, FramesWithoutEstimateStayEmpty) {
  ContractionTrack track = track_of(std::vector<double>(20, 0.3));
  track.frames[7].value.clear();
  track.frames[7].sigma.clear();
  for (const ContractionTrack& smooth : {smooth_track(track, SmoothIntent::kStable),
                                         smooth_track_live(track, SmoothIntent::kStable)}) {
    EXPECT_TRUE(smooth.frames[7].value.empty());
    EXPECT_NEAR(smooth.frames[8].value[0], 0.3, 1e-9);
  }
}

// One-Euro against its definition, for a signal whose answer is known: a step through a low-pass of
// constant cutoff is 1 - (1 - a)^n.
TEST(OneEuro, AStepFollowsTheLowPass) {
  OneEuroOptions options;
  options.lowest_cutoff_hz = 2.0;
  OneEuro filter(options);
  EXPECT_EQ(filter(0.0, 0.0), 0.0);
  const double share = 1.0 / (1.0 + 1.0 / (2.0 * 3.14159265358979 * 2.0 * kStep_s));
  for (int n = 1; n < 20; ++n) {
    EXPECT_NEAR(filter(1.0, n * kStep_s), 1.0 - std::pow(1.0 - share, n), 1e-12);
  }
}

TEST(OneEuro, FastMotionLagsLessWithBeta) {
  const ContractionTrack raw = track_of(pulses(0.0));
  const double slow = peak_time(smooth_track_live(raw, SmoothIntent::kStable));
  const double quick = peak_time(smooth_track_live(raw, SmoothIntent::kResponsive));
  EXPECT_GT(slow, peak_time(raw));
  EXPECT_LT(quick, slow);
}

TEST(SmoothIntents, WordsAreChecked) {
  EXPECT_EQ(parse_smooth_intent("stable"), SmoothIntent::kStable);
  EXPECT_THROW(parse_smooth_intent("silky"), InputError);
}

}  // namespace
}  // namespace zygoma
