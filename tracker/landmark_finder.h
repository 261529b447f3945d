// Finds the face with a landmark model that the user brings: none is part of this project.
//
//   YuNet     .onnx, five points (cv::FaceDetectorYN): eyes, tip of the nose, corners of the mouth
//   Facemark  .yaml, .yml or .xml, 68 landmarks by local binary features (cv::face::FacemarkLBF);
//             they are fitted into the face box of the cascades
//
// Both are OpenCV's own formats. A file whose name does not say what it is tells by how it begins.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "tracker/face_finder.h"

namespace zygoma {

// The box of the largest face of a BGR picture, as OpenCV's frontal-face cascade draws it.
using FaceBox = std::function<std::optional<cv::Rect2d>(const cv::Mat& bgr)>;

// `make_face_box` is called for models that need one. Throws InputError naming the file when it is
// no model that this OpenCV can use.
std::unique_ptr<FaceFinder> make_landmark_finder(const std::string& model_path,
                                                 const std::function<FaceBox()>& make_face_box);

}  // namespace zygoma
