#include <gtest/gtest.h>

#include <stdexcept>

#include "src/base/check.h"
#include "src/pipeline/animate_face.h"
#include "src/pipeline/comparison.h"
#include "src/pipeline/producer.h"

namespace zygoma {
namespace {

ContractionTrack track_of(const std::vector<std::vector<double>>& values) {
  ContractionTrack track;
  track.muscles = {"zygomaticus_major_L", "zygomaticus_major_R"};
  for (std::size_t i = 0; i < values.size(); ++i) {
    Contractions frame;
    frame.frame_index = static_cast<int>(i);
    frame.time_s = static_cast<double>(i) / 30.0;
    frame.value = values[i];
    track.frames.push_back(frame);
  }
  return track;
}

Anatomy anatomy_of(const std::vector<std::string>& muscles) {
  Anatomy anatomy;
  for (const std::string& name : muscles) {
    Muscle muscle;
    muscle.name = name;
    anatomy.muscles.push_back(muscle);
  }
  return anatomy;
}

TEST(Producer, HandsOverEverythingInOrder) {
  int next = 0;
  Producer<int> numbers(2, [&]() -> std::optional<int> {
    return next < 100 ? std::optional(next++) : std::nullopt;
  });
  for (int expected = 0; expected < 100; ++expected) ASSERT_EQ(numbers.next(), expected);
  EXPECT_EQ(numbers.next(), std::nullopt);
}

TEST(Producer, PassesOnAnExceptionAfterTheItemsBeforeIt) {
  int next = 0;
  Producer<int> numbers(2, [&]() -> std::optional<int> {
    if (next == 3) throw std::runtime_error("broken");
    return next++;
  });
  for (int expected = 0; expected < 3; ++expected) ASSERT_EQ(numbers.next(), expected);
  EXPECT_THROW(numbers.next(), std::runtime_error);
}

TEST(Producer, EndsWhenNobodyTakesItsItems) {
  const Producer<int> endless(1, []() -> std::optional<int> { return 7; });
  SUCCEED();  // the destructor must return
}

TEST(ControlsFor, JoinsMusclesByName) {
  const Anatomy anatomy =
      anatomy_of({"zygomaticus_major_R", "corrugator_L", "zygomaticus_major_L"});
  ContractionTrack track = track_of({{0.25, 0.5}});
  track.frames[0].jaw = 0.5;
  const std::vector<Controls> controls = controls_for(track, anatomy);
  ASSERT_EQ(controls.size(), 1U);
  EXPECT_EQ(controls[0].contraction, (std::vector<double>{0.5, 0.0, 0.25}));
  EXPECT_DOUBLE_EQ(controls[0].jaw_rad, 0.5 * anatomy.jaw.full_rad);
}

TEST(ControlsFor, LetsALostFaceRelax) {
  const Anatomy anatomy = anatomy_of({"zygomaticus_major_L", "zygomaticus_major_R"});
  const std::vector<Controls> controls = controls_for(track_of({{1.0, 1.0}, {}, {}}), anatomy);
  EXPECT_LT(controls[1].contraction[0], controls[0].contraction[0]);
  EXPECT_LT(controls[2].contraction[0], controls[1].contraction[0]);
  EXPECT_GT(controls[2].contraction[0], 0.0);
}

TEST(ControlsFor, NamesWhatItRefuses) {
  const Anatomy anatomy = anatomy_of({"zygomaticus_major_L", "zygomaticus_major_R"});
  const auto message = [&](const ContractionTrack& track) -> std::string {
    try {
      controls_for(track, anatomy);
    } catch (const InputError& error) {
      return error.what();
    }
    return {};
  };
  ContractionTrack unknown = track_of({{0.0, 0.0}});
  unknown.muscles[1] = "wing_R";
  EXPECT_NE(message(unknown).find("wing_R"), std::string::npos);
  EXPECT_NE(message(track_of({{0.5, 1.5}})).find("zygomaticus_major_R in frame 0"),
            std::string::npos);
  EXPECT_NE(message(track_of({{0.5, std::nan("")}})).find("zygomaticus_major_R"),
            std::string::npos);
  EXPECT_NE(message(track_of({{0.5}})).find("expected one for each"), std::string::npos);
}

TEST(Comparison, OfATrackWithItselfIsPerfect) {
  const ContractionTrack track = track_of({{0.0, 0.1}, {0.5, 0.4}, {1.0, 0.2}});
  for (const ContractionError& error : compare_contractions(track, track)) {
    EXPECT_EQ(error.rms, 0.0);
    EXPECT_EQ(error.num_frames, 3);
    if (error.truth_range > 0.0) {
      EXPECT_NEAR(error.correlation, 1.0, 1e-12);
    }
  }
}

TEST(Comparison, MeasuresAConstantOffset) {
  const ContractionTrack truth = track_of({{0.0, 0.1}, {0.5, 0.4}, {0.8, 0.2}});
  const ContractionTrack shifted = track_of({{0.1, 0.1}, {0.6, 0.4}, {0.9, 0.2}});
  const std::vector<ContractionError> errors = compare_contractions(shifted, truth);
  ASSERT_EQ(errors.size(), 3U);  // jaw, left, right
  EXPECT_NEAR(errors[1].rms, 0.1, 1e-12);
  EXPECT_NEAR(errors[1].correlation, 1.0, 1e-12);
  EXPECT_EQ(errors[2].rms, 0.0);
}

TEST(Comparison, CountsLostContoursAgainstCover) {
  ContourSet truth;
  Contour brow;
  brow.name = "brow_left";
  brow.points_px = {{0.0, 0.0}, {10.0, 0.0}};
  brow.confidence = 1.0;
  truth.contours = {brow};
  ContourSet shifted = truth;
  for (Point2& p : shifted.contours[0].points_px) p.y() += 2.0;
  ContourSet truth_later = truth;
  truth_later.frame_index = 1;
  ContourSet lost = truth_later;
  lost.contours[0].points_px.clear();

  const auto errors = compare_contours({shifted, lost}, {truth, truth_later});
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_DOUBLE_EQ(errors[0].median_px, 2.0);
  EXPECT_DOUBLE_EQ(errors[0].cover, 0.5);
}

}  // namespace
}  // namespace zygoma
