#include "tracker/picture.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace zygoma {
namespace {

cv::Mat random_picture(const cv::Size& size, int type) {
  cv::Mat out(size, type);
  cv::RNG random(7);
  random.fill(out, cv::RNG::UNIFORM, 20, 230);
  return out;
}

Frame planes_of(const cv::Size& size) {
  Frame frame;
  frame.planes = {random_picture(size, CV_8U),
                  random_picture(size / 2, CV_8U),
                  255 - random_picture(size / 2, CV_8U)};
  return frame;
}

cv::Mat flipped(const cv::Mat& picture) {
  cv::Mat out;
  cv::flip(picture, out, 1);
  return out;
}

double furthest(const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_INF); }

TEST(Picture, APartIsAPartOfTheWhole) {
  Frame bgr, grey;
  bgr.image = random_picture({40, 30}, CV_8UC3);
  grey.image = random_picture({41, 30}, CV_8UC1);
  for (const Frame& frame : {bgr, grey, planes_of({40, 30})}) {
    for (const bool turned : {false, true}) {
      const Picture picture(frame, turned);
      const cv::Mat whole = picture.bgr();
      ASSERT_EQ(whole.type(), CV_8UC3);
      ASSERT_EQ(whole.size(), picture.size());
      EXPECT_EQ(furthest(whole, turned ? flipped(Picture(frame).bgr()) : Picture(frame).bgr()), 0);
      cv::Mat brightness;
      cv::cvtColor(whole, brightness, cv::COLOR_BGR2GRAY);
      for (const cv::Rect& box : {cv::Rect(3, 5, 8, 6),
                                  cv::Rect(4, 6, 7, 9),
                                  cv::Rect(0, 0, 1, 1),
                                  cv::Rect(33, 1, 7, 29)}) {
        EXPECT_EQ(furthest(picture.bgr(box), whole(box)), 0) << box;
        if (frame.image.empty()) continue;
        EXPECT_EQ(furthest(picture.grey(box), brightness(box)), 0) << box;
      }
    }
  }
}

// Y of a grey picture in video range.
TEST(Picture, BrightnessOfPlanesIsThatOfTheirColours) {
  Frame frame = planes_of({40, 30});
  frame.planes.cb.setTo(128);
  frame.planes.cr.setTo(128);
  const Picture picture(frame);
  cv::Mat brightness;
  cv::cvtColor(picture.bgr(), brightness, cv::COLOR_BGR2GRAY);
  EXPECT_LE(furthest(picture.grey({0, 0, 40, 30}), brightness), 1);
}

TEST(Picture, AFewPixelsSpeakForAll) {
  Frame frame;
  frame.image = cv::Mat(90, 160, CV_8UC3, cv::Scalar(10, 20, 30));
  frame.image.colRange(0, 80).setTo(cv::Scalar(200, 100, 50));
  for (const bool turned : {false, true}) {
    const cv::Mat few = Picture(frame, turned).sparse({16, 8});
    EXPECT_EQ(few.at<cv::Vec3b>(4, turned ? 14 : 1), cv::Vec3b(200, 100, 50));
    EXPECT_EQ(few.at<cv::Vec3b>(4, turned ? 1 : 14), cv::Vec3b(10, 20, 30));
  }
}

TEST(Picture, OtherKindsAreEmpty) {
  EXPECT_TRUE(Picture(cv::Mat()).empty());
  EXPECT_TRUE(Picture(cv::Mat(4, 4, CV_16UC3)).empty());
  EXPECT_FALSE(Picture(cv::Mat(4, 4, CV_8UC4)).empty());
}

}  // namespace
}  // namespace zygoma
