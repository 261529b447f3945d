// Finds the face and its two eyes in a single picture, with OpenCV's boosted Haar cascades.
//
// Used only to start and to recover. The cascades are data of the OpenCV package; nothing is
// trained here. An eye that no cascade finds is placed from the proportions of the face box.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "tracker/contour_set.h"

namespace zygoma {

struct FaceEyes {
  Point2 right_px;  // eye centres, the subject's sides
  Point2 left_px;
  bool both_seen = false;  // by an eye cascade, not by proportion
};

class FaceFinder {
 public:
  // `folder` holds OpenCV's haarcascade_*.xml; empty: the places where packages put them. Throws
  // InputError if the folder lacks one of them.
  explicit FaceFinder(const std::string& folder);
  ~FaceFinder();
  FaceFinder(FaceFinder&&) noexcept;
  FaceFinder& operator=(FaceFinder&&) noexcept;

  // The largest face of an 8-bit picture.
  std::optional<FaceEyes> find(const cv::Mat& image);

 private:
  struct Cascades;
  std::unique_ptr<Cascades> cascades_;
};

}  // namespace zygoma
