#include "retarget/retarget.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <random>

#include "src/base/check.h"
#include "tests/retarget/fake_face.h"

namespace zygoma {
namespace {

constexpr double kFrame_s = 1.0 / 30.0;

double pulse(double t, double start, double rise, double hold) {
  const auto step = [](double x) {
    x = std::clamp(x, 0.0, 1.0);
    return x * x * x * (10.0 - 15.0 * x + 6.0 * x * x);
  };
  return step((t - start) / rise) - step((t - start - rise - hold) / rise);
}

struct Clip {
  std::vector<ContourSet> contours;
  std::vector<Eigen::VectorXd> truth;
};

using Script = std::function<void(double, Eigen::VectorXd&)>;
using HeadPath = std::function<HeadMotion(double)>;

HeadMotion still_head(double) { return fake::camera(1.1); }

Clip perform(const FaceResponse& face,
             double duration_s,
             const Script& script,
             const HeadPath& head) {
  Clip clip;
  const int n = static_cast<int>(duration_s / kFrame_s);
  for (int t = 0; t < n; ++t) {
    Eigen::VectorXd controls = Eigen::VectorXd::Zero(face.num_controls());
    script(t * kFrame_s, controls);
    clip.contours.push_back(fake::observe(face, controls, head(t * kFrame_s), t, t * kFrame_s));
    clip.truth.push_back(controls);
  }
  return clip;
}

int muscle(const std::string& name) {
  const auto& names = fake::muscle_names();
  return static_cast<int>(std::find(names.begin(), names.end(), name) - names.begin());
}

// Rest, brows, smile, frown, surprise, rest.
void mixed(double t, Eigen::VectorXd& u) {
  const double brow = pulse(t, 0.7, 0.3, 0.3);
  const double surprise = pulse(t, 4.0, 0.3, 0.3);
  for (const char* side : {"_L", "_R"}) {
    const std::string s(side);
    for (const char* part : {"inner", "major", "outer"}) {
      u[muscle(std::string("occipitofrontalis_") + part + s)] = 0.7 * brow + 0.9 * surprise;
    }
    u[muscle("zygomaticus_major" + s)] = (s == "_L" ? 0.8 : 0.65) * pulse(t, 1.8, 0.3, 0.3);
    u[muscle("corrugator_supercilii" + s)] = 0.6 * pulse(t, 2.9, 0.3, 0.3);
    u[muscle("depressor_anguli_oris" + s)] = 0.6 * pulse(t, 2.9, 0.3, 0.3);
  }
  u[u.size() - 1] = 0.7 * surprise;
}

double rms_error(const Clip& clip, const ContractionTrack& track) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t t = 0; t < clip.truth.size(); ++t) {
    const Contractions& c = track.frames[t];
    for (std::size_t i = 0; i < c.value.size(); ++i) {
      sum += std::pow(c.value[i] - clip.truth[t][static_cast<Eigen::Index>(i)], 2);
      ++count;
    }
    sum += std::pow(c.jaw - clip.truth[t][clip.truth[t].size() - 1], 2);
    ++count;
  }
  return std::sqrt(sum / count);
}

void add_noise(Clip& clip, double sigma_px, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, sigma_px);
  for (ContourSet& set : clip.contours) {
    for (Contour& contour : set.contours) {
      for (Point2& p : contour.points_px) p += Point2(normal(random), normal(random));
    }
  }
}

double largest(const ContractionTrack& track) {
  double result = 0.0;
  for (const Contractions& c : track.frames) {
    for (const double v : c.value) result = std::max(result, v);
    result = std::max(result, c.jaw);
  }
  return result;
}

TEST(Retarget, HeadMotionAloneContractsNothing) {
  const FaceResponse face = fake::make_face();
  const HeadPath head = [](double t) {
    return fake::camera(1.1 * (1.0 + 0.3 * std::sin(1.3 * t)),
                        0.35 * std::sin(t),
                        {320.0 + 80.0 * std::sin(0.7 * t), 150.0 + 30.0 * std::cos(t)});
  };
  const Clip clip = perform(
      face, 4.0, [](double, Eigen::VectorXd&) {}, head);
  RetargetReport report;
  const ContractionTrack track = retarget(clip.contours, {face}, {}, report);
  EXPECT_LT(largest(track), 0.02);
  for (std::size_t t = 0; t < track.frames.size(); ++t) {
    const HeadMotion relative =
        head(static_cast<double>(t) * kFrame_s) * head(report.neutral_frame * kFrame_s).inverse();
    EXPECT_NEAR(track.frames[t].head.scale, relative.scale(), 2e-3);
    EXPECT_NEAR(track.frames[t].head.roll_rad, relative.roll_rad(), 2e-3);
  }
}

