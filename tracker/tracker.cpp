#include "tracker/tracker.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>
#include <variant>

#include "src/base/check.h"
#include "tracker/brow_shape.h"
#include "tracker/chin_patch.h"
#include "tracker/evidence.h"
#include "tracker/face_chart.h"
#include "tracker/face_finder.h"
#include "tracker/head_pose.h"
#include "tracker/initialiser.h"
#include "tracker/mouth_seam.h"
#include "tracker/predictor.h"
#include "tracker/robust.h"
#include "tracker/scene_cut.h"
#include "tracker/snake.h"

namespace zygoma {
namespace {

// Regions of the chart whose looks are remembered together (keyframes).
enum Part : size_t { kUpperPart, kLowerPart, kNumParts };
const std::array<cv::Rect, kNumParts> kPartBox{cv::Rect(20, 58, 153, 44),
                                               cv::Rect(48, 152, 97, 84)};

constexpr double kStill = 0.02;             // chart px: below it the head has not moved
constexpr double kLeastEyeDistance = 12.0;  // px
constexpr double kCornerHold = 4.0;         // times flow_hold
constexpr double kChinHold = 10.0;
constexpr double kLidShare = 0.8;        // of the model of the lid, the rest is flow
constexpr double kChinFollowsLip = 0.8;  // share of the lower lip's motion
constexpr double kFurrowPull = 0.2;      // per frame, at the lower end
constexpr double kClearEdge = 0.25;  // evidence, of which one is the strongest edges of the face
constexpr double kNearness_px = 1.5;
constexpr double kUsualness_px = 8.0;
constexpr double kTrustedOutline = 0.5;  // of the evidence at the start, under the mouth model
// Of what the start showed the model to be off by: the rest it may correct.
constexpr double kBesideModel = 0.5;
constexpr double kPriorQuality = 0.5;   // as flow that was seen fairly well
constexpr double kUnseenQuality = 0.5;  // of nodes that no flow was asked for
constexpr double kSameScene = 0.5;      // correlation of the middle of the face, frame to frame

Part part_of(size_t feature) {
  switch (feature) {
    case kUpperLip:
    case kLowerLip:
    case kChinBoss:
      return kLowerPart;
    default:
      return kUpperPart;
  }
}

// A look at one part of the face whose contours were trusted: flow from here has not drifted.
struct Keyframe {
  FaceChart chart;
  cv::Mat thumbnail;  // of the part's box
  ContourNodes contours;
};

// Where the nodes are expected, before the picture has its say.
struct Prediction {
  ContourNodes target;
  std::array<std::vector<double>, kNumFeatures> quality;  // of the sight of each node, [0, 1]
  std::array<double, kNumParts> likeness{};               // of the look that anchored the part
};

// A part of the chart made small, less its mean and of unit norm; zero if it is flat.
cv::Mat small_look(const FaceChart& chart, const cv::Rect& box, const cv::Size& size) {
  cv::Mat small;
  cv::resize(chart.grey(box), small, size, 0, 0, cv::INTER_AREA);
  small.convertTo(small, CV_32F);
  small -= cv::mean(small);
  const double norm = cv::norm(small);
  constexpr double kFlat = 1e-3;  // grey levels, mean spread
  const bool flat = norm < kFlat * std::sqrt(static_cast<double>(small.total()));
  small *= flat ? 0.0 : 1.0 / norm;
  return small;
}

cv::Mat thumbnail_of(const FaceChart& chart, Part part) {
  return small_look(chart, kPartBox[part], cv::Size(32, 24));
}

// Normalised cross-correlation of two small looks, [-1, 1]; 0 for a flat one.
double correlation(const cv::Mat& p, const cv::Mat& q) { return p.dot(q); }

// The look that resembles a thumbnail most, and how much; null if there is none. Older looks are
// nearer to the start: a younger one must be clearly better.
const Keyframe* most_alike(const std::vector<Keyframe>& looks,
                           const cv::Mat& thumbnail,
                           double& likeness) {
  const Keyframe* best = nullptr;
  likeness = -1.0;
  for (const Keyframe& look : looks) {
    const double c = correlation(thumbnail, look.thumbnail);
    if (c <= likeness + 0.01) continue;
    likeness = c;
    best = &look;
  }
  return best;
}

// Eyes and nose.
cv::Mat middle_look(const FaceChart& chart) {
  return small_look(chart, cv::Rect(44, 84, 105, 70), cv::Size(30, 20));
}

// The parts of the face that do not move with expression: inner and outer corners of the eyes, the
// bridge, sides and base of the nose, and a thin grid between them.
// Depths are those of a usual face.
std::vector<RigidPoint> rigid_points() {
  std::vector<RigidPoint> points;
  const auto add = [&](double x, double y, double depth) {
    points.push_back({chart_point(x, y), depth * kChartEyeDistance});
  };
  for (const double side : {-1.0, 1.0}) {
    for (const double x : {0.22, 0.34, 0.66, 0.78}) {
      for (const double y : {-0.05, 0.06}) add(side * x, y, 0.06 - 0.25 * (x - 0.3) * (x > 0.3));
    }
    for (const double y : {0.15, 0.3, 0.42, 0.52, 0.62}) {
      add(side * 0.13, y, 0.14 + 0.4 * y);
      add(side * 0.24, y, 0.06 + 0.25 * y);
    }
  }
  for (const double y : {-0.05, 0.1, 0.25, 0.4, 0.55, 0.68}) add(0.0, y, 0.22 + 0.5 * y);
  return points;
}

// Spread of the second differences over the face: low in a blocky or blurred picture.
double sharpness_of(const FaceChart& chart) {
  cv::Mat curvature;
  cv::Laplacian(chart.grey(cv::Rect(36, 44, 121, 180)), curvature, CV_32F);
  cv::Scalar mean, spread;
  cv::meanStdDev(curvature, mean, spread);
  return spread[0];
}

// How far a contour's nodes lie before the eyes on a usual face, chart px: a + b x^2, x from the
// middle of the face.
double usual_depth(FeatureIndex feature, const Point2& node) {
  const double x = (node.x() - kChartEyeMiddle.x()) / kChartEyeDistance;
  switch (feature) {
    case kBrowLeft:
    case kBrowRight:
      return kChartEyeDistance * (0.16 - 0.5 * x * x);
    case kUpperLip:
    case kLowerLip:
      return kChartEyeDistance * (0.4 - 0.7 * x * x);
    case kChinBoss:
      return kChartEyeDistance * (0.25 - 0.5 * x * x);
    default:
      return 0.0;
  }
}

std::vector<Point2> turned(std::vector<Point2> nodes, FeatureIndex feature, const HeadTurn& turn) {
  for (Point2& p : nodes) p = turn.apply(p, usual_depth(feature, p));
  return nodes;
}

Point2 middle_of(const std::vector<Point2>& nodes) {
  Point2 sum = Point2::Zero();
  for (const Point2& p : nodes) sum += p;
  return sum / static_cast<double>(nodes.size());
}

// Moves the nodes a share of the way to others.
void draw(const std::vector<Point2>& to, double share, std::vector<Point2>& nodes) {
  for (size_t i = 0; i < nodes.size(); ++i) nodes[i] += share * (to[i] - nodes[i]);
}

std::vector<Point2> shifted(std::vector<Point2> nodes, const Point2& offset) {
  for (Point2& p : nodes) p += offset;
  return nodes;
}

// The values of a chain at `count` places evenly spread over its nodes.
template <typename Value>
std::vector<Value> spread_over(const std::vector<Value>& values, size_t count) {
  std::vector<Value> result;
  for (size_t k = 0; k < count; ++k) {
    const double at = static_cast<double>(k * (values.size() - 1)) / static_cast<double>(count - 1);
    const size_t i = std::min(static_cast<size_t>(at), values.size() - 2);
    const double share = at - static_cast<double>(i);
    result.push_back((1.0 - share) * values[i] + share * values[i + 1]);
  }
  return result;
}

// The eyes as found in the picture, or, where not both are seen there, in its mirror image as well:
// the cascades were not made of mirrored faces and may see more that way.
std::optional<FaceEyes> find_evenly(FaceFinder& finder, const cv::Mat& picture) {
  const std::optional<FaceEyes> plain = finder.find(picture);
  if (picture.empty() || (plain && (plain->landmarks || plain->both_seen))) return plain;
  cv::Mat turned_over;
  cv::flip(picture, turned_over, 1);
  std::optional<FaceEyes> mirrored = finder.find(turned_over);
  if (!mirrored || mirrored->landmarks) return plain;
  const double last_column = picture.cols - 1.0;
  mirrored->left_px.x() = last_column - mirrored->left_px.x();
  mirrored->right_px.x() = last_column - mirrored->right_px.x();
  std::swap(mirrored->left_px, mirrored->right_px);
  if (!plain) return mirrored;
  const double iod = (plain->left_px - plain->right_px).norm();
  const double apart = std::max((plain->left_px - mirrored->left_px).norm(),
                                (plain->right_px - mirrored->right_px).norm());
  if (apart > 0.2 * iod) return plain;  // two faces
  return FaceEyes{0.5 * (plain->right_px + mirrored->right_px),
                  0.5 * (plain->left_px + mirrored->left_px),
                  plain->both_seen && mirrored->both_seen};
}

void require_finite(const ContourSet& set) {
  for (const Contour& contour : set.contours) {
    for (const Point2& p : contour.points_px) {
      require(p.allFinite(),
              "tracker: contour " + contour.name + " given for frame " +
                  std::to_string(set.frame_index) +
                  " holds a number that is not finite; expected pixels");
    }
  }
}

void require_finite(const Landmarks& landmarks) {
  for (const Point2& p : landmarks) {
    require(p.allFinite(), "tracker: landmarks hold a number that is not finite; expected pixels");
  }
}

// What others say of where a face is.
using Marks = std::variant<ContourSet, Landmarks>;

std::optional<ContourSet> take(std::optional<Marks>& marks, const Mirror& mirror, int width) {
  if (!marks) return std::nullopt;
  const Marks taken = *std::exchange(marks, std::nullopt);
  if (const auto* set = std::get_if<ContourSet>(&taken)) return mirror.of(*set, width);
  return contours_from_landmarks(mirror.of(std::get<Landmarks>(taken), width));
}

}  // namespace

void TrackerEffort::check() const {
  require_range("tracker: gaussian_levels", gaussian_levels, 1, 4);
  require_range("tracker: nodes", nodes, 0.4, 8.0);
  require_range("tracker: tolerance_px", tolerance_px, 1e-9, 1.0);
  require_range("tracker: max_iterations", max_iterations, 1, 100000);
}

void TrackerOptions::check() const {
  effort.check();
  require_range("tracker: max_coast_frames", max_coast_frames, 0, 1000);
  require_range("tracker: flow_hold", flow_hold, 0.0, 100.0);
  require_range("tracker: model_share", model_share, 0.0, 1.0);
  require_range("tracker: prior_share", prior_share, 0.0, 1.0);
  require(sharper > 1.0, "tracker: sharper is " + shortest_text(sharper) + ", expected above 1");
  require(new_look_correlation > 0.0 && new_look_correlation < 1.0,
          "tracker: new_look_correlation must be in (0, 1)");
}

struct Tracker::Impl {
  explicit Impl(const TrackerOptions& wanted) : options(wanted) { options.check(); }

