#include "retarget/calibration.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "retarget/head_motion.h"
#include "src/base/check.h"
#include "tracker/robust.h"

namespace zygoma {
namespace {

double quantile(std::vector<double> values, double share) {
  const auto at = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  return values[at];
}

// Two places on the face whose distance measures its size.
struct Span {
  std::array<int, 2> contour;
  Point2 (*from)(const NodeStack&);
  Point2 (*to)(const NodeStack&);
};

Point2 mean_of(const NodeStack& nodes, int contour) {
  return nodes.middleCols(node_begin(contour), num_nodes(contour)).rowwise().mean();
}
Point2 brow_centre(const NodeStack& n) {
  return 0.5 * (mean_of(n, kBrowLeftContour) + mean_of(n, kBrowRightContour));
}
Point2 brow_left(const NodeStack& n) { return mean_of(n, kBrowLeftContour); }
Point2 brow_right(const NodeStack& n) { return mean_of(n, kBrowRightContour); }
Point2 nose(const NodeStack& n) { return mean_of(n, kNoseTipContour); }
Point2 chin(const NodeStack& n) { return mean_of(n, kChinBossContour); }
Point2 right_corner(const NodeStack& n) { return n.col(first_node(kUpperLipContour)); }
Point2 left_corner(const NodeStack& n) { return n.col(last_node(kUpperLipContour)); }
Point2 lip_centre(const NodeStack& n) { return mean_of(n, kUpperLipContour); }

const std::array<Span, 7> kSpans{{
    {{kBrowLeftContour, kBrowRightContour}, brow_left, brow_right},
    {{kUpperLipContour, kUpperLipContour}, right_corner, left_corner},
    {{kBrowLeftContour, kChinBossContour}, brow_left, chin},
    {{kBrowRightContour, kChinBossContour}, brow_right, chin},
    {{kBrowLeftContour, kNoseTipContour}, brow_left, nose},
    {{kBrowRightContour, kNoseTipContour}, brow_right, nose},
    {{kNoseTipContour, kUpperLipContour}, nose, lip_centre},
}};

// Size of a face in its own units (pixels or mm), from what is visible; 0 if nothing is.
double face_size(const StackedContours& contours) {
  double sum = 0.0;
  int count = 0;
  for (const Span& span : kSpans) {
    if (!contours.visible(span.contour[0]) || !contours.visible(span.contour[1])) continue;
    sum += (span.from(contours.nodes) - span.to(contours.nodes)).squaredNorm();
    ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : 0.0;
}

// All frames carried into one head frame, with what tells rest from expression.
struct ShapeTrack {
  std::vector<NodeStack> shape;  // pixels of the reference frame
  std::vector<double> lip_gap;   // per frame, in face sizes; NaN where unseen
  std::vector<double> mouth_width;
  std::vector<double> brow_height;
  double face_size_px = 1.0;
};

ShapeTrack align_frames(const std::vector<ObservedFrame>& frames, const ObservedFrame& reference) {
  constexpr double kUnseen = std::numeric_limits<double>::quiet_NaN();
  ShapeTrack track;
  track.face_size_px = std::max(1e-6, face_size(reference.contours));
  for (const ObservedFrame& frame : frames) {
    const Eigen::VectorXd weight = head_weights(reference.contours, frame.contours);
    const HeadMotion motion = fit_head_motion_robustly(
        reference.contours.nodes, frame.contours.nodes, weight, 0.01 * track.face_size_px);
    const HeadMotion back = motion.inverse();
    NodeStack shape;
    for (int k = 0; k < kNumNodes; ++k) shape.col(k) = back * Point2(frame.contours.nodes.col(k));
    const auto seen = [&](int contour) { return frame.contours.visible(contour); };
    const double unit = track.face_size_px;
    const double gap =
        shape(1, centre_node(kLowerLipContour)) - shape(1, centre_node(kUpperLipContour));
    const double height =
        seen(kNoseTipContour) ? nose(shape).y() - brow_centre(shape).y() : -brow_centre(shape).y();
    track.lip_gap.push_back(seen(kUpperLipContour) && seen(kLowerLipContour) ? gap / unit
                                                                             : kUnseen);
    track.mouth_width.push_back(seen(kUpperLipContour)
                                    ? (left_corner(shape) - right_corner(shape)).norm() / unit
                                    : kUnseen);
    track.brow_height.push_back(seen(kBrowLeftContour) && seen(kBrowRightContour) ? height / unit
                                                                                  : kUnseen);
    track.shape.push_back(shape);
  }
  return track;
}

std::vector<double> seen_values(const std::vector<double>& values) {
  std::vector<double> seen;
  std::copy_if(values.begin(), values.end(), std::back_inserter(seen), [](double v) {
    return std::isfinite(v);
  });
  return seen;
}

// RMS distance of two shapes over the contours that move with expressions and are visible in both
// frames, in face sizes; furrows left out, as they come and go.
double shape_distance(const StackedContours& a,
                      const StackedContours& b,
                      const NodeStack& shape_a,
                      const NodeStack& shape_b,
                      double unit) {
  double sum = 0.0;
  int count = 0;
  for (const int c : {kBrowLeftContour,
                      kBrowRightContour,
                      kUpperLipContour,
                      kLowerLipContour,
                      kChinBossContour}) {
    if (!a.visible(c) || !b.visible(c)) continue;
    const Eigen::Index begin = node_begin(c);
    sum += (shape_a.middleCols(begin, num_nodes(c)) - shape_b.middleCols(begin, num_nodes(c)))
               .squaredNorm();
    count += num_nodes(c);
  }
  return count > 0 ? std::sqrt(sum / count) / unit : std::numeric_limits<double>::infinity();
}

NodeStack median_shape(const std::vector<ObservedFrame>& frames,
                       const std::vector<NodeStack>& shape,
                       std::size_t begin,
                       std::size_t end) {
  NodeStack result = NodeStack::Zero();
  for (int c = 0; c < kNumContours; ++c) {
    for (int k = node_begin(c); k < node_begin(c + 1); ++k) {
      for (int axis = 0; axis < 2; ++axis) {
        std::vector<double> values;
        for (std::size_t t = begin; t < end; ++t) {
          if (frames[t].contours.visible(c)) values.push_back(shape[t](axis, k));
        }
        if (!values.empty()) result(axis, k) = median(values);
      }
    }
  }
  return result;
}

std::size_t fullest_frame(const std::vector<ObservedFrame>& frames) {
  std::size_t best = 0;
  for (std::size_t t = 1; t < frames.size(); ++t) {
    if (frames[t].contours.num_visible() > frames[best].contours.num_visible()) best = t;
  }
  return best;
}

constexpr double kStretch_s = 0.3;  // length of a still stretch
constexpr std::size_t kFewestFrames = 3;
constexpr std::size_t kMostFrames = 15;

// Frames of the window of kStretch_s that starts at `begin`; {begin, end}.
std::size_t window_end(const std::vector<ObservedFrame>& frames, std::size_t begin) {
  std::size_t end = begin;
  while (end < frames.size() && end - begin < kMostFrames &&
         (end - begin < kFewestFrames || frames[end].time_s - frames[begin].time_s <= kStretch_s)) {
    ++end;
  }
  return end;
}

// Centres of windows that do not overlap, the one that looks most like a face at rest first, with
// how far it does not.
std::vector<std::pair<std::size_t, double>> find_rest(const std::vector<ObservedFrame>& frames,
                                                      const ShapeTrack& track,
                                                      int most) {
  const auto low = [](const std::vector<double>& values) {
    const std::vector<double> seen = seen_values(values);
    return seen.empty() ? 0.0 : quantile(seen, 0.1);
  };
  const double low_gap = low(track.lip_gap);
  const double low_width = low(track.mouth_width);
  std::vector<double> brows = seen_values(track.brow_height);
  const double usual_brow = brows.empty() ? 0.0 : median(brows);
  const NodeStack usual = median_shape(frames, track.shape, 0, frames.size());
  const double duration = std::max(1e-9, frames.back().time_s - frames.front().time_s);

  const auto excess = [](double value, double reference) {
    return std::isfinite(value) ? std::max(0.0, value - reference) : 0.05;
  };
  struct Candidate {
    double score;
    std::size_t begin, end;
  };
  std::vector<Candidate> candidates;
  for (std::size_t begin = 0; begin < frames.size(); ++begin) {
    const std::size_t end = window_end(frames, begin);
    if (begin > 0 && end - begin < kFewestFrames) break;
    const NodeStack middle = median_shape(frames, track.shape, begin, end);
    double motion = 0.0;
    double strain = 0.0;
    for (std::size_t t = begin; t < end; ++t) {
      const StackedContours& seen = frames[t].contours;
      motion += shape_distance(seen, seen, track.shape[t], middle, track.face_size_px);
      strain += 0.5 * excess(track.lip_gap[t], low_gap);
      strain += 0.25 * excess(track.mouth_width[t], low_width);
      if (std::isfinite(track.brow_height[t])) {
        strain += 0.5 * std::abs(track.brow_height[t] - usual_brow);
      }
      strain += 0.02 * (kNumContours - seen.num_visible());
      strain += 0.25 * shape_distance(seen, seen, track.shape[t], usual, track.face_size_px);
    }
    const double late = 0.01 * (frames[begin].time_s - frames.front().time_s) / duration;
    const double score = (3.0 * motion + strain) / static_cast<double>(end - begin) + late;
    candidates.push_back({score, begin, end});
  }
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    return a.score < b.score;
  });
  std::vector<Candidate> chosen;
  for (const Candidate& next : candidates) {
    if (static_cast<int>(chosen.size()) == most) break;
    const bool is_apart = std::all_of(chosen.begin(), chosen.end(), [&](const Candidate& taken) {
      return next.end <= taken.begin || taken.end <= next.begin;
    });
    if (is_apart) chosen.push_back(next);
  }
  std::vector<std::pair<std::size_t, double>> centres;
  for (const Candidate& window : chosen) {
    centres.emplace_back((window.begin + window.end - 1) / 2, window.score);
  }
  return centres;
}

// Neighbours of the chosen frame in which the face has not moved yet.
std::array<std::size_t, 2> still_stretch(const std::vector<ObservedFrame>& frames,
                                         const ShapeTrack& track,
                                         std::size_t centre) {
  constexpr double kStill = 0.008;  // face sizes: about 1 mm
  const auto is_still = [&](std::size_t t) {
    return std::abs(frames[t].time_s - frames[centre].time_s) <= 0.5 * kStretch_s &&
           shape_distance(frames[t].contours,
                          frames[centre].contours,
                          track.shape[t],
                          track.shape[centre],
                          track.face_size_px) < kStill;
  };
  std::size_t begin = centre;
  std::size_t end = centre + 1;
  while (begin > 0 && end - begin < kMostFrames && is_still(begin - 1)) --begin;
  while (end < frames.size() && end - begin < kMostFrames && is_still(end)) ++end;
  return {begin, end};
}

// How the mouth stands, as shares of the size of the face.
struct MouthPose {
  double width = 0.0;
  double gap = 0.0;   // of the outer borders, in the middle
  double rise = 0.0;  // corners above the middle of the mouth
  double tilt = 0.0;  // left corner above the right one
};

MouthPose mouth_pose(const NodeStack& n, double size) {
  const Point2 upper = n.col(centre_node(kUpperLipContour));
  const Point2 lower = n.col(centre_node(kLowerLipContour));
  const Point2 across = (left_corner(n) - right_corner(n)).normalized();
  const Point2 down(-across.y(), across.x());
  const Point2 brows = (brow_left(n) - brow_right(n)).normalized();
  MouthPose pose;
  pose.width = (left_corner(n) - right_corner(n)).norm() / size;
  pose.gap = down.dot(lower - upper) / size;
  pose.rise = down.dot(0.5 * (upper + lower) - 0.5 * (left_corner(n) + right_corner(n))) / size;
  pose.tilt = across.x() * brows.y() - across.y() * brows.x();
  return pose;
}

}  // namespace

