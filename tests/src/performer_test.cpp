#include "src/synthetic/performer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/core.hpp>

#include "src/base/check.h"
#include "src/synthetic/person.h"
#include "src/synthetic/random.h"
#include "src/synthetic/schedule.h"
#include "tracker/feature_schema.h"

namespace zygoma {
namespace {

PerformerOptions quick(const std::string& schedule, double duration_s) {
  PerformerOptions options;
  options.schedule = schedule;
  options.duration_s = duration_s;
  options.frames_per_s = 10.0;
  options.width_px = 160;
  options.height_px = 120;
  options.num_surface_vertices = 300;
  return options;
}

TEST(Schedule, StartsAndEndsAtRestAndStaysInRange) {
  for (const std::string& name : schedule_names()) {
    for (const double duration_s : {1.0, 6.0, 20.0}) {
      const Schedule schedule = make_schedule(name, duration_s, 7);
      double largest = 0.0;
      for (const Pulse& pulse : schedule.pulses) {
        EXPECT_EQ(schedule.value_at(pulse.muscle, 0.0), 0.0);
        EXPECT_NEAR(schedule.value_at(pulse.muscle, duration_s), 0.0, 1e-9) << name;
        for (int i = 0; i <= 200; ++i) {
          const double value = schedule.value_at(pulse.muscle, duration_s * i / 200.0);
          ASSERT_GE(value, 0.0);
          ASSERT_LE(value, 1.0);
          largest = std::max(largest, value);
        }
      }
      EXPECT_EQ(schedule.pulses.empty(), name == "neutral") << name << " over " << duration_s;
      EXPECT_EQ(largest > 0.0, name != "neutral" && !schedule.pulses.empty()) << name;
    }
  }
}

TEST(Schedule, MixedHasTheExpressionsOfItsName) {
  const Schedule schedule = make_schedule("mixed", 6.0, 3);
  const auto peak = [&](const std::string& muscle) {
    double largest = 0.0;
    for (int i = 0; i <= 600; ++i) largest = std::max(largest, schedule.value_at(muscle, 0.01 * i));
    return largest;
  };
  EXPECT_GT(peak("occipitofrontalis_inner_L"), 0.7);
  EXPECT_GT(peak("zygomaticus_major_L"), 0.4);
  EXPECT_GT(peak("zygomaticus_major_R"), 0.4);
  EXPECT_GT(peak("corrugator_supercilii_R"), 0.4);
  EXPECT_GT(peak("depressor_anguli_oris_L"), 0.4);
  EXPECT_GT(peak(""), 0.4);
  for (const Pulse& pulse : schedule.pulses) {
    EXPECT_EQ(schedule.value_at(pulse.muscle, 0.59), 0.0) << "neutral start";
  }
}

TEST(Schedule, UnknownNameIsRefused) { EXPECT_THROW(make_schedule("dance", 1.0, 1), InputError); }

TEST(RandomStream, NormalHasUnitVariance) {
  RandomStream random(1, 2);
  double sum = 0.0;
  double square = 0.0;
  constexpr int kDraws = 200000;
  for (int i = 0; i < kDraws; ++i) {
    const double x = random.normal();
    sum += x;
    square += x * x;
  }
  EXPECT_NEAR(sum / kDraws, 0.0, 0.01);
  EXPECT_NEAR(square / kDraws, 1.0, 0.02);
}

TEST(Sway, AmountZeroIsStillAndOneIsModest) {
  EXPECT_TRUE(Sway(5, 0.0).head_at(2.0).matrix().isIdentity(1e-12));
  for (int i = 0; i < 100; ++i) {
    const Eigen::Isometry3d head = Sway(5, 1.0).head_at(0.1 * i);
    EXPECT_LT(Eigen::AngleAxisd(head.linear()).angle(), 0.15);
  }
}

TEST(Identity, EverySeedIsAPersonTheHeadAccepts) {
  for (std::uint32_t seed = 0; seed < 200; ++seed) EXPECT_NO_THROW(draw_identity(seed).check());
}

TEST(Performer, TruthAndContoursBelongToThePicture) {
  Performer performer(quick("surprise", 1.0));
  EXPECT_EQ(performer.num_frames(), 10);
  Frame frame;
  Contractions truth;
  ContourSet contours;
  int count = 0;
  double largest_jaw = 0.0;
  while (performer.next(frame, truth, contours)) {
    EXPECT_EQ(frame.index, count);
    EXPECT_NEAR(frame.time_s, 0.1 * count, 1e-12);
    EXPECT_EQ(frame.image.size(), cv::Size(160, 120));
    EXPECT_EQ(frame.image.type(), CV_8UC3);
    ASSERT_EQ(truth.value.size(), performer.muscles().size());
    for (const double value : truth.value) {
      EXPECT_GE(value, 0.0);
      EXPECT_LE(value, 1.0);
      EXPECT_TRUE(count > 0 || value == 0.0);
    }
    if (count == 0) {
      EXPECT_NEAR(truth.head.scale, 1.0, 1e-12);
      EXPECT_NEAR(truth.head.roll_rad, 0.0, 1e-12);
    }
    largest_jaw = std::max(largest_jaw, truth.jaw);
    ASSERT_EQ(contours.contours.size(), kFeatureSchema.size());
    for (std::size_t c = 0; c < kFeatureSchema.size(); ++c) {
      const Contour& contour = contours.contours[c];
      EXPECT_EQ(contour.name, kFeatureSchema[c].name);
      ASSERT_EQ(static_cast<int>(contour.points_px.size()), kFeatureSchema[c].num_nodes);
      for (const Point2& p : contour.points_px) {
        EXPECT_TRUE(p.x() > 0 && p.x() < 159 && p.y() > 0 && p.y() < 119) << contour.name;
      }
    }
    const auto mean_y = [&](const char* name) {
      double sum = 0.0;
      for (const Point2& p : contours.visible(name)->points_px) sum += p.y();
      return sum / static_cast<double>(contours.visible(name)->points_px.size());
    };
    EXPECT_LT(mean_y("hairline"), mean_y("brow_left"));
    EXPECT_LT(mean_y("brow_left"), mean_y("nose_tip"));
    EXPECT_LT(mean_y("upper_lip"), mean_y("lower_lip"));
    EXPECT_LT(mean_y("lower_lip"), mean_y("chin_boss"));
    // The subject's left is on the right of the picture; brows run outwards.
    const Contour& brow = *contours.visible("brow_left");
    EXPECT_LT(brow.points_px.front().x(), brow.points_px.back().x());
    EXPECT_GT(brow.points_px.front().x(), contours.visible("brow_right")->points_px.front().x());
    ++count;
  }
  EXPECT_EQ(count, 10);
  EXPECT_GT(largest_jaw, 0.3);
}

TEST(Performer, SameSeedSameBitsForAnyThreadsAndOtherSeedOtherPerson) {
  PerformerOptions options = quick("smile", 0.2);
  options.num_threads = 1;
  Performer one(options);
  options.num_threads = 3;
  Performer same(options);
  options.seed = 2;
  Performer other(options);
  Frame a;
  Frame b;
  Frame c;
  Contractions truth_a;
  Contractions truth_b;
  ContourSet contours_a;
  ContourSet contours_b;
  ContourSet contours_c;
  while (one.next(a, truth_a, contours_a)) {
    ASSERT_TRUE(same.next(b, truth_b, contours_b));
    EXPECT_EQ(cv::norm(a.image, b.image, cv::NORM_INF), 0.0);
    EXPECT_EQ(contours_a, contours_b);
    EXPECT_EQ(truth_a, truth_b);
    if (a.index > 0) continue;
    ASSERT_TRUE(other.next(c, truth_b, contours_c));
    EXPECT_FALSE(contours_a == contours_c);
  }
}

TEST(Performer, OptionsOutOfRangeAreNamed) {
  PerformerOptions options;
  options.duration_s = 0.0;
  EXPECT_THROW(options.check(), InputError);
  options = {};
  options.schedule = "dance";
  EXPECT_THROW(options.check(), InputError);
  options = {};
  options.noise_grey_levels = -1.0;
  EXPECT_THROW(options.check(), InputError);
}

}  // namespace
}  // namespace zygoma