TEST(Retarget, KnownPerformanceOfTheSameFaceIsRecovered) {
  const FaceResponse face = fake::make_face();
  const Clip clip = perform(face, 5.3, mixed, still_head);
  RetargetReport report;
  const ContractionTrack track = retarget(clip.contours, {face}, {}, report);
  EXPECT_LT(rms_error(clip, track), 0.03);
  EXPECT_EQ(report.frames_not_converged, 0);
  EXPECT_EQ(report.frames_estimated, static_cast<int>(clip.contours.size()));
  EXPECT_LT(report.neutral_frame, 25);
  EXPECT_NEAR(report.millimetre_per_px, 1.0 / 1.1, 1e-3);
  for (int t = 0; t < 15; ++t) {
    for (const double v : track.frames[static_cast<std::size_t>(t)].value) EXPECT_LT(v, 0.02);
  }
  for (const Contractions& c : track.frames) {
    ASSERT_EQ(c.value.size(), face.muscles.size());
    ASSERT_EQ(c.sigma.size(), face.muscles.size());
    EXPECT_TRUE(c.success);
    for (const double s : c.sigma) {
      EXPECT_GT(s, 0.0);
      EXPECT_LT(s, 1.0);
    }
  }
}

TEST(Retarget, NoiseOfHalfAPixelStaysWithinTheGoal) {
  const FaceResponse face = fake::make_face();
  Clip clip = perform(face, 5.3, mixed, still_head);
  add_noise(clip, 0.5, 7);
  RetargetReport report;
  const ContractionTrack track = retarget(clip.contours, {face}, {}, report);
  EXPECT_LT(rms_error(clip, track), 0.06);
}

TEST(Retarget, AnotherIdentityIsRecovered) {
  const FaceResponse performer = fake::make_other_face(1.1, 0.94, 4.0);
  const Clip clip = perform(
      performer, 5.3, mixed, [](double t) { return fake::camera(1.3, 0.1 + 0.05 * std::sin(t)); });
  const FaceResponse usual = fake::make_face();
  RetargetReport report;
  const ContractionTrack track = retarget(clip.contours, {usual}, {}, report);
  EXPECT_LT(rms_error(clip, track), 0.06);
}

TEST(Retarget, OneSidedSmileStaysOnItsSide) {
  const FaceResponse face = fake::make_face();
  for (const auto& [moving, still] : {std::pair{"zygomaticus_major_L", "zygomaticus_major_R"},
                                      std::pair{"zygomaticus_major_R", "zygomaticus_major_L"}}) {
    const int m = muscle(moving);
    const Clip clip = perform(
        face,
        2.5,
        [m](double t, Eigen::VectorXd& u) { u[m] = 0.8 * pulse(t, 0.8, 0.4, 0.4); },
        still_head);
    RetargetReport report;
    const ContractionTrack track = retarget(clip.contours, {face}, {}, report);
    const std::size_t peak = 40;
    EXPECT_NEAR(track.frames[peak].value[static_cast<std::size_t>(m)], 0.8, 0.06);
    EXPECT_LT(track.frames[peak].value[static_cast<std::size_t>(muscle(still))], 0.04);
  }
}

TEST(Retarget, LostBrowLeavesItsMusclesUncertainAndTheRestAlone) {
  const FaceResponse face = fake::make_face();
  Clip clip = perform(
      face,
      3.0,
      [](double t, Eigen::VectorXd& u) {
        u[muscle("zygomaticus_major_L")] = 0.7 * pulse(t, 0.8, 0.3, 0.8);
      },
      still_head);
  for (std::size_t t = 40; t < 50; ++t) {
    clip.contours[t].contours[0].points_px.clear();
    clip.contours[t].contours[0].confidence = 0.0;
  }
  RetargetReport report;
  const ContractionTrack track = retarget(clip.contours, {face}, {}, report);
  const auto brow = static_cast<std::size_t>(muscle("occipitofrontalis_major_L"));
  const auto smile = static_cast<std::size_t>(muscle("zygomaticus_major_L"));
  EXPECT_GT(track.frames[45].sigma[brow], 2.0 * track.frames[30].sigma[brow]);
  EXPECT_LT(track.frames[45].value[brow], 0.05);
  EXPECT_FALSE(track.frames[45].success);
  EXPECT_EQ(track.frames[45].confidence, 0.0);
  EXPECT_NEAR(track.frames[45].value[smile], 0.7, 0.06);
  EXPECT_EQ(track.frames[45].residual_px.size(), 8U);
  EXPECT_FALSE(track.frames[45].observed[brow]);
  EXPECT_TRUE(track.frames[45].observed[smile]);
}

TEST(Retarget, AFurrowOfLowConfidenceDrivesNothing) {
  const FaceResponse face = fake::make_face();
  Clip clip = perform(
      face, 2.0, [](double, Eigen::VectorXd&) {}, still_head);
  for (std::size_t t = 20; t < clip.contours.size(); ++t) {
    Contour& furrow = clip.contours[t].contours[2];
    furrow.confidence = 0.25;
    for (Point2& p : furrow.points_px) p.y() -= 9.0;
  }
  RetargetOptions options;
  options.neutral_frame = 5;
  RetargetReport report;
  EXPECT_LT(largest(retarget(clip.contours, {face}, options, report)), 0.02);
}

