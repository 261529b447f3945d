#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>

#include "face/generic_head.h"
#include "src/base/check.h"
#include "src/render/face_overlay.h"
#include "src/render/renderer.h"
#include "src/render/views.h"

namespace zygoma {
namespace {

std::shared_ptr<const Anatomy> head() {
  static const auto anatomy = std::make_shared<const Anatomy>(make_generic_head());
  return anatomy;
}

cv::Mat picture(int num_threads, int width, int height, double height_mm, double yaw_rad = 0.0) {
  RenderOptions options;
  options.num_threads = num_threads;
  Renderer renderer(head(), options);
  const Camera camera =
      make_camera(width, height, Vec3(0.0, -25.0, 0.0), height_mm, 900.0, yaw_rad);
  cv::Mat bgr;
  renderer.render(head()->skin.mesh.positions_mm, 0.0, camera, bgr);
  return bgr;
}

TEST(Camera, PutsTheTargetInTheMiddleAtTheScaleAskedFor) {
  const Vec3 target(3.0, -25.0, 7.0);
  const Camera camera = make_camera(640, 360, target, 200.0, 900.0, 0.4, -0.2);
  EXPECT_NEAR((camera.project(target) - Vec2(319.5, 179.5)).norm(), 0.0, 1e-9);
  const Camera front = make_camera(640, 360, target, 200.0);
  const Vec2 up = front.project(target + Vec3(0.0, 100.0, 0.0));
  EXPECT_NEAR(up.y(), 179.5 - 180.0, 1e-9);
  EXPECT_NEAR(up.x(), 319.5, 1e-9);
  // The subject's left is on the right of the picture.
  EXPECT_GT(front.project(target + Vec3(10.0, 0.0, 0.0)).x(), 319.5);
  // From the subject's left the nose points to the left of the picture... as seen: the near side,
  // the left cheek, moves to the middle.
  const Camera turned = make_camera(640, 360, Vec3::Zero(), 200.0, 900.0, 0.5);
  EXPECT_LT(turned.project(Vec3(0.0, 0.0, 30.0)).x(), 319.5);
}

TEST(Renderer, SameBitsForOneAndTwoThreads) {
  const cv::Mat one = picture(1, 160, 120, 300.0, 0.3);
  const cv::Mat two = picture(2, 160, 120, 300.0, 0.3);
  ASSERT_EQ(one.size(), two.size());
  EXPECT_EQ(cv::norm(one, two, cv::NORM_INF), 0.0);
}

TEST(Renderer, ShowsSkinInTheMiddleAndBackgroundInTheCorner) {
  const cv::Mat bgr = picture(2, 160, 120, 400.0);
  const cv::Vec3b cheek = bgr.at<cv::Vec3b>(65, 90);
  EXPECT_GT(cheek[2], cheek[0] + 20);  // skin is redder than blue
  const cv::Vec3b corner = bgr.at<cv::Vec3b>(0, 0);
  EXPECT_GE(corner[0], corner[2]);
  EXPECT_LT(corner[0], 120);
}

TEST(Renderer, FollowsTheSkinItIsGiven) {
  RenderOptions options;
  options.num_threads = 2;
  Renderer renderer(head(), options);
  const Camera camera = make_camera(160, 120, Vec3(0.0, -25.0, 0.0), 300.0);
  cv::Mat rest;
  renderer.render(head()->skin.mesh.positions_mm, 0.0, camera, rest);
  std::vector<Vec3> moved = head()->skin.mesh.positions_mm;
  for (Vec3& p : moved) p.x() += 20.0;
  cv::Mat shifted;
  renderer.render(moved, 0.0, camera, shifted);
  EXPECT_GT(cv::norm(rest, shifted, cv::NORM_L1) / (160 * 120 * 3), 1.0);
  cv::Mat again;
  renderer.render(head()->skin.mesh.positions_mm, 0.0, camera, again);
  // The tree was refitted twice in between; rays on an edge may meet the neighbouring triangle.
  EXPECT_LT(cv::norm(rest, again, cv::NORM_L1) / (160 * 120 * 3), 0.01);
}

TEST(Renderer, TheDefaultHeadIsFoundAsAFaceWithTwoEyes) {
  const std::string folder = "/usr/share/opencv4/haarcascades/";
  if (!std::filesystem::exists(folder + "haarcascade_eye.xml")) {
    GTEST_SKIP() << "no cascades in " << folder;
  }
  cv::CascadeClassifier faces(folder + "haarcascade_frontalface_alt2.xml");
  cv::CascadeClassifier eyes(folder + "haarcascade_eye.xml");
  cv::Mat grey;
  cv::cvtColor(picture(2, 480, 360, 280.0), grey, cv::COLOR_BGR2GRAY);
  std::vector<cv::Rect> found;
  faces.detectMultiScale(grey, found, 1.1, 3, 0, {90, 90});
  ASSERT_EQ(found.size(), 1U);
  cv::Rect upper = found.front();
  upper.height = upper.height * 6 / 10;
  std::vector<cv::Rect> two;
  eyes.detectMultiScale(grey(upper), two, 1.05, 4);
  EXPECT_EQ(two.size(), 2U);
}

TEST(Renderer, ShowsTheFurrowsOfSkinThatIsPushedTogether) {
  // The same deformed skin on an anatomy that does not fold: what differs is the furrows' shading.
  Anatomy smooth = *head();
  smooth.skin.furrow_sites.clear();
  std::vector<Vec3> skin = head()->skin.mesh.positions_mm;
  for (Vec3& p : skin) {
    if (p.y() > 20.0) p.y() = 20.0 + 0.85 * (p.y() - 20.0);
  }
  const Camera camera = make_camera(320, 160, Vec3(0.0, 38.0, 0.0), 60.0);
  const auto contrast = [&](std::shared_ptr<const Anatomy> anatomy) {
    Renderer renderer(std::move(anatomy));
    cv::Mat bgr, grey;
    renderer.render(skin, 0.0, camera, bgr);
    cv::cvtColor(bgr(cv::Rect(90, 42, 140, 54)), grey, cv::COLOR_BGR2GRAY);
    cv::Mat blurred;
    grey.convertTo(grey, CV_32F);
    cv::GaussianBlur(grey, blurred, {0, 0}, 12.0);
    return cv::norm(grey, blurred, cv::NORM_L2) / std::sqrt(static_cast<double>(grey.total()));
  };
  EXPECT_GT(contrast(head()), 2.0 * contrast(std::make_shared<const Anatomy>(std::move(smooth))));
}

template <typename Parse>
std::string refusal(Parse parse, const std::string& text) {
  try {
    parse(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Views, AreParsedByNameAndRefusedWithTheChoices) {
  for (const View view : {View::kFront, View::kThreeQuarter, View::kProfile, View::kTurntable}) {
    EXPECT_EQ(parse_view(view_name(view)), view);
  }
  EXPECT_EQ(refusal(parse_view, "above"),
            "view 'above' is unknown, expected one of front, three-quarter, profile, turntable");
}

TEST(Views, FrameTheWholeFaceInEveryShapeOfPicture) {
  for (const auto& [width, height] : {std::pair(640, 480), std::pair(480, 640)}) {
    for (const View view : {View::kFront, View::kThreeQuarter, View::kProfile, View::kTurntable}) {
      const Camera camera = view_camera(view, *head(), width, height, 0.4);
      double left = width, right = 0.0, top = height, bottom = 0.0;
      for (const Vec3& p : head()->skin.mesh.positions_mm) {
        if (p.y() < -130.0) continue;
        const Vec2 at = camera.project(p);
        left = std::min(left, at.x());
        right = std::max(right, at.x());
        top = std::min(top, at.y());
        bottom = std::max(bottom, at.y());
      }
      EXPECT_GE(left, 0.0) << view_name(view);
      EXPECT_LE(right, width) << view_name(view);
      EXPECT_GE(top, 0.0) << view_name(view);
      EXPECT_LE(bottom, height) << view_name(view);
      // And not from far away.
      EXPECT_GT(std::max((right - left) / width, (bottom - top) / height), 0.7);
    }
  }
}

TEST(Views, TheTurntableStartsInFrontAndPassesTheProfile) {
  const auto direction = [](View view, double turn) {
    return view_camera(view, *head(), 100, 100, turn).camera_from_face.linear();
  };
  const auto front = direction(View::kFront, 0.0);
  EXPECT_TRUE(direction(View::kTurntable, 0.0).isApprox(front, 1e-12));
  EXPECT_TRUE(direction(View::kTurntable, 1.0).isApprox(front, 1e-12));
  EXPECT_TRUE(direction(View::kTurntable, 0.25).isApprox(direction(View::kProfile, 0.0), 1e-12));
}

TEST(FaceOverlay, IsParsedByNameAndRefusedWithTheChoices) {
  EXPECT_EQ(parse_overlay("strain"), Overlay::kStrain);
  EXPECT_EQ(parse_overlay("none"), Overlay::kNone);
  EXPECT_EQ(refusal(parse_overlay, "stress"),
            "overlay 'stress' is unknown, expected one of none, lattice, muscles, volume, strain");
}

TEST(FaceOverlay, FalseColoursShowKnownStrainsAndVolumes) {
  const Simulator simulator(head());
  FaceState state = simulator.rest();
  for (const double value : skin_strain(head()->surface, state.positions_mm)) {
    EXPECT_NEAR(value, 0.0, 1e-9);
  }
  for (const double value : volume_change(simulator.lattice(), state.positions_mm)) {
    EXPECT_NEAR(value, 0.0, 1e-9);
  }
  for (Vec3& p : state.positions_mm) p.y() *= 0.8;  // pushed together from above
  const std::vector<double> strain = skin_strain(head()->surface, state.positions_mm);
  EXPECT_GE(*std::min_element(strain.begin(), strain.end()), -0.2 - 1e-9);
  EXPECT_LE(*std::max_element(strain.begin(), strain.end()), 1e-9);
  EXPECT_LT(*std::min_element(strain.begin(), strain.end()), -0.195);
  int with_tissue = 0;
  for (const double value : volume_change(simulator.lattice(), state.positions_mm)) {
    if (value == 0.0) continue;
    EXPECT_NEAR(value, -0.2, 1e-9);
    ++with_tissue;
  }
  EXPECT_GT(with_tissue, 100);
}

TEST(FaceOverlay, EveryOneOfThemShowsInThePicture) {
  RenderOptions options;
  options.num_threads = 2;
  Renderer renderer(head(), options);
  const Simulator simulator(head());
  FaceState state = simulator.rest();
  for (Vec3& p : state.positions_mm) p.y() *= 0.9;
  std::vector<Vec3> skin;
  embed_skin(*head(), state, skin);
  const Camera camera = view_camera(View::kFront, *head(), 160, 160);
  Controls controls{std::vector<double>(head()->muscles.size(), 0.0), 0.0};
  cv::Mat plain;
  renderer.render(skin, 0.0, camera, plain);
  const auto shown = [&](Overlay which) {
    FaceOverlay overlay(which, simulator.anatomy(), simulator.lattice());
    cv::Mat bgr;
    renderer.render(skin, 0.0, camera, bgr, overlay.tint(state));
    overlay.draw(controls, state, camera, bgr);
    return bgr;
  };
  const auto difference = [](const cv::Mat& a, const cv::Mat& b) {
    return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total());
  };
  EXPECT_LT(difference(plain, shown(Overlay::kNone)), 0.1);
  for (const Overlay overlay :
       {Overlay::kLattice, Overlay::kMuscles, Overlay::kVolume, Overlay::kStrain}) {
    EXPECT_GT(difference(plain, shown(overlay)), 2.0) << static_cast<int>(overlay);
  }
  const cv::Mat slack = shown(Overlay::kMuscles);
  controls.contraction.assign(head()->muscles.size(), 1.0);
  EXPECT_GT(difference(slack, shown(Overlay::kMuscles)), 2.0);
}

}  // namespace
}  // namespace zygoma