  // What goes in and out, as things are; everything else is as it is looked at (mirror.h).
  Mirror mirror;
  std::optional<Marks> given_as_is;  // by start_from, for the next frame
  std::optional<Marks> prior_as_is;  // by set_prior, for the next frame
  TrackReport report_as_is;
  Similarity head_as_is;

  TrackerOptions options;
  TrackReport report;
  std::shared_ptr<FaceFinder> finder;
  SceneCut cut;
  std::optional<ContourSet> given;
  std::optional<ContourSet> prior;

  bool tracking = false;
  bool started_by_hand = false;
  int age = 0;             // frames since the start
  double sharpness = 0.0;  // of the chart it started on
  int coasted = 0;
  FaceChart last;
  ContourNodes contours;
  std::array<cv::Mat, kNumParts> thumbnails;  // of its parts, and its middle
  cv::Mat middle;
  ContourNodes at_start;  // where the contours were placed
  LipMap lips;
  Mouth mouth;
  Mouth rest;                        // where it started, closed
  std::array<Lid, 2> lids;           // left, right
  std::vector<Point2> beside_model;  // the upper lip where it started, less the model's there
  SeamCorners seam;
  ChinPatch chin_patch;
  std::array<double, kNumFeatures> confidence{};
  std::array<ConfidenceTerms, kNumFeatures> terms{};
  std::array<double, kNumFeatures> usual_evidence{};
  std::vector<cv::Mat> head_anchor;  // the core of the first sight
  Exposure exposure;
  HeadTurn turn;  // against the first sight
  std::vector<RigidPoint> rigid = rigid_points();
  std::array<std::vector<Keyframe>, kNumParts> keyframes;

