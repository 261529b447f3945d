// Landmarks of other trackers and models of the user: read, refused, started from, drawn to.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/face.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>
#include <random>

#include "src/base/check.h"
#include "src/io/landmarks_file.h"
#include "src/io/video_writer.h"
#include "src/pipeline/comparison.h"
#include "src/pipeline/track_video.h"
#include "src/synthetic/performer.h"
#include "tests/src/program.h"
#include "tests/src/scratch_folder.h"
#include "tests/support/silent_observer.h"
#include "tracker/initialiser.h"
#include "tracker/landmark_finder.h"

namespace zygoma {
namespace {

struct Scene {
  std::vector<cv::Mat> pictures;
  std::vector<ContourSet> truth;
  std::vector<Landmarks> landmarks;
};

// Where the eyes are: as far below the brows as on the usual face.
Similarity place_of(const ContourSet& truth) {
  const ContourNodes usual = template_contours();
  const auto middle = [](const std::vector<Point2>& nodes) { return resample(nodes, 3)[1]; };
  return similarity_from_pair(middle(usual[kBrowRight]),
                              middle(usual[kBrowLeft]),
                              middle(truth.visible("brow_right")->points_px),
                              middle(truth.visible("brow_left")->points_px));
}

// The 68 landmarks whose contours are the true ones.
Landmarks landmarks_of(const ContourSet& truth) {
  const Similarity place = place_of(truth);
  Landmarks out;
  out.fill(place.apply(chart_point(0.0, 0.3)));
  const auto put = [&](const char* name, const std::vector<size_t>& at) {
    if (truth.visible(name) == nullptr) return;
    const std::vector<Point2> points =
        resample(truth.visible(name)->points_px, static_cast<int>(at.size()));
    for (size_t i = 0; i < at.size(); ++i) out[at[i]] = points[i];
  };
  put("brow_right", {21, 20, 19, 18, 17});
  put("brow_left", {22, 23, 24, 25, 26});
  put("nose_tip", {31, 32, 33, 34, 35});
  put("lower_lip", {48, 59, 58, 57, 56, 55, 54});
  put("upper_lip", {48, 49, 50, 51, 52, 53, 54});
  put("chin_boss", {7, 8, 9});
  // The tip of the chin for which the boss is where it is.
  const Point2 tip = out[57] + (out[8] - out[57]) / kChinBossShare;
  const Point2 down = tip - out[8];
  for (const size_t i : {7u, 8u, 9u}) out[i] += down;
  for (size_t i = 0; i < 6; ++i) {
    const double angle = static_cast<double>(i) * 1.0471975511965976;
    const Point2 around(0.15 * std::cos(angle), 0.06 * std::sin(angle));
    out[36 + i] = place.apply(chart_point(-0.5 + around.x(), around.y()));
    out[42 + i] = place.apply(chart_point(0.5 + around.x(), around.y()));
  }
  put("eyelid_left", {42, 43, 44, 45});
  put("eyelid_right", {39, 38, 37, 36});
  return out;
}

const Scene& smiling_performer() {
  static const Scene scene = [] {
    PerformerOptions options;
    options.schedule = "smile";
    options.duration_s = 1.2;
    options.width_px = 480;
    options.height_px = 360;
    options.num_surface_vertices = 300;
    Performer performer(options);
    Scene made;
    Frame frame;
    Contractions contractions;
    ContourSet truth;
    while (performer.next(frame, contractions, truth)) {
      made.pictures.push_back(frame.image.clone());
      made.truth.push_back(truth);
      made.landmarks.push_back(landmarks_of(truth));
    }
    return made;
  }();
  return scene;
}

std::string write_video(const std::string& path, const std::vector<cv::Mat>& pictures) {
  VideoWriter writer(path, pictures[0].cols, pictures[0].rows, 30.0, {"ultrafast", 12, 1});
  for (size_t i = 0; i < pictures.size(); ++i) {
    writer.write(pictures[i], static_cast<double>(i) / 30.0);
  }
  writer.finish();
  return path;
}

// As OpenFace writes it: frames from 1, before version 2.1 with a blank before every name.
std::string csv_of(const std::vector<Landmarks>& frames, const std::string& blank = "") {
  std::string text = "frame," + blank + "face_id," + blank + "timestamp," + blank + "confidence," +
                     blank + "success";
  for (const char* axis : {"x_", "y_", "X_"}) {
    for (size_t i = 0; i < kNumLandmarks; ++i) text += "," + blank + axis + std::to_string(i);
  }
  text += '\n';
  for (size_t f = 0; f < frames.size(); ++f) {
    text += std::to_string(f + 1) + "," + blank + "0," + blank +
            std::to_string(static_cast<double>(f) / 30.0) + "," + blank + "0.98," + blank + "1";
    for (int axis = 0; axis < 2; ++axis) {
      for (const Point2& p : frames[f]) {
        char cell[32];
        std::snprintf(cell, sizeof cell, ",%s%.1f", blank.c_str(), p[axis]);
        text += cell;
      }
    }
    for (size_t i = 0; i < kNumLandmarks; ++i) text += ",7";  // millimetres of no interest
    text += '\n';
  }
  return text;
}

std::vector<Landmarks> with_noise(std::vector<Landmarks> frames, double sigma_px) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, sigma_px);
  for (Landmarks& frame : frames) {
    for (Point2& p : frame) p += Point2(noise(random), noise(random));
  }
  return frames;
}

