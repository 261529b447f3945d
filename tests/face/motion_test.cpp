#include "face/motion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "face/muscle_table.h"
#include "src/base/check.h"

namespace zygoma {
namespace {

TEST(MonotoneCurve, MeetsTheKeysWithOneSlopeAndStaysBetweenThem) {
  const std::vector<double> time{0.0, 0.1, 1.0, 1.2, 2.0, 4.0};
  const std::vector<double> value{0.0, 0.9, 1.0, 1.0, 0.2, 0.0};
  for (std::size_t k = 0; k < time.size(); ++k) {
    EXPECT_EQ(monotone_curve(time, value, time[k]), value[k]);
  }
  EXPECT_EQ(monotone_curve(time, value, -1.0), 0.0);
  EXPECT_EQ(monotone_curve(time, value, 9.0), 0.0);
  const double h = 1e-6;
  for (std::size_t k = 1; k + 1 < time.size(); ++k) {
    const double before = (value[k] - monotone_curve(time, value, time[k] - h)) / h;
    const double after = (monotone_curve(time, value, time[k] + h) - value[k]) / h;
    EXPECT_NEAR(before, after, 1e-3) << "key " << k;
  }
  for (std::size_t k = 0; k + 1 < time.size(); ++k) {
    const double direction = value[k + 1] - value[k];
    double last = value[k];
    for (double t = time[k]; t <= time[k + 1]; t += 1e-3) {
      const double now = monotone_curve(time, value, t);
      EXPECT_GE((now - last) * direction, 0.0) << "at " << t;
      EXPECT_LE(now, 1.0);
      EXPECT_GE(now, 0.0);
      last = now;
    }
  }
}

TEST(MonotoneCurve, AStraightRowOfKeysIsALineBetweenItsEnds) {
  const std::vector<double> time{0.0, 1.0, 2.0, 3.0};
  const std::vector<double> value{0.0, 0.25, 0.5, 0.75};
  for (double t = 1.0; t <= 2.0; t += 0.125) {
    EXPECT_NEAR(monotone_curve(time, value, t), 0.25 * t, 1e-15);
  }
}

TEST(Motion, AMuscleThatAKeyDoesNotNameIsSlackThere) {
  Motion motion;
  motion.frames_per_s = 10.0;
  motion.keys = {{0.0, 0.0, {}}, {1.0, 0.5, {{"zygomaticus_major_L", 1.0}}}, {2.0, 0.0, {}}};
  const ContractionTrack track = sample_motion(motion, standard_muscle_names());
  ASSERT_EQ(track.frames.size(), 21U);
  EXPECT_EQ(track.muscles.front(), "zygomaticus_major_L");
  EXPECT_EQ(track.frames[0].value[0], 0.0);
  EXPECT_EQ(track.frames[10].value[0], 1.0);
  EXPECT_EQ(track.frames[10].value[1], 0.0);
  EXPECT_EQ(track.frames[10].jaw, 0.5);
  EXPECT_EQ(track.frames[5].value[0], 0.5);
  EXPECT_EQ(track.frames[20].value[0], 0.0);
  EXPECT_DOUBLE_EQ(track.frames[7].time_s, 0.7);
}

TEST(Motion, HoldsTheLastPoseForItsDuration) {
  Motion motion;
  motion.keys = {{0.0, 0.25, {}}};
  EXPECT_EQ(sample_motion(motion, {}).frames.size(), 1U);
  motion.duration_s = 1.0;
  const ContractionTrack track = sample_motion(motion, {});
  ASSERT_EQ(track.frames.size(), 31U);
  EXPECT_EQ(track.frames.back().jaw, 0.25);
}

TEST(Motion, RefusesWhatIsNoMotion) {
  Motion motion;
  EXPECT_THROW(motion.check(), InputError);
  motion.keys = {{0.0, 0.0, {{"smiler", 0.5}}}};
  motion.check();
  EXPECT_THROW(sample_motion(motion, standard_muscle_names()), InputError);
  motion.keys = {{0.0, NAN, {}}};
  EXPECT_THROW(motion.check(), InputError);
}

}  // namespace
}  // namespace zygoma