std::vector<std::string> doubts_about(const Neutral& neutral, const FaceResponse& model) {
  // Shares of the face beyond which ordinary proportions do not explain a mouth; the tilt in rad.
  constexpr double kWide = 0.12;
  constexpr double kOpen = 0.07;
  constexpr double kRaised = 0.045;
  constexpr double kTilted = 0.09;
  std::vector<std::string> doubts;
  const auto seen = [&](int contour) {
    return neutral.contours.visible(contour) &&
           model.has_contour[static_cast<std::size_t>(contour)];
  };
  if (!seen(kUpperLipContour) || !seen(kLowerLipContour)) {
    doubts.emplace_back("the mouth is not seen");
    return doubts;
  }
  if (!seen(kBrowLeftContour) || !seen(kBrowRightContour)) {
    doubts.emplace_back("a brow is not seen");
    return doubts;
  }
  StackedContours usual;
  usual.nodes = model.rest_mm;
  usual.confidence = neutral.contours.confidence;
  const MouthPose now = mouth_pose(neutral.contours.nodes, face_size(neutral.contours));
  const MouthPose rest = mouth_pose(usual.nodes, face_size(usual));
  if (now.gap > rest.gap + kOpen) doubts.emplace_back("the lips are apart");
  if (now.width > rest.width + kWide || now.rise > rest.rise + kRaised) {
    doubts.emplace_back("the mouth smiles");
  }
  if (std::abs(now.tilt) > kTilted) doubts.emplace_back("left and right are not alike");
  return doubts;
}