  bool start(const Picture& picture);
  bool start_from_given(const Picture& picture);
  void recover(const Picture& picture);
  void look_again(const Picture& picture);
  void restart_at(const Picture& picture, const FaceEyes& eyes);
  void restart_from(const FaceChart& chart, const ContourNodes& given_nodes = {});
  void compare_with_model(const FaceChart& chart);
  bool follow(const Picture& picture);
  std::vector<Point2> follow_chin(const FaceChart& chart, double& sight) const;
  bool follow_head(const Picture& picture, FaceChart& chart);
  double trust_in(const Mouth& found, const Evidence& evidence) const;
  void follow_contours(const FaceChart& chart);
  ContourNodes nodes_in_chart(const ContourSet& set, const Similarity& image_from_chart) const;
  void look_at(const FaceChart& chart);
  Prediction predict(const FaceChart& chart) const;
  void draw_lips(const Evidence& evidence, ContourNodes& target);
  void draw_to_models(const FaceChart& chart, const Evidence& evidence, Prediction& prediction);
  void relax(const Evidence& evidence, const Prediction& prediction, const ContourNodes& start);
  void keep_shapes(const Prediction& prediction);
  void judge(const Evidence& evidence, const Prediction& prediction);
  void judge_start(const Evidence& evidence, const ContourNodes& given_nodes);
  void remember(const FaceChart& chart);
  ContourSet track(const Picture& picture);
  ContourSet result(const Picture& picture) const;
};

bool Tracker::Impl::start(const Picture& picture) {
  if (!finder) finder = make_face_finder(options.cascade_folder, options.landmark_model);
  const std::optional<FaceEyes> eyes = find_evenly(*finder, picture.bgr());
  if (!eyes) return false;
  restart_at(picture, *eyes);
  started_by_hand = false;
  return true;
}

void Tracker::Impl::restart_at(const Picture& picture, const FaceEyes& eyes) {
  const Similarity place = image_from_chart(eyes.right_px, eyes.left_px);
  ContourNodes marked;
  if (eyes.landmarks) marked = nodes_in_chart(contours_from_landmarks(*eyes.landmarks), place);
  restart_from(make_face_chart(picture, place), marked);
}

// The contours of a picture that are there, in chart px and with the schema's numbers of nodes.
ContourNodes Tracker::Impl::nodes_in_chart(const ContourSet& set,
                                           const Similarity& image_from_chart) const {
  const Similarity chart_from_image = image_from_chart.inverse();
  ContourNodes nodes;
  for (size_t f = 0; f < kNumFeatures; ++f) {
    const Contour* contour = set.visible(kFeatureSchema[f].name);
    if (contour == nullptr || contour->points_px.size() < 2) continue;
    nodes[f] = resample(contour->points_px, kFeatureSchema[f].num_nodes);
    for (Point2& p : nodes[f]) p = chart_from_image.apply(p);
  }
  return nodes;
}

// The user's contours: where they are gives the head, they themselves stay, the rest is placed.
bool Tracker::Impl::start_from_given(const Picture& picture) {
  const ContourSet set = *std::exchange(given, std::nullopt);
  const ContourNodes usual = template_contours();
  ContourNodes placed;
  std::vector<Point2> from, to;
  for (size_t f = 0; f < kNumFeatures; ++f) {
    const Contour* contour = set.visible(kFeatureSchema[f].name);
    if (contour == nullptr || contour->points_px.size() < 2) continue;
    placed[f] = resample(contour->points_px, kFeatureSchema[f].num_nodes);
    from.insert(from.end(), usual[f].begin(), usual[f].end());
    to.insert(to.end(), placed[f].begin(), placed[f].end());
  }
  // The scale of the head is free, so shrink to about one before the robust fit judges it.
  const auto spread = [](const std::vector<Point2>& points) {
    Point2 mean = Point2::Zero();
    for (const Point2& p : points) mean += p / static_cast<double>(points.size());
    double sum = 0.0;
    for (const Point2& p : points) sum += (p - mean).norm() / static_cast<double>(points.size());
    return sum;
  };
  if (from.empty() || !(spread(to) > 1.0)) return false;
  const double scale = spread(to) / spread(from);
  for (Point2& p : to) p /= scale;
  const HeadFrameFit fit = fit_head_frame(from, to, 4.0);
  if (!fit.ok) return false;
  const Similarity place = Similarity{scale, 0.0, Point2::Zero()}.after(fit.similarity);
  if (place.scale() * kChartEyeDistance < kLeastEyeDistance) return false;
  const Similarity inverse = place.inverse();
  for (auto& nodes : placed) {
    for (Point2& p : nodes) p = inverse.apply(p);
  }
  restart_from(make_face_chart(picture, place), placed);
  started_by_hand = true;
  return true;
}

// Video often opens with a few blocky frames. When the face has become clearly sharper since the
// start, and its lips stand out better, the start is made again.
void Tracker::Impl::look_again(const Picture& picture) {
  if (started_by_hand || (age != 12 && age != 25)) return;
  if (sharpness_of(last) < options.sharper * sharpness) return;
  const std::optional<FaceEyes> eyes = find_evenly(*finder, picture.bgr());
  if (!eyes) return;
  const int frames = age;
  restart_at(picture, *eyes);
  age = frames;
}

void Tracker::Impl::restart_from(const FaceChart& chart, const ContourNodes& given_nodes) {
  PlacedFace placed = place_contours(chart);
  contours = placed.contours;
  lips = placed.lips;
  mouth = placed.mouth;
  lids = {placed.left_lid, placed.right_lid};
  for (size_t f = 0; f < kNumFeatures; ++f) {
    if (!given_nodes[f].empty()) contours[f] = given_nodes[f];
  }
  at_start = contours;
  rest = placed.rest;
  seam.forget();
  chin_patch.learn(chart.grey, middle_of(contours[kChinBoss]));
  compare_with_model(chart);
  judge_start(make_evidence(chart, lips), given_nodes);
  last = chart;
  head_anchor = core_of(chart);
  exposure = {level_of(chart), 1.0};
  turn = HeadTurn();
  for (auto& list : keyframes) list.clear();
  look_at(chart);
  remember(chart);
  tracking = true;
  sharpness = sharpness_of(chart);
  age = 0;
  coasted = 0;
  report.started = true;
}

// A pale upper lip is half skin to the model, which leaves it out and lies on its inner edge. Where
// the model has the lip later is read against where it had it at the start.
void Tracker::Impl::compare_with_model(const FaceChart& chart) {
  const std::vector<Point2>& lip = contours[kUpperLip];
  EvidenceOptions places;
  places.nose_base_px = contours[kNoseTip][contours[kNoseTip].size() / 2].y();
  places.mouth_line_px = 0.5 * (lip.front().y() + lip.back().y());
  const Mouth seen = follow_mouth(make_evidence(chart, lips, places), mouth, rest);
  const std::vector<Point2> outline = lip_nodes(seen, true);
  beside_model.assign(lip.size(), Point2::Zero());
  if (mouth.p != rest.p) return;  // open: the teeth below a lip misplace it at the start, too
  for (size_t i = 0; i < outline.size(); ++i) beside_model[i] = lip[i] - outline[i];
}

// Takes the head's motion off: on return `chart` shows the face where the last chart showed it.
bool Tracker::Impl::follow_head(const Picture& picture, FaceChart& chart) {
  const Similarity before = last.image_from_chart;
  const std::vector<cv::Mat> draft = draft_of_core(picture, before, exposure);
  HeadPoseFit pose{Similarity(), turn};  // of the face in the draft
  const auto correct =
      [&](const std::vector<cv::Mat>& reference, const HeadTurn& then, double least_share) {
        const Point2 corner(kCoreBox.x, kCoreBox.y);
        std::vector<Point2> start, guess;
        for (const RigidPoint& point : rigid) {
          start.push_back(then.apply(point.position, point.depth) - corner);
          const Point2 now = pose.turn.apply(point.position, point.depth);
          guess.push_back(pose.similarity.apply(now) - corner);
        }
        const Flow flow = follow_points(reference, draft, start, guess, false);
        std::vector<RigidPoint> seen;
        std::vector<Point2> to;
        for (size_t i = 0; i < rigid.size(); ++i) {
          if (flow.quality[i] < 0.3) continue;
          seen.push_back(rigid[i]);
          to.push_back(flow.points_px[i] + corner);
        }
        const HeadPoseFit fit = fit_head_pose(seen, to, pose.turn);
        const double share =
            fit.inlier_share * static_cast<double>(seen.size()) / static_cast<double>(rigid.size());
        if (!fit.ok || share < least_share) return false;
        pose = fit;
        return true;
      };
  // Against the first sight of the head: motion from frame to frame adds up. Where it no longer
  // looks like that, or went far, by way of the last frame.
  if (!correct(head_anchor, HeadTurn(), 0.5)) {
    if (!correct(core_of(last), turn, 0.3)) return false;
    correct(head_anchor, HeadTurn(), 0.5);
  }
  double moved = 0.0;
  for (const RigidPoint& point : rigid) {
    moved = std::max(moved, (pose.similarity.apply(point.position) - point.position).norm());
  }
  const Similarity place = moved > kStill ? before.after(pose.similarity) : before;
  turn = pose.turn;
  const double eyes_px = place.scale() * kChartEyeDistance;
  if (eyes_px < kLeastEyeDistance || eyes_px > picture.size().width) return false;
  chart = make_face_chart(picture, place, exposure.gain);
  // A cut to something else: the middle of the face no longer looks like it did a frame ago.
  const cv::Mat before_it = middle;
  look_at(chart);
  if (correlation(middle, before_it) > kSameScene) return true;
  look_at(last);
  return false;
}

// The chin is too smooth to say how its contour bends or how far along it a node has slid; it says
// where it is. So the contour keeps its shape and goes where its patch is found, as far as that
// looks like the chin, else with the middle of the lower lip: one bone carries both.
std::vector<Point2> Tracker::Impl::follow_chin(const FaceChart& chart, double& sight) const {
  const ChinPatch::Sight found = chin_patch.find(chart.grey);
  sight = std::clamp((found.likeness - 0.4) / 0.4, 0.0, 1.0);
  const std::vector<Point2>& lip = contours[kLowerLip];
  const std::vector<Point2> lip_then = turned(at_start[kLowerLip], kLowerLip, turn);
  const Point2 by_lip(
      0.0, kChinFollowsLip * (lip[lip.size() / 2].y() - lip_then[lip_then.size() / 2].y()));
  return shifted(at_start[kChinBoss], sight * found.offset_px + (1.0 - sight) * by_lip);
}

// Where compression or coloured light has made skin look like lips, the mouth model takes in the
// chin. Its outline then lies on no edges.
double Tracker::Impl::trust_in(const Mouth& found, const Evidence& evidence) const {
  double least = 1.0;
  for (const FeatureIndex f : {kUpperLip, kLowerLip}) {
    const double share =
        evidence_under(evidence, f, lip_nodes(found, f == kUpperLip)) / usual_evidence[f];
    least = std::min(least, share / kTrustedOutline);
  }
  return std::clamp(2.0 * least - 1.0, 0.0, 1.0);
}

void Tracker::Impl::look_at(const FaceChart& chart) {
  for (size_t part = 0; part < kNumParts; ++part) {
    thumbnails[part] = thumbnail_of(chart, static_cast<Part>(part));
  }
  middle = middle_look(chart);
}

// Where the nodes of the last frame are in this one: by flow from there, and by flow from the
// remembered look that resembles this one most.
Prediction Tracker::Impl::predict(const FaceChart& chart) const {
  Prediction prediction;
  prediction.likeness.fill(1.0);
  if (options.effort.predict_by == PredictBy::kNothing) {
    prediction.target = contours;
    for (size_t f = 0; f < kNumFeatures; ++f) {
      prediction.quality[f].assign(contours[f].size(), kUnseenQuality);
    }
    return prediction;
  }
  std::vector<Point2> from;
  for (size_t f = 0; f < kNumFeatures; ++f) {
    if (f != kChinBoss) from.insert(from.end(), contours[f].begin(), contours[f].end());
  }
  const Flow recent = follow_points(last.pyramid, chart.pyramid, from, from);
  std::array<Flow, kNumParts> anchored;
  for (size_t part = 0; part < kNumParts; ++part) {
    if (options.effort.predict_by != PredictBy::kLooks) break;
    const Keyframe* look = most_alike(keyframes[part], thumbnails[part], prediction.likeness[part]);
    if (look == nullptr) continue;
    std::vector<Point2> then, guess;
    size_t first = 0;
    for (size_t f = 0; f < kNumFeatures; ++f) {
      if (f == kChinBoss) continue;
      const size_t n = contours[f].size();
      if (part_of(f) == part) {
        const auto& nodes = look->contours[f];
        then.insert(then.end(), nodes.begin(), nodes.end());
        guess.insert(
            guess.end(), recent.points_px.begin() + first, recent.points_px.begin() + first + n);
      }
      first += n;
    }
    anchored[part] = follow_points(look->chart.pyramid, chart.pyramid, then, guess, true, 1);
  }
  std::array<size_t, kNumParts> used{};
  size_t at = 0;
  for (size_t f = 0; f < kNumFeatures; ++f) {
    std::vector<Point2>& target = prediction.target[f];
    std::vector<double>& quality = prediction.quality[f];
    const size_t n = contours[f].size();
    if (f == kChinBoss) {  // found by its patch
      target = contours[f];
      quality.assign(n, 0.0);
      continue;
    }
    target.assign(recent.points_px.begin() + at, recent.points_px.begin() + at + n);
    quality.assign(recent.quality.begin() + at, recent.quality.begin() + at + n);
    at += n;
    const Part part = part_of(f);
    if (anchored[part].points_px.empty()) continue;
    const double trust = std::clamp((prediction.likeness[part] - 0.7) / 0.25, 0.0, 1.0);
    for (size_t i = 0; i < n; ++i, ++used[part]) {
      const double w = trust * anchored[part].quality[used[part]];
      const double keep = 0.5 * quality[i] + 0.05;
      target[i] = (keep * target[i] + w * anchored[part].points_px[used[part]]) / (keep + w);
      quality[i] = std::max(quality[i], w);
    }
  }
  return prediction;
}

void Tracker::Impl::draw_lips(const Evidence& evidence, ContourNodes& target) {
  const Mouth found_mouth = follow_mouth(evidence, mouth, rest);
  const double trust = trust_in(found_mouth, evidence);
  if (trust > 0.5) mouth = found_mouth;
  for (const FeatureIndex f : {kUpperLip, kLowerLip}) {
    std::vector<Point2> outline = lip_nodes(found_mouth, f == kUpperLip);
    if (f == kUpperLip) {
      for (size_t i = 0; i < outline.size(); ++i) outline[i] += kBesideModel * beside_model[i];
    }
    draw(outline, trust * options.model_share, target[f]);
  }
}

// What is known of mouths, furrows, chins and lids, and what others say, draws the prediction.
void Tracker::Impl::draw_to_models(const FaceChart& chart,
                                   const Evidence& evidence,
                                   Prediction& prediction) {
  ContourNodes& target = prediction.target;
  // A furrow hardly shows at rest; its lower end stays by the corner of the mouth.
  for (const FeatureIndex f : {kFurrowLeft, kFurrowRight}) {
    const std::vector<Point2> usual =
        furrow_between(target[kNoseTip], target[kUpperLip], f == kFurrowLeft);
    for (size_t i = 0; i < usual.size(); ++i) {
      const double share =
          kFurrowPull * static_cast<double>(i) / static_cast<double>(usual.size() - 1);
      target[f][i] += share * (usual[i] - target[f][i]);
    }
  }
  if (options.effort.predict_by != PredictBy::kNothing) {
    double chin_sight = 0.0;
    target[kChinBoss] = follow_chin(chart, chin_sight);
    std::vector<double>& chin_quality = prediction.quality[kChinBoss];
    std::fill(chin_quality.begin(), chin_quality.end(), chin_sight);
  }
  if (options.effort.models) draw_lips(evidence, target);
  if (prior) {
    const ContourNodes wanted = nodes_in_chart(*prior, chart.image_from_chart);
    for (size_t f = 0; f < kNumFeatures; ++f) {
      if (wanted[f].empty()) continue;
      draw(wanted[f], options.prior_share, target[f]);
      for (double& q : prediction.quality[f]) q = std::max(q, kPriorQuality);
    }
  }
  join_lip_ends(target);
  if (!options.effort.models) return;
  const MouthCorners corners =
      seam.refine(chart.grey, {target[kUpperLip].front(), target[kUpperLip].back()});
  for (const FeatureIndex f : {kUpperLip, kLowerLip}) {
    target[f].front() = corners[kRightCorner];
    target[f].back() = corners[kLeftCorner];
  }
  for (const FeatureIndex f : {kEyelidLeft, kEyelidRight}) {
    Lid& lid = lids[f == kEyelidLeft ? 0 : 1];
    lid = follow_lid(evidence, lid, turn);
    draw(lid_nodes(lid, turn), kLidShare, target[f]);
  }
}

// Snakes on the evidence, softly held where the prediction has their nodes, from `start`.
void Tracker::Impl::relax(const Evidence& evidence,
                          const Prediction& prediction,
                          const ContourNodes& start) {
  const TrackerEffort& effort = options.effort;
  for (size_t f = 0; f < kNumFeatures; ++f) {
    const size_t num_out = prediction.target[f].size();
    const auto num_nodes =
        static_cast<size_t>(std::lround(effort.nodes * static_cast<double>(num_out - 1))) + 1;
    const std::vector<Point2> target = spread_over(prediction.target[f], num_nodes);
    const std::vector<double> quality = spread_over(prediction.quality[f], num_nodes);
    std::vector<SoftAnchor> anchors(num_nodes);
    for (size_t i = 0; i < anchors.size(); ++i) {
      const bool corner = (f == kUpperLip || f == kLowerLip) && (i == 0 || i + 1 == anchors.size());
      const double hold = corner ? kCornerHold : f == kChinBoss ? kChinHold : 1.0;
      const double sight = effort.predict_by == PredictBy::kNothing ? 0.0 : quality[i];
      anchors[i] = {target[i], options.flow_hold * (0.1 + sight) * hold};
    }
    const ContourLandscape landscape(evidence, static_cast<FeatureIndex>(f), target);
    SnakeOptions snake_settings = snake_options(static_cast<FeatureIndex>(f));
    // Shorter springs: more tension and bending for the same chain.
    const double density = static_cast<double>(num_nodes - 1) / static_cast<double>(num_out - 1);
    snake_settings.tension *= std::pow(density, 2);
    snake_settings.rigidity *= std::pow(density, 4);
    snake_settings.stepping = options.stepping;
    snake_settings.tolerance_px = effort.tolerance_px;
    snake_settings.max_iterations = effort.max_iterations;
    Snake snake(target, snake_settings);
    snake.set_anchors(anchors);
    snake.set_nodes(spread_over(start[f], num_nodes));
    report.relax_iterations += snake.relax(&landscape).iterations;
    contours[f] = resample(snake.nodes(), static_cast<int>(num_out));
  }
}

// Brows and lids slide along themselves as their edges do not hold them there, and chins bend as
// nothing is seen of them: their contours are read as motions of what they were.
void Tracker::Impl::keep_shapes(const Prediction& prediction) {
  for (const FeatureIndex f : {kBrowLeft, kBrowRight}) {
    const std::vector<Point2> unmoved = turned(at_start[f], f, turn);
    std::vector<double> slides;
    for (size_t i = 0; i < unmoved.size(); ++i) {
      slides.push_back(prediction.target[f][i].x() - unmoved[i].x());
    }
    contours[f] = as_brow_motion(contours[f], unmoved, median(slides));
  }
  for (const FeatureIndex f : {kEyelidLeft, kEyelidRight}) {
    if (!options.effort.models) break;
    contours[f] = as_brow_motion(contours[f], lid_nodes(lids[f == kEyelidLeft ? 0 : 1], turn), 0.0);
  }
  contours[kChinBoss] =
      shifted(at_start[kChinBoss], middle_of(contours[kChinBoss]) - middle_of(at_start[kChinBoss]));
  join_lip_ends(contours);
}

void Tracker::Impl::follow_contours(const FaceChart& chart) {
  Prediction prediction = predict(chart);
  const ContourNodes& target = prediction.target;
  EvidenceOptions places;
  places.nose_base_px = contours[kNoseTip][contours[kNoseTip].size() / 2].y();
  places.mouth_line_px = 0.5 * (target[kUpperLip].front().y() + target[kUpperLip].back().y());
  const Evidence evidence = make_evidence(chart, lips, places);
  draw_to_models(chart, evidence, prediction);
  ContourNodes nodes = prediction.target;
  for (int level = options.effort.gaussian_levels - 1; level > 0; --level) {
    EvidenceOptions wide = places;
    for (double* sigma : {&wide.fine_sigma_px, &wide.coarse_sigma_px, &wide.lips_sigma_px}) {
      *sigma = std::ldexp(*sigma, level);
    }
    relax(make_evidence(chart, lips, wide), prediction, nodes);
    nodes = contours;
  }
  relax(evidence, prediction, nodes);
  keep_shapes(prediction);
  judge(evidence, prediction);
}

void Tracker::Impl::judge(const Evidence& evidence, const Prediction& prediction) {
  for (size_t f = 0; f < kNumFeatures; ++f) {
    const double found = evidence_under(evidence, static_cast<FeatureIndex>(f), contours[f]);
    const auto n = static_cast<double>(contours[f].size());
    double sight = 0.0;
    double surprise_px = 0.0;
    for (size_t i = 0; i < contours[f].size(); ++i) {
      sight += prediction.quality[f][i] / n;
      surprise_px += (contours[f][i] - prediction.target[f][i]).norm() / n;
    }
    terms[f][kPresence] = std::min(1.0, found / kClearEdge);
    terms[f][kSameness] = std::min(1.0, found / usual_evidence[f]);
    terms[f][kSight] = sight;
    terms[f][kLikeness] = std::max(0.0, prediction.likeness[part_of(f)]);
    terms[f][kNearness] = std::exp(-surprise_px / kNearness_px);
    confidence[f] = confidence_of(confidence_map(kFeatureSchema[f].name), terms[f]);
  }
}

// At the start nothing is known but the place itself and what lies under it.
void Tracker::Impl::judge_start(const Evidence& evidence, const ContourNodes& given_nodes) {
  const ContourNodes usual = template_contours();
  for (size_t f = 0; f < kNumFeatures; ++f) {
    const double found = evidence_under(evidence, static_cast<FeatureIndex>(f), contours[f]);
    usual_evidence[f] = std::max(0.05, found);
    terms[f] = kBestTerms;
    terms[f][kPresence] = std::min(1.0, found / kClearEdge);
    if (given_nodes[f].empty()) {
      double far_px = 0.0;
      const auto n = static_cast<double>(contours[f].size());
      for (size_t i = 0; i < contours[f].size(); ++i) {
        far_px += (contours[f][i] - usual[f][i]).norm() / n;
      }
      terms[f][kUsualness] = std::exp(-far_px / kUsualness_px);
    }
    confidence[f] = confidence_of(confidence_map(kFeatureSchema[f].name), terms[f]);
  }
}

void Tracker::Impl::remember(const FaceChart& chart) {
  for (size_t part = 0; part < kNumParts; ++part) {
    const cv::Mat& now = thumbnails[part];
    double best = -1.0;
    for (const Keyframe& keyframe : keyframes[part]) {
      best = std::max(best, correlation(now, keyframe.thumbnail));
    }
    if (best > options.new_look_correlation || keyframes[part].size() >= 24) continue;
    keyframes[part].push_back({chart, now, contours});
  }
}

bool Tracker::Impl::follow(const Picture& picture) {
  FaceChart chart;
  if (!follow_head(picture, chart)) return false;
  follow_contours(chart);
  remember(chart);
  last = chart;
  ++age;
  coasted = 0;
  look_again(picture);
  return true;
}

// The face was not where it should be: look for it in the whole picture, else wait a few frames.
void Tracker::Impl::recover(const Picture& picture) {
  if (start(picture)) return;
  ++coasted;
  for (double& c : confidence) c *= 0.5;
  if (coasted > options.max_coast_frames) tracking = false;
}

ContourSet Tracker::Impl::result(const Picture& picture) const {
  ContourSet set;
  for (size_t f = 0; f < kNumFeatures; ++f) {
    Contour contour;
    contour.name = kFeatureSchema[f].name;
    if (tracking) {
      int outside = 0;
      for (const Point2& p : contours[f]) {
        const Point2 q = last.image_from_chart.apply(p);
        outside += q.x() < 0.0 || q.y() < 0.0 || q.x() > picture.size().width - 1.0 ||
                   q.y() > picture.size().height - 1.0;
        contour.points_px.push_back(q);
      }
      contour.confidence = confidence[f];
      // Mostly out of the picture: nothing is known of it.
      if (3 * outside > static_cast<int>(contours[f].size())) {
        contour.points_px.clear();
        contour.confidence = 0.0;
      }
    }
    set.contours.push_back(std::move(contour));
  }
  return set;
}

ContourSet Tracker::Impl::track(const Picture& picture) {
  report = {};
  const bool usable = !picture.empty();
  // Whoever is seen after a cut, the contours of before are not theirs.
  if (cut.at(picture)) tracking = false;
  if (usable && given && start_from_given(picture)) {
    // Nothing more to do in this frame.
  } else if (usable && tracking) {
    if (!follow(picture)) recover(picture);
  } else if (usable) {
    start(picture);
  } else {
    tracking = false;
  }
  prior.reset();
  ContourSet set = result(picture);
  report.face_found = tracking;
  report.terms = terms;
  for (const Contour& contour : set.contours) report.num_lost += contour.lost() ? 1 : 0;
  return set;
}

Tracker::Tracker(const TrackerOptions& options) : impl_(std::make_unique<Impl>(options)) {}
Tracker::~Tracker() = default;
Tracker::Tracker(Tracker&&) noexcept = default;
Tracker& Tracker::operator=(Tracker&&) noexcept = default;

void Tracker::start_from(const ContourSet& initial) {
  require_finite(initial);
  impl_->given_as_is = initial;
}

void Tracker::start_from(const Landmarks& initial) {
  require_finite(initial);
  impl_->given_as_is = initial;
}

void Tracker::set_prior(const ContourSet& prior) {
  require_finite(prior);
  impl_->prior_as_is = prior;
}

void Tracker::set_prior(const Landmarks& prior) {
  require_finite(prior);
  impl_->prior_as_is = prior;
}

ContourSet Tracker::track(const Frame& frame) {
  Impl& impl = *impl_;
  const Mirror& mirror = impl.mirror;
  impl.mirror.decide(frame);
  const Picture picture = mirror.of(frame);
  const int width = picture.size().width;
  if (impl.given_as_is) {
    if (const auto* set = std::get_if<ContourSet>(&*impl.given_as_is)) {
      impl.mirror.decide(*set, width);
    }
    impl.given = take(impl.given_as_is, mirror, width);
  }
  impl.prior = take(impl.prior_as_is, mirror, width);
  ContourSet set = mirror.of(impl.track(picture), width);
  set.frame_index = frame.index;
  set.time_s = frame.time_s;
  impl.report_as_is = impl.report;
  impl.report_as_is.terms = mirror.of(impl.report.terms);
  impl.head_as_is = mirror.of(impl.last.image_from_chart, width);
  return set;
}

const TrackReport& Tracker::report() const { return impl_->report_as_is; }

Tracker Tracker::looking_back() const {
  Tracker copy;
  *copy.impl_ = *impl_;
  Impl& impl = *copy.impl_;
  impl.given.reset();
  impl.given_as_is.reset();
  impl.started_by_hand = true;  // nothing is to be mended in its first second
  for (auto& list : impl.keyframes) list.clear();
  if (impl.tracking) impl.remember(impl.last);
  return copy;
}

const Similarity* Tracker::head() const { return impl_->tracking ? &impl_->head_as_is : nullptr; }

const LipMap& Tracker::lips() const { return impl_->lips; }

const Mirror& Tracker::mirror() const { return impl_->mirror; }

}  // namespace zygoma
