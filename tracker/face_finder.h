// Finds the face and its two eyes in a single picture.
//
// Used only to start and to recover. Usually by OpenCV's boosted Haar cascades, which are data of
// the OpenCV package: nothing is trained here, and an eye that no cascade finds is placed from the
// proportions of the face box. A landmark model of the user (landmark_finder.h) sees more.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "tracker/landmarks.h"

namespace zygoma {

struct FaceEyes {
  Point2 right_px = Point2::Zero();  // eye centres, the subject's sides
  Point2 left_px = Point2::Zero();
  bool both_seen = false;  // themselves, not by proportion
  std::optional<Landmarks> landmarks = {};
};

class FaceFinder {
 public:
  virtual ~FaceFinder() = default;
  // The largest face of an 8-bit picture.
  virtual std::optional<FaceEyes> find(const cv::Mat& image) = 0;
};

// `cascade_folder` holds OpenCV's haarcascade_*.xml; empty: the places where packages put them.
// `landmark_model` is a file of the user; empty: none. Throws InputError naming what is missing or
// cannot be used.
std::unique_ptr<FaceFinder> make_face_finder(const std::string& cascade_folder,
                                             const std::string& landmark_model = {});

}  // namespace zygoma
