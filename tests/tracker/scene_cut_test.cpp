#include "tracker/scene_cut.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace zygoma {
namespace {

// A room with a head in it.
cv::Mat room(const cv::Scalar& wall, const cv::Scalar& coat, int head_x) {
  cv::Mat picture(180, 320, CV_8UC3, wall);
  cv::rectangle(picture, cv::Point(0, 140), cv::Point(320, 180), coat, cv::FILLED);
  cv::ellipse(picture, {head_x, 90}, {35, 50}, 0, 0, 360, cv::Scalar(130, 160, 200), cv::FILLED);
  return picture;
}

TEST(SceneCut, SeesAnotherRoomButNoMotionLightOrBlack) {
  SceneCut cut;
  const cv::Scalar wall(120, 130, 140), coat(60, 40, 30);
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(cut.at(room(wall, coat, 150 + 4 * i)));
  cv::Mat dim;
  room(wall, coat, 190).convertTo(dim, -1, 0.5);
  EXPECT_FALSE(cut.at(dim));
  EXPECT_FALSE(cut.at(cv::Mat(180, 320, CV_8UC3, cv::Scalar::all(0))));
  EXPECT_FALSE(cut.at(room(wall, coat, 180)));
  EXPECT_TRUE(cut.at(room(cv::Scalar(60, 60, 60), cv::Scalar(200, 200, 210), 180)));
  EXPECT_FALSE(cut.at(room(cv::Scalar(60, 60, 60), cv::Scalar(200, 200, 210), 182)));
}

TEST(SceneCut, AShakenCameraIsNoCut) {
  SceneCut cut;
  cv::Mat wide(180, 600, CV_8UC3);
  cv::RNG random(3);
  cv::Mat coarse(18, 60, CV_8UC3);
  random.fill(coarse, cv::RNG::UNIFORM, 40, 220);
  cv::resize(coarse, wide, wide.size(), 0, 0, cv::INTER_CUBIC);
  int at = 0;
  for (int i = 0; i < 20; ++i) {
    at = std::min(280, at + i);
    EXPECT_FALSE(cut.at(wide(cv::Rect(at, 0, 320, 180)))) << i;
  }
}

TEST(SceneCut, TakesAnyPicture) {
  SceneCut cut;
  EXPECT_FALSE(cut.at(cv::Mat()));
  EXPECT_FALSE(cut.at(cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(200))));
  EXPECT_FALSE(cut.at(cv::Mat(50, 50, CV_8UC1, cv::Scalar::all(100))));
  EXPECT_FALSE(cut.at(cv::Mat(50, 50, CV_16UC1, cv::Scalar::all(100))));
}

}  // namespace
}  // namespace zygoma