// Mean over the contours that landmarks mark of the median distance to the truth, px.
double distance(const std::vector<ContourSet>& contours, const std::vector<ContourSet>& truth) {
  double sum = 0.0;
  int count = 0;
  for (const ContourError& error : compare_contours(contours, truth)) {
    if (error.contour == "hairline" || error.contour.starts_with("furrow")) continue;
    EXPECT_GT(error.cover, 0.95) << error.contour;
    sum += error.median_px;
    ++count;
  }
  return sum / count;
}

TEST(LandmarksFile, IsReadWithAndWithoutBlanks) {
  const ScratchFolder folder;
  const Scene& scene = smiling_performer();
  for (const char* blank : {"", " "}) {
    const LandmarkTrack track =
        read_landmarks_csv(folder.write("points.csv", csv_of(scene.landmarks, blank)));
    EXPECT_EQ(track.num_frames, static_cast<int>(scene.landmarks.size()));
    ASSERT_EQ(track.seen.size(), scene.landmarks.size());
    for (size_t i = 0; i < kNumLandmarks; ++i) {
      const Point2 difference = track.seen.at(3)[i] - scene.landmarks[3][i];
      EXPECT_LT(difference.cwiseAbs().maxCoeff(), 0.0501) << i;  // one decimal is written
    }
  }
}

TEST(LandmarksFile, LeavesOutFramesWithoutSuccessAndCountsFromZeroOrOne) {
  const ScratchFolder folder;
  const Scene& scene = smiling_performer();
  const std::vector<Landmarks> three(scene.landmarks.begin(), scene.landmarks.begin() + 3);
  std::string text = csv_of(three);
  const auto second = text.find("\n2,0,");
  text.replace(text.find(",1,", second), 3, ",0,");
  LandmarkTrack track = read_landmarks_csv(folder.write("points.csv", text));
  EXPECT_EQ(track.num_frames, 3);
  EXPECT_TRUE(track.seen.contains(0) && !track.seen.contains(1) && track.seen.contains(2));
  text = csv_of(three);
  for (const char* number : {"1", "2", "3"}) {
    const std::string before = "\n" + std::string(number) + ",0,";
    text.replace(text.find(before), before.size(), "\n" + std::to_string(number[0] - '1') + ",0,");
  }
  track = read_landmarks_csv(folder.write("points.csv", text));
  EXPECT_EQ(track.num_frames, 3);
  EXPECT_TRUE(track.seen.contains(0));
}

TEST(LandmarksFile, IsRefusedInOneLineThatSaysWhy) {
  const ScratchFolder folder;
  const Scene& scene = smiling_performer();
  const std::string good = csv_of({scene.landmarks[0], scene.landmarks[1]});
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos);
    return text.replace(at, from.size(), to);
  };
  const auto refusal = [&](const std::string& text) {
    const std::string message =
        message_of<InputError>([&] { read_landmarks_csv(folder.write("points.csv", text)); });
    EXPECT_NE(message.find("points.csv"), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message;
  };
  EXPECT_NE(refusal(changed(",y_67", ",y_99")).find("y_67"), std::string::npos);
  EXPECT_NE(refusal(changed("success", "succeeded")).find("success"), std::string::npos);
  EXPECT_NE(refusal(changed(",0.98,1,", ",0.98,1,nan,")).find("cells"), std::string::npos);
  char first_x[32];
  std::snprintf(first_x, sizeof first_x, "0.98,1,%.1f", scene.landmarks[0][0].x());
  EXPECT_NE(refusal(changed(first_x, "0.98,1,nan")).find("x_0: 'nan', expected"),
            std::string::npos);
  EXPECT_NE(refusal(changed(first_x, "0.98,1,wide")).find("'wide'"), std::string::npos);
  EXPECT_NE(refusal(changed("0.98", "1.98")).find("confidence"), std::string::npos);
  EXPECT_NE(refusal(changed("\n2,", "\n1,")).find("a later frame"), std::string::npos);
  EXPECT_NE(refusal(good.substr(0, good.find('\n') + 1)).find("no rows"), std::string::npos);
  std::string hopeless = good;
  for (size_t at; (at = hopeless.find("0.98")) != std::string::npos;) hopeless[at + 2] = '1';
  EXPECT_NE(refusal(hopeless).find("no frame has success"), std::string::npos);
}

