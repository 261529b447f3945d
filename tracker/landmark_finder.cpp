#include "tracker/landmark_finder.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/face.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>
#include <utility>
#include <vector>

#include "src/base/check.h"
#include "tracker/face_chart.h"

namespace zygoma {
namespace {

constexpr const char* kExpected =
    ", expected a YuNet face detector (.onnx) or an OpenCV Facemark LBF model of 68 landmarks "
    "(.yaml)";
constexpr int kSearchSide = 320;         // px, the longer side of the picture YuNet searches
constexpr double kLeastScore = 0.6;      // of a YuNet face, [0, 1]
constexpr double kLeastEyeShare = 0.15;  // distance of the eyes over the face box: less is no face

// OpenCV reports broken files on stderr as well; our message is enough.
class QuietOpenCv {
 public:
  QuietOpenCv() : before_(cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT)) {}
  ~QuietOpenCv() { cv::utils::logging::setLogLevel(before_); }
  QuietOpenCv(const QuietOpenCv&) = delete;
  QuietOpenCv& operator=(const QuietOpenCv&) = delete;

 private:
  cv::utils::logging::LogLevel before_;
};

class YunetFinder : public FaceFinder {
 public:
  explicit YunetFinder(const std::string& path) {
    const QuietOpenCv quiet;
    bool usable = false;
    try {
      detector_ = cv::FaceDetectorYN::create(
          path, "", cv::Size(kSearchSide, kSearchSide), static_cast<float>(kLeastScore));
      // Another network loads as well and fails when it is used.
      cv::Mat faces;
      detector_->detect(cv::Mat(kSearchSide, kSearchSide, CV_8UC3, cv::Scalar::all(0)), faces);
      usable = true;
    } catch (const std::exception&) {
      usable = false;
    }
    require(usable, path + ": not a YuNet model that OpenCV " CV_VERSION " can use" + kExpected);
  }

  std::optional<FaceEyes> find(const cv::Mat& image) override {
    const cv::Mat bgr = as_bgr(image);
    if (bgr.empty()) return std::nullopt;
    const double shrink =
        std::min(1.0, static_cast<double>(kSearchSide) / std::max(bgr.cols, bgr.rows));
    cv::Mat small, faces;
    cv::resize(bgr, small, cv::Size(), shrink, shrink, cv::INTER_AREA);
    detector_->setInputSize(small.size());
    detector_->detect(small, faces);
    // Rows of 15: box (4), right eye, left eye, nose, corners of the mouth (10), score.
    int best = -1;
    for (int i = 0; i < faces.rows; ++i) {
      if (best < 0 || faces.at<float>(i, 2) > faces.at<float>(best, 2)) best = i;
    }
    if (best < 0) return std::nullopt;
    const auto point = [&](int column) -> Point2 {
      return Point2(faces.at<float>(best, column), faces.at<float>(best, column + 1)) / shrink;
    };
    FaceEyes eyes{point(4), point(6), true};
    const double width = faces.at<float>(best, 2) / shrink;
    if (!((eyes.left_px - eyes.right_px).norm() > kLeastEyeShare * width)) return std::nullopt;
    return eyes;
  }