Neutral neutral_at(const std::vector<ObservedFrame>& frames, int frame_index) {
  const auto chosen = std::find_if(frames.begin(), frames.end(), [&](const ObservedFrame& f) {
    return f.frame_index == frame_index;
  });
  require(chosen != frames.end(),
          "neutral_frame is " + std::to_string(frame_index) +
              ": this frame has no usable contours; expected a frame in which the face is "
              "tracked");
  const auto centre = static_cast<std::size_t>(chosen - frames.begin());
  const ShapeTrack track = align_frames(frames, frames[centre]);
  const auto [begin, end] = still_stretch(frames, track, centre);

  Neutral neutral;
  neutral.frame_index = frames[centre].frame_index;
  neutral.num_frames = static_cast<int>(end - begin);
  neutral.contours.nodes = median_shape(frames, track.shape, begin, end);
  for (std::size_t c = 0; c < neutral.contours.confidence.size(); ++c) {
    std::vector<double> confidence;
    for (std::size_t t = begin; t < end; ++t) {
      confidence.push_back(frames[t].contours.confidence[c]);
    }
    neutral.contours.confidence[c] = median(confidence);
  }
  return neutral;
}

std::vector<Neutral> neutral_candidates(const std::vector<ObservedFrame>& frames, int most) {
  require(!frames.empty(), "no frame has contours; expected at least one");
  const ShapeTrack track = align_frames(frames, frames[fullest_frame(frames)]);
  std::vector<Neutral> candidates;
  for (const auto& [centre, score] : find_rest(frames, track, most)) {
    candidates.push_back(neutral_at(frames, frames[centre].frame_index));
    candidates.back().score = score;
  }
  return candidates;
}