TEST(Landmarks, OfAnotherVideoAreRefused) {
  const ScratchFolder folder;
  const Scene& scene = smiling_performer();
  const std::string clip = write_video(folder / "clip.mp4", scene.pictures);
  std::vector<Landmarks> half(scene.landmarks.begin(), scene.landmarks.begin() + 18);
  const std::string points = folder.write("points.csv", csv_of(half));
  const Outcome outcome =
      run_program(folder, {"track", clip, "-o", folder / "out", "--landmarks", points});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(num_lines(outcome.err), 1) << outcome.err;
  EXPECT_NE(outcome.err.find("points.csv: is of 18 frames"), std::string::npos) << outcome.err;
  EXPECT_NE(run_program(folder, {"track", clip, "-o", folder / "out", "--landmarks-as", "prior"})
                .err.find("needs --landmarks"),
            std::string::npos);
}

// A head that lies on its side: no cascade finds it, its landmarks do.
TEST(Landmarks, StartAFaceThatCannotBeFound) {
  const ScratchFolder folder;
  Scene scene = smiling_performer();
  const cv::Matx23d turn(0.5, 0.866, -20.0, -0.866, 0.5, 330.0);
  const auto turned = [&](const Point2& p) {
    return Point2(turn(0, 0) * p.x() + turn(0, 1) * p.y() + turn(0, 2),
                  turn(1, 0) * p.x() + turn(1, 1) * p.y() + turn(1, 2));
  };
  for (size_t f = 0; f < scene.pictures.size(); ++f) {
    cv::Mat lying;
    cv::warpAffine(
        scene.pictures[f], lying, turn, scene.pictures[f].size(), 1, cv::BORDER_REPLICATE);
    scene.pictures[f] = lying;
    for (Contour& contour : scene.truth[f].contours) {
      for (Point2& p : contour.points_px) p = turned(p);
    }
    for (Point2& p : scene.landmarks[f]) p = turned(p);
  }
  const std::string clip = write_video(folder / "clip.mp4", scene.pictures);
  SilentObserver silent;
  EXPECT_THROW(track_video(clip, {}, {}, silent, {}), InputError);

  const LandmarkTrack landmarks =
      read_landmarks_csv(folder.write("points.csv", csv_of(scene.landmarks)));
  const TrackGuidance guidance{{}, &landmarks, false};
  const TrackedVideo tracked = track_video(clip, guidance, {}, silent, {});
  EXPECT_EQ(tracked.frames_with_face, static_cast<int>(scene.pictures.size()));
  const double off_px = distance(tracked.contours, scene.truth);
  RecordProperty("distance_px", std::to_string(off_px));
  EXPECT_LT(off_px, 3.0);
}