 private:
  cv::Ptr<cv::FaceDetectorYN> detector_;
};

// OpenCV takes whatever it finds in the file for a model, and crashes when it is used.
bool is_whole_facemark(const std::string& path) {
  const cv::FileStorage file(path, cv::FileStorage::READ);
  if (!file.isOpened()) return false;
  const auto number = [&file](const char* name) {
    return file[name].isInt() ? static_cast<int>(file[name]) : 0;
  };
  const int stages = number("stages_n");
  const int trees = number("tree_n");
  const int depth = number("tree_depth");
  if (number("n_landmarks") != static_cast<int>(kNumLandmarks)) return false;
  if (stages < 1 || stages > 100 || trees < 1 || trees > 100 || depth < 1 || depth > 15) {
    return false;
  }
  const auto is_matrix = [&file](const std::string& name, int rows, int columns) {
    const cv::FileNode node = file[name];
    if (!node.isMap()) return false;
    const cv::Mat matrix = node.mat();
    return matrix.rows == rows && matrix.cols == columns && matrix.type() == CV_64F;
  };
  const int points = static_cast<int>(kNumLandmarks);
  const int nodes = 1 << depth;
  if (!is_matrix("regressor_meanshape", points, 2)) return false;
  for (int stage = 0; stage < stages; ++stage) {
    const std::string at = "_" + std::to_string(stage);
    if (!is_matrix("weights" + at, 2 * points, points * trees * nodes / 2)) return false;
    for (int point = 0; point < points; ++point) {
      for (int tree = 0; tree < trees; ++tree) {
        const std::string name = at + "_" + std::to_string(point) + "_" + std::to_string(tree);
        if (!is_matrix("tree" + name, nodes, 4) || file["thresholds" + name].empty()) return false;
      }
    }
  }
  return true;
}

class FacemarkFinder : public FaceFinder {
 public:
  FacemarkFinder(const std::string& path, FaceBox face_box) : face_box_(std::move(face_box)) {
    const QuietOpenCv quiet;
    bool usable = false;
    try {
      usable = is_whole_facemark(path);
      cv::face::FacemarkLBF::Params silent;
      silent.verbose = false;
      model_ = cv::face::FacemarkLBF::create(silent);
      if (usable) model_->loadModel(path);
    } catch (const std::exception&) {
      usable = false;
    }
    require(usable, path + ": not a whole Facemark LBF model of 68 landmarks" + kExpected);
  }

  std::optional<FaceEyes> find(const cv::Mat& image) override {
    const cv::Mat bgr = as_bgr(image);
    const std::optional<cv::Rect2d> box = face_box_(bgr);
    if (!box) return std::nullopt;
    const std::vector<cv::Rect> boxes{cv::Rect(*box) & cv::Rect(0, 0, bgr.cols, bgr.rows)};
    std::vector<std::vector<cv::Point2f>> fitted;
    if (!model_->fit(bgr, boxes, fitted) || fitted.size() != 1) return std::nullopt;
    if (fitted[0].size() != kNumLandmarks) return std::nullopt;
    FaceEyes eyes;
    eyes.landmarks.emplace();
    for (size_t i = 0; i < kNumLandmarks; ++i) {
      Point2& p = (*eyes.landmarks)[i];
      p = Point2(fitted[0][i].x, fitted[0][i].y);
      if (!p.allFinite()) return std::nullopt;
    }
    eyes.right_px = right_eye_of(*eyes.landmarks);
    eyes.left_px = left_eye_of(*eyes.landmarks);
    eyes.both_seen = true;
    // Upright enough and wide enough to be the face in that box.
    const Point2 across = eyes.left_px - eyes.right_px;
    if (!(across.x() > kLeastEyeShare * box->width)) return std::nullopt;
    return eyes;
  }

 private:
  FaceBox face_box_;
  cv::Ptr<cv::face::Facemark> model_;
};

bool is_storage(const std::string& path) {
  const std::string ending = std::filesystem::path(path).extension().string();
  if (ending == ".yaml" || ending == ".yml" || ending == ".xml") return true;
  std::ifstream file(path, std::ios::binary);
  std::string beginning(5, '\0');
  file.read(beginning.data(), 5);
  return beginning == "%YAML" || beginning == "<?xml";
}

}  // namespace

std::unique_ptr<FaceFinder> make_landmark_finder(const std::string& model_path,
                                                 const std::function<FaceBox()>& make_face_box) {
  std::error_code failure;
  require(std::filesystem::is_regular_file(model_path, failure),
          model_path + ": no such file" + kExpected);
  if (is_storage(model_path)) return std::make_unique<FacemarkFinder>(model_path, make_face_box());
  const bool is_onnx = std::filesystem::path(model_path).extension() == ".onnx";
  require(is_onnx, model_path + ": unknown kind of model" + kExpected);
  return std::make_unique<YunetFinder>(model_path);
}

}  // namespace zygoma
