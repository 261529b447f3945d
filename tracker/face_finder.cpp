#include "tracker/face_finder.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>
#include <vector>

#include "src/base/check.h"
#include "tracker/face_chart.h"
#include "tracker/landmark_finder.h"

namespace zygoma {
namespace {

constexpr int kSearchSide = 320;   // px, the longer side of the picture the face is searched in
constexpr int kSmallestFace = 32;  // px, in that picture
// Where the eyes sit in the box of the frontal-face cascade, in box widths.
constexpr double kEyeX = 0.315;
constexpr double kEyeY = 0.385;

constexpr const char* kFaceFile = "haarcascade_frontalface_alt2.xml";
constexpr std::array<const char*, 2> kEyeFiles{"haarcascade_eye.xml",
                                               "haarcascade_eye_tree_eyeglasses.xml"};
constexpr std::array<const char*, 5> kUsualFolders{"/usr/share/opencv4/haarcascades",
                                                   "/usr/local/share/opencv4/haarcascades",
                                                   "/usr/share/opencv/haarcascades",
                                                   "/usr/local/share/opencv/haarcascades",
                                                   "/opt/homebrew/share/opencv4/haarcascades"};

std::string cascade_folder(const std::string& wanted) {
  if (!wanted.empty()) return wanted;
  for (const char* folder : kUsualFolders) {
    std::error_code ignored;
    if (std::filesystem::exists(std::filesystem::path(folder) / kFaceFile, ignored)) return folder;
  }
  throw InputError(
      "no folder with OpenCV's haarcascade_*.xml found in the usual places; install them (Debian: "
      "opencv-data) or name the folder");
}

cv::CascadeClassifier load(const std::string& folder, const char* file) {
  const std::string path = (std::filesystem::path(folder) / file).string();
  std::error_code ignored;
  require(std::filesystem::is_regular_file(path, ignored),
          path + ": no such file; expected one of OpenCV's Haar cascades");
  cv::CascadeClassifier cascade;
  bool loaded = false;
  try {
    loaded = cascade.load(path);
  } catch (const cv::Exception&) {
    loaded = false;
  }
  require(loaded && !cascade.empty(), path + ": not a cascade that OpenCV can read");
  return cascade;
}

// Component-wise median.
Point2 median_point(std::vector<Point2> points) {
  Point2 out;
  const auto middle = static_cast<std::ptrdiff_t>(points.size() / 2);
  for (int axis = 0; axis < 2; ++axis) {
    std::nth_element(points.begin(),
                     points.begin() + middle,
                     points.end(),
                     [axis](const Point2& p, const Point2& q) { return p[axis] < q[axis]; });
    out[axis] = points[static_cast<size_t>(middle)][axis];
  }
  return out;
}

class CascadeFinder : public FaceFinder {
 public:
  explicit CascadeFinder(const std::string& folder) {
    const std::string place = cascade_folder(folder);
    face_ = load(place, kFaceFile);
    for (size_t i = 0; i < kEyeFiles.size(); ++i) eyes_[i] = load(place, kEyeFiles[i]);
  }

  // The largest face, px of the picture.
  std::optional<cv::Rect2d> box_of(const cv::Mat& bgr);
  std::optional<FaceEyes> find(const cv::Mat& image) override;

 private:
  cv::CascadeClassifier face_;
  std::array<cv::CascadeClassifier, 2> eyes_;
};

std::optional<cv::Rect2d> CascadeFinder::box_of(const cv::Mat& bgr) {
  if (bgr.empty() || std::min(bgr.cols, bgr.rows) < kSmallestFace) return std::nullopt;
  cv::Mat grey, small;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  const double shrink =
      std::min(1.0, static_cast<double>(kSearchSide) / std::max(grey.cols, grey.rows));
  cv::resize(grey, small, cv::Size(), shrink, shrink, cv::INTER_AREA);
  std::vector<cv::Rect> faces;
  face_.detectMultiScale(small, faces, 1.1, 3, 0, cv::Size(kSmallestFace, kSmallestFace));
  if (faces.empty()) return std::nullopt;
  // The cascade lists in no fixed order when it runs on several threads.
  const cv::Rect box =
      *std::max_element(faces.begin(), faces.end(), [](const cv::Rect& p, const cv::Rect& q) {
        return std::tie(p.width, p.y, p.x) < std::tie(q.width, q.y, q.x);
      });
  return cv::Rect2d(box.x / shrink, box.y / shrink, box.width / shrink, box.height / shrink);
}

std::optional<FaceEyes> CascadeFinder::find(const cv::Mat& image) {
  const cv::Mat bgr = as_bgr(image);
  const std::optional<cv::Rect2d> box = box_of(bgr);
  if (!box) return std::nullopt;
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  const double width = box->width;
  const Point2 corner{box->x, box->y};

  const cv::Rect upper = cv::Rect(static_cast<int>(corner.x()),
                                  static_cast<int>(corner.y() + 0.15 * width),
                                  static_cast<int>(width),
                                  static_cast<int>(0.42 * width)) &
                         cv::Rect(0, 0, grey.cols, grey.rows);
  FaceEyes eyes;
  eyes.right_px = corner + width * Point2{kEyeX, kEyeY};
  eyes.left_px = corner + width * Point2{1.0 - kEyeX, kEyeY};
  std::array<std::vector<Point2>, 2> seen;
  for (const double side : {110.0, 130.0}) {
    const double zoom = side / width;
    cv::Mat part;
    cv::resize(
        grey(upper), part, cv::Size(), zoom, zoom, zoom < 1.0 ? cv::INTER_AREA : cv::INTER_LINEAR);
    for (cv::CascadeClassifier& cascade : eyes_) {
      std::vector<cv::Rect> found;
      const int smallest = static_cast<int>(0.13 * side);
      const int largest = static_cast<int>(0.36 * side);
      if (part.rows < smallest || part.cols < smallest) continue;
      cascade.detectMultiScale(
          part, found, 1.1, 2, 0, cv::Size(smallest, smallest), cv::Size(largest, largest));
      for (const cv::Rect& r : found) {
        const Point2 centre{upper.x + (r.x + 0.5 * r.width) / zoom,
                            upper.y + (r.y + 0.5 * r.height) / zoom};
        const bool left = (centre - eyes.left_px).norm() < (centre - eyes.right_px).norm();
        if ((centre - (left ? eyes.left_px : eyes.right_px)).norm() > 0.11 * width) continue;
        seen[left ? 1 : 0].push_back(centre);
      }
    }
  }
  eyes.both_seen = !seen[0].empty() && !seen[1].empty();
  const Point2 expected = eyes.left_px - eyes.right_px;
  if (eyes.both_seen) {
    eyes.right_px = median_point(seen[0]);
    eyes.left_px = median_point(seen[1]);
  } else if (!seen[0].empty()) {
    eyes.right_px = median_point(seen[0]);
    eyes.left_px = eyes.right_px + expected;
  } else if (!seen[1].empty()) {
    eyes.left_px = median_point(seen[1]);
    eyes.right_px = eyes.left_px - expected;
  }
  return eyes;
}

}  // namespace

std::unique_ptr<FaceFinder> make_face_finder(const std::string& cascade_folder,
                                             const std::string& landmark_model) {
  if (landmark_model.empty()) return std::make_unique<CascadeFinder>(cascade_folder);
  return make_landmark_finder(landmark_model, [&cascade_folder] {
    const auto cascades = std::make_shared<CascadeFinder>(cascade_folder);
    return [cascades](const cv::Mat& bgr) { return cascades->box_of(bgr); };
  });
}

}  // namespace zygoma
