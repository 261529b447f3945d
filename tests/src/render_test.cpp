#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>

#include "face/generic_head.h"
#include "face/jaw.h"
#include "src/render/renderer.h"

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

}  // namespace
}  // namespace zygoma