Point2 PerformerFrame::to_mm(const Point2& image_px) const {
  const Point2 p = image_px - centre_px;
  const double c = std::cos(roll_rad) * millimetre_per_px;
  const double s = std::sin(roll_rad) * millimetre_per_px;
  return {c * p.x() + s * p.y(), -s * p.x() + c * p.y()};
}

Point2 PerformerFrame::to_px(const Point2& model_mm) const {
  const double c = std::cos(roll_rad) / millimetre_per_px;
  const double s = std::sin(roll_rad) / millimetre_per_px;
  return centre_px +
         Point2(c * model_mm.x() - s * model_mm.y(), s * model_mm.x() + c * model_mm.y());
}

Eigen::VectorXd face_proportions(const StackedContours& contours) {
  constexpr double kUnseen = std::numeric_limits<double>::quiet_NaN();
  Eigen::VectorXd result = Eigen::VectorXd::Constant(kSpans.size() + 1, kUnseen);
  const double size = face_size(contours);
  if (size <= 0.0) return result;
  for (std::size_t i = 0; i < kSpans.size(); ++i) {
    const Span& span = kSpans[i];
    if (!contours.visible(span.contour[0]) || !contours.visible(span.contour[1])) continue;
    result[static_cast<Eigen::Index>(i)] =
        (span.from(contours.nodes) - span.to(contours.nodes)).norm() / size;
  }
  if (contours.visible(kEyelidLeftContour) && contours.visible(kEyelidRightContour)) {
    result[kSpans.size()] =
        (contours.mean(kEyelidLeftContour) - contours.mean(kEyelidRightContour)).norm() / size;
  }
  return result;
}