TEST(Retarget, AnOutlierContourDisturbsOnlyItsOwnMuscle) {
  const FaceResponse face = fake::make_face();
  Clip clip = perform(
      face, 2.0, [](double, Eigen::VectorXd&) {}, still_head);
  for (std::size_t t = 30; t < 40; ++t) {
    for (Point2& p : clip.contours[t].contours[2].points_px) p += Point2(14.0, -10.0);
  }
  RetargetOptions options;
  options.neutral_frame = 5;
  RetargetReport report;
  ContractionTrack track = retarget(clip.contours, {face}, options, report);
  for (Contractions& c : track.frames) {
    c.value[static_cast<std::size_t>(muscle("levator_labii_superioris_alaeque_nasi_L"))] = 0.0;
  }
  EXPECT_LT(largest(track), 0.1);
}

TEST(Retarget, FramesWithoutContoursStayEmptyAndCounted) {
  const FaceResponse face = fake::make_face();
  Clip clip = perform(
      face, 2.0, [](double, Eigen::VectorXd&) {}, still_head);
  clip.contours[10].contours.clear();
  for (Contour& contour : clip.contours[11].contours) {
    contour.points_px.clear();
    contour.confidence = 0.0;
  }
  RetargetReport report;
  const ContractionTrack track = retarget(clip.contours, {face}, {}, report);
  ASSERT_EQ(track.frames.size(), clip.contours.size());
  for (const std::size_t t : {10U, 11U}) {
    EXPECT_TRUE(track.frames[t].value.empty());
    EXPECT_FALSE(track.frames[t].success);
    EXPECT_EQ(track.frames[t].frame_index, static_cast<int>(t));
  }
  EXPECT_EQ(report.frames_estimated, static_cast<int>(clip.contours.size()) - 2);
  for (ContourSet& set : clip.contours) set.contours.clear();
  EXPECT_THROW(retarget(clip.contours, {face}, {}, report), InputError);
}

TEST(Retarget, NeutralIsFoundInsideTheClipWhenItStartsWithAnExpression) {
  const FaceResponse face = fake::make_face();
  const Clip clip = perform(
      face,
      4.0,
      [](double t, Eigen::VectorXd& u) {
        const double s = 1.0 - pulse(t, 1.0, 0.4, 10.0);
        u[muscle("zygomaticus_major_L")] = u[muscle("zygomaticus_major_R")] = 0.8 * s;
        u[u.size() - 1] = 0.3 * s;
      },
      still_head);
  RetargetReport report;
  const ContractionTrack track = retarget(clip.contours, {face}, {}, report);
  EXPECT_GT(report.neutral_frame, 40);
  EXPECT_NEAR(track.frames[5].value[0], 0.8, 0.08);
}

TEST(Retarget, ClosedFormAloneFollowsThePaper) {
  const FaceResponse face = fake::make_face();
  const Clip clip = perform(
      face,
      2.5,
      [](double t, Eigen::VectorXd& u) {
        u[muscle("zygomaticus_major_R")] = 0.7 * pulse(t, 0.8, 0.4, 0.4);
        u[u.size() - 1] = 0.5 * pulse(t, 0.8, 0.4, 0.4);
      },
      still_head);
  RetargetOptions options;
  options.refine = false;
  RetargetReport report;
  const ContractionTrack track = retarget(clip.contours, {face}, options, report);
  EXPECT_NEAR(track.frames[40].value[1], 0.7, 0.12);
  EXPECT_NEAR(track.frames[40].jaw, 0.5, 0.1);
  EXPECT_LT(track.frames[40].value[0], 0.05);
  EXPECT_TRUE(track.frames[40].sigma.empty());
}

TEST(Retarget, BadNeutralFrameIsNamed) {
  const FaceResponse face = fake::make_face();
  const Clip clip = perform(
      face, 1.0, [](double, Eigen::VectorXd&) {}, still_head);
  RetargetOptions options;
  options.neutral_frame = 500;
  RetargetReport report;
  EXPECT_THROW(retarget(clip.contours, {face}, options, report), InputError);
  options.neutral_frame = -2;
  EXPECT_THROW(retarget(clip.contours, {face}, options, report), InputError);
}

TEST(Retarget, SameBitsOnRepetitionAndStopsWhenAsked) {
  const FaceResponse face = fake::make_face();
  Clip clip = perform(face, 1.5, mixed, still_head);
  add_noise(clip, 0.5, 3);
  RetargetReport report;
  const ContractionTrack first = retarget(clip.contours, {face}, {}, report);
  EXPECT_EQ(first, retarget(clip.contours, {face}, {}, report));
  int asked = 0;
  double last = 0.0;
  const ContractionTrack stopped = retarget(clip.contours, {face}, {}, report, [&](double done) {
    EXPECT_GE(done, last);
    last = done;
    return ++asked > 10;
  });
  EXPECT_EQ(stopped.frames.size(), 10U);
  EXPECT_LT(last, 0.5);
}

}  // namespace
}  // namespace zygoma