TEST(Landmarks, AsAPriorEndNearerToTheTruthThanTheyAre) {
  const ScratchFolder folder;
  const Scene& scene = smiling_performer();
  const std::string clip = write_video(folder / "clip.mp4", scene.pictures);
  const std::vector<Landmarks> noisy = with_noise(scene.landmarks, 3.0);
  const LandmarkTrack landmarks = read_landmarks_csv(folder.write("points.csv", csv_of(noisy)));
  std::vector<ContourSet> raw;
  for (size_t f = 0; f < noisy.size(); ++f) {
    raw.push_back(contours_from_landmarks(noisy[f]));
    raw.back().frame_index = static_cast<int>(f);
  }
  SilentObserver silent;
  const TrackGuidance guidance{{}, &landmarks, true};
  const TrackedVideo tracked = track_video(clip, guidance, {}, silent, {});
  const double raw_px = distance(raw, scene.truth);
  const double tracked_px = distance(tracked.contours, scene.truth);
  RecordProperty("raw_px", std::to_string(raw_px));
  RecordProperty("tracked_px", std::to_string(tracked_px));
  EXPECT_LT(tracked_px, 0.8 * raw_px) << raw_px;

  // It pulls: with landmarks that all lie lower, the contours do.
  LandmarkTrack lower = landmarks;
  for (auto& [frame, points] : lower.seen) {
    points = scene.landmarks[static_cast<size_t>(frame)];
    for (Point2& p : points) p.y() += 6.0;
  }
  const ContourSet start = scene.truth[0];
  const auto mean_y = [&](bool prior) {
    const TrackedVideo pulled =
        track_video(clip, TrackGuidance{start, &lower, prior}, {}, silent, {});
    double sum = 0.0;
    for (const Point2& p : pulled.contours.back().visible("chin_boss")->points_px) sum += p.y();
    return sum / 9.0;
  };
  EXPECT_GT(mean_y(true), mean_y(false) + 0.5);
}

// --- models ---------------------------------------------------------------------------------

constexpr const char* kCascade = "/usr/share/opencv4/haarcascades/haarcascade_frontalface_alt2.xml";

bool find_box(cv::InputArray image, cv::OutputArray boxes, void* cascade) {
  std::vector<cv::Rect> found;
  static_cast<cv::CascadeClassifier*>(cascade)->detectMultiScale(
      image, found, 1.1, 3, 0, cv::Size(80, 80));
  if (found.size() != 1) return false;
  cv::Mat(1, 1, CV_32SC4, found.data()).copyTo(boxes);
  return true;
}

// Trains a Facemark of few and shallow trees on a performer's pictures, moved about.
std::string train_facemark(const std::string& path, cv::CascadeClassifier& cascade) {
  const Scene& scene = smiling_performer();
  cv::face::FacemarkLBF::Params params;
  params.n_landmarks = static_cast<int>(kNumLandmarks);
  params.initShape_n = 3;
  params.stages_n = 2;
  params.tree_n = 1;
  params.tree_depth = 2;
  params.feats_m = {20, 20};
  params.radius_m = {0.3, 0.2};
  params.model_filename = path;
  params.verbose = false;
  const auto facemark = cv::face::FacemarkLBF::create(params);
  facemark->setFaceDetector(find_box, &cascade);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> shift(-20.0, 20.0);
  for (size_t f = 0; f < scene.pictures.size(); f += 4) {
    const cv::Matx23d move(1.0, 0.0, shift(random), 0.0, 1.0, shift(random));
    cv::Mat moved;
    cv::warpAffine(
        scene.pictures[f], moved, move, scene.pictures[f].size(), 1, cv::BORDER_REPLICATE);
    std::vector<cv::Point2f> points;
    for (const Point2& p : scene.landmarks[f]) {
      points.emplace_back(static_cast<float>(p.x() + move(0, 2)),
                          static_cast<float>(p.y() + move(1, 2)));
    }
    facemark->addTrainingSample(moved, points);
  }
  facemark->training();
  return path;
}

TEST(LandmarkModel, FacemarkFindsEyesAndStartsTheTrack) {
  cv::CascadeClassifier cascade;
  if (!cascade.load(kCascade)) GTEST_SKIP() << kCascade << " is not there";
  const ScratchFolder folder;
  const Scene& scene = smiling_performer();
  const std::string model = train_facemark(folder / "model.yaml", cascade);

  testing::internal::CaptureStdout();
  const auto finder = make_face_finder({}, model);
  const std::optional<FaceEyes> eyes = finder->find(scene.pictures[2]);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "") << "the library must be silent";
  ASSERT_TRUE(eyes && eyes->landmarks && eyes->both_seen);
  const Point2 right = right_eye_of(scene.landmarks[2]);
  const Point2 left = left_eye_of(scene.landmarks[2]);
  const double apart = (left - right).norm();
  EXPECT_LT((eyes->right_px - right).norm(), 0.1 * apart);
  EXPECT_LT((eyes->left_px - left).norm(), 0.1 * apart);
  EXPECT_FALSE(finder->find(cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(90))));
  EXPECT_FALSE(finder->find(cv::Mat()));

  TrackerOptions options;
  options.landmark_model = model;
  Tracker tracker(options);
  const ContourSet first = tracker.track({0, 0.0, scene.pictures[2]});
  ASSERT_TRUE(tracker.report().face_found);
  // The model sees the picture the way round the tracker does.
  const Mirror& mirror = tracker.mirror();
  const std::optional<FaceEyes> seen = finder->find(mirror.of({0, 0.0, scene.pictures[2]}).bgr());
  ASSERT_TRUE(seen && seen->landmarks);
  const ContourSet marked =
      contours_from_landmarks(mirror.of(*seen->landmarks, scene.pictures[2].cols));
  for (const char* name : {"brow_left", "upper_lip"}) {
    const Contour* contour = first.visible(name);
    ASSERT_NE(contour, nullptr);
    EXPECT_LT((contour->points_px[4] - marked.visible(name)->points_px[4]).norm(), 0.1) << name;
  }

  // Half of it, or one for other landmarks, is refused before it can do harm.
  const std::string whole = bytes_of(model);
  const auto refusal = [](const std::string& path) {
    return message_of<InputError>([&] { make_face_finder({}, path); });
  };
  const std::string half = folder.write("half.yaml", whole.substr(0, whole.size() / 2));
  EXPECT_NE(refusal(half).find("half.yaml: not a whole Facemark"), std::string::npos);
  std::string fewer = whole;
  fewer.replace(fewer.find("n_landmarks: 68"), 15, "n_landmarks: 29");
  EXPECT_NE(refusal(folder.write("fewer.yaml", fewer)).find("68 landmarks"), std::string::npos);
}