double proportion_difference(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  double sum = 0.0;
  int count = 0;
  for (Eigen::Index i = 0; i < std::min(a.size(), b.size()); ++i) {
    if (!std::isfinite(a[i]) || !std::isfinite(b[i])) continue;
    const double relative = 2.0 * (a[i] - b[i]) / (a[i] + b[i]);
    sum += relative * relative;
    ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : 0.0;
}

PerformerFrame measure_performer(const Neutral& neutral, const FaceResponse& model) {
  const auto usable = [&](int contour) {
    return neutral.contours.visible(contour) &&
           model.has_contour[static_cast<std::size_t>(contour)];
  };
  double product = 0.0;
  double square = 0.0;
  for (const Span& span : kSpans) {
    if (!usable(span.contour[0]) || !usable(span.contour[1])) continue;
    const double px = (span.from(neutral.contours.nodes) - span.to(neutral.contours.nodes)).norm();
    const double mm = (span.from(model.rest_mm) - span.to(model.rest_mm)).norm();
    product += px * mm;
    square += px * px;
  }
  require(square > 0.0 && product > 0.0,
          "frame " + std::to_string(neutral.frame_index) +
              ": the neutral shows too few contours to measure the face; expected brows, mouth, "
              "nose or chin");

  PerformerFrame performer;
  performer.millimetre_per_px = product / square;
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(kNumNodes);
  for (const int c : {kBrowLeftContour,
                      kBrowRightContour,
                      kNoseTipContour,
                      kUpperLipContour,
                      kLowerLipContour,
                      kChinBossContour}) {
    if (usable(c)) weight.segment(node_begin(c), num_nodes(c)).setConstant(1.0 / num_nodes(c));
  }
  const HeadMotion pose = fit_head_motion(model.rest_mm, neutral.contours.nodes, weight);
  performer.roll_rad = pose.roll_rad();
  // The origin of the model (midway between the pupils) keeps rotations of the head small in mm.
  performer.centre_px = pose * Point2(0.0, 0.0);
  performer.face_unit_px =
      (brow_centre(model.rest_mm) - chin(model.rest_mm)).norm() / performer.millimetre_per_px;
  for (int k = 0; k < kNumNodes; ++k) {
    performer.neutral_mm.col(k) = performer.to_mm(neutral.contours.nodes.col(k));
  }
  return performer;
}

}  // namespace zygoma