// A network in the form of YuNet (an ONNX file, written field by field) that sees one face wherever
// it looks: three outputs of fixed values, joined to the picture by weights of zero.
class FixedYunet {
 public:
  // Anchors of a picture of 320x320, of which a smaller one uses the first. The face is that of
  // anchor `seen`; its box and points are given as the network gives them.
  FixedYunet(int seen, const std::vector<float>& box_and_points) {
    std::vector<float> places(kAnchors * 14, 0.0f);
    std::vector<float> scores(kAnchors * 2, 0.0f);
    std::copy(box_and_points.begin(), box_and_points.end(), places.begin() + seen * 14);
    scores[static_cast<size_t>(seen) * 2 + 1] = 0.95f;
    add_node({"picture"}, {"mean"}, "GlobalAveragePool");
    add_output("loc", places, 14);
    add_output("conf", scores, 2);
    add_output("iou", std::vector<float>(kAnchors, 1.0f), 1);
    text(graph_, 2, "yunet");
    text(graph_, 11, tensor_type("picture", {1, 3, 320, 320}));
  }

  std::string bytes() const {
    std::string opset, model;
    integer(opset, 2, 11);
    integer(model, 1, 6);
    text(model, 7, graph_);
    text(model, 8, opset);
    return model;
  }

 private:
  static constexpr int kAnchors = 5875;

  static void varint(std::string& out, std::uint64_t value) {
    for (; value >= 128; value >>= 7) out += static_cast<char>(value % 128 + 128);
    out += static_cast<char>(value);
  }
  static void integer(std::string& out, int field, std::uint64_t value) {
    varint(out, static_cast<std::uint64_t>(field) << 3);
    varint(out, value);
  }
  static void text(std::string& out, int field, const std::string& bytes) {
    varint(out, (static_cast<std::uint64_t>(field) << 3) + 2);
    varint(out, bytes.size());
    out += bytes;
  }
  static std::string tensor_type(const std::string& name, const std::vector<int>& sizes) {
    std::string shape, tensor, type, info;
    for (const int size : sizes) {
      std::string dimension;
      integer(dimension, 1, static_cast<std::uint64_t>(size));
      text(shape, 1, dimension);
    }
    integer(tensor, 1, 1);  // float
    text(tensor, 2, shape);
    text(type, 1, tensor);
    text(info, 1, name);
    text(info, 2, type);
    return info;
  }
  void add_constant(const std::string& name,
                    const std::vector<int>& sizes,
                    int type,
                    const void* data,
                    size_t num_bytes) {
    std::string tensor;
    for (const int size : sizes) integer(tensor, 1, static_cast<std::uint64_t>(size));
    integer(tensor, 2, static_cast<std::uint64_t>(type));
    text(tensor, 8, name);
    text(tensor, 9, std::string(static_cast<const char*>(data), num_bytes));
    text(graph_, 5, tensor);
  }
  void add_node(const std::vector<std::string>& inputs,
                const std::vector<std::string>& outputs,
                const std::string& kind) {
    std::string node;
    for (const std::string& name : inputs) text(node, 1, name);
    for (const std::string& name : outputs) text(node, 2, name);
    text(node, 3, outputs[0]);
    text(node, 4, kind);
    if (kind == "Conv") {
      constexpr int kIntegers = 7;
      std::string kernel;
      text(kernel, 1, "kernel_shape");
      for (int axis = 0; axis < 2; ++axis) integer(kernel, 8, 1);
      integer(kernel, 20, kIntegers);
      text(node, 5, kernel);
    }
    text(graph_, 1, node);
  }
  void add_output(const std::string& name, const std::vector<float>& values, int columns) {
    const int count = static_cast<int>(values.size());
    const std::vector<float> zeros(values.size() * 3, 0.0f);
    const std::int64_t shape[] = {kAnchors, columns};
    constexpr int kFloat = 1, kInteger = 7;
    add_constant(name + "_weights", {count, 3, 1, 1}, kFloat, zeros.data(), 4 * zeros.size());
    add_constant(name + "_values", {count}, kFloat, values.data(), 4 * values.size());
    add_constant(name + "_shape", {2}, kInteger, shape, sizeof shape);
    add_node({"mean", name + "_weights", name + "_values"}, {name + "_flat"}, "Conv");
    add_node({name + "_flat", name + "_shape"}, {name}, "Reshape");
    text(graph_, 12, tensor_type(name, {kAnchors, columns}));
  }

  std::string graph_;
};

TEST(LandmarkModel, YunetGivesTheEyesInPixelsOfThePicture) {
  const ScratchFolder folder;
  // The first anchor of the 21st cell of the 11th row of a map 40 cells wide: centre (164, 84), 10
  // px wide. Offsets are tenths of that; sizes are exponents of a fifth.
  const int seen = (10 * 40 + 20) * 3;
  std::vector<float> face(14, 0.0f);
  face[2] = face[3] = 5.0f * std::log(6.0f);  // 60 px wide
  face[4] = -15.0f;                           // right eye: 15 px to the left ...
  face[5] = -8.0f;                            // ... and 8 up
  face[6] = 17.0f;
  face[7] = -7.0f;
  const std::string model = folder.write("model.onnx", FixedYunet(seen, face).bytes());
  const auto finder = make_face_finder("/no/cascades/needed", model);
  for (const double enlarged : {1.0, 2.0}) {
    const cv::Size size(static_cast<int>(320 * enlarged), static_cast<int>(240 * enlarged));
    const std::optional<FaceEyes> eyes = finder->find(cv::Mat(size, CV_8UC3, cv::Scalar::all(9)));
    ASSERT_TRUE(eyes) << enlarged;
    EXPECT_TRUE(eyes->both_seen && !eyes->landmarks);
    EXPECT_LT((eyes->right_px - enlarged * Point2(149.0, 76.0)).norm(), 1.5 * enlarged);
    EXPECT_LT((eyes->left_px - enlarged * Point2(181.0, 77.0)).norm(), 1.5 * enlarged);
  }
  // One whose eyes coincide is no face.
  face[4] = face[6];
  face[5] = face[7];
  const std::string blind = folder.write("blind.onnx", FixedYunet(seen, face).bytes());
  EXPECT_FALSE(make_face_finder({}, blind)->find(cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(9))));
}

TEST(LandmarkModel, OthersAreRefusedInOneLine) {
  const ScratchFolder folder;
  const std::string clip =
      write_video(folder / "clip.mp4",
                  {smiling_performer().pictures.begin(), smiling_performer().pictures.begin() + 2});
  const std::vector<std::pair<std::string, std::string>> cases{
      {folder / "missing.onnx", "no such file"},
      {folder.write("text.onnx", "no network"), "not a YuNet model"},
      {folder.write("empty.onnx", ""), "not a YuNet model"},
      {folder.write("text.yaml", "no model\n"), "not a whole Facemark"},
      {folder.write("other.xml", "<?xml version=\"1.0\"?><opencv_storage></opencv_storage>"),
       "not a whole Facemark"},
      {folder.write("model.caffemodel", "unknown"), "unknown kind of model"},
      {folder / "", "no such file"},
  };
  for (const auto& [model, words] : cases) {
    const Outcome outcome =
        run_program(folder, {"track", clip, "-o", folder / "out", "--landmark-model", model});
    EXPECT_EQ(outcome.code, 2) << model;
    EXPECT_EQ(num_lines(outcome.err), 1) << outcome.err;
    EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("expected a YuNet"), std::string::npos) << outcome.err;
  }
}

}  // namespace
}  // namespace zygoma
