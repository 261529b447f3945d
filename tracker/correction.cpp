#include "tracker/correction.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>

#include "src/base/check.h"
#include "src/base/names.h"
#include "tracker/initialiser.h"

namespace zygoma {
namespace {

constexpr double kHold = 0.05;     // of a node to where it starts, against image forces of one
constexpr double kSame = 0.3;      // chart px: no further off is back on the automatic track
constexpr int kSameFrames = 3;     // in a row, and the influence has ended
constexpr double kCraterPx = 1.0;  // r0 of a volcano
constexpr int kMostIterations = 300;
constexpr int kFadeFrames = 30;  // at the end of the reach

using Nodes = std::vector<Point2>;

// A mouse force in the chart of the frame it acts in.
struct Force {
  MouseForce kind = MouseForce::kSpring;
  double along = 0.0;
  Point2 at = Point2::Zero();
  double stiffness = 0.0;
  double radius = 0.0;  // spring, pin: share of arc length; volcano: chart px
};

// The image's landscape with volcanoes in it.
class LandscapeUnderMouse : public ImageLandscape {
 public:
  LandscapeUnderMouse(const ImageLandscape& image, const std::vector<Force>& forces)
      : image_(image), forces_(forces) {}

  double potential(size_t node, const Point2& x) const override {
    double sum = image_.potential(node, x);
    for (const Force& volcano : forces_) {
      const double r = distance(volcano, x);
      if (r >= volcano.radius) continue;
      const double at_rim = std::log(volcano.radius / std::max(r, kCraterPx));
      const double inside = r < kCraterPx ? 0.5 * (1.0 - r * r / (kCraterPx * kCraterPx)) : 0.0;
      sum += volcano.stiffness * (at_rim + inside);
    }
    return sum;
  }

  Point2 gradient(size_t node, const Point2& x) const override {
    Point2 sum = image_.gradient(node, x);
    for (const Force& volcano : forces_) {
      const double r = distance(volcano, x);
      if (r >= volcano.radius) continue;
      const double r2 = std::max(r * r, kCraterPx * kCraterPx);
      sum -= volcano.stiffness / r2 * (x - volcano.at);
    }
    return sum;
  }

 private:
  // Springs are none of its business: infinitely far.
  static double distance(const Force& force, const Point2& x) {
    return force.kind == MouseForce::kVolcano ? (x - force.at).norm() : force.radius;
  }

  const ImageLandscape& image_;
  const std::vector<Force>& forces_;
};

size_t nearest_node(double along, size_t num_nodes) {
  return static_cast<size_t>(std::lround(along * static_cast<double>(num_nodes - 1)));
}

// Adds a spring to the anchors of nodes at equal steps of arc length. Neighbours are drawn to where
// the mouse would take them, not to the mouse itself, else nodes would bunch there.
void add_spring(const Force& spring, const Nodes& start, std::vector<SoftAnchor>& anchors) {
  const auto n = static_cast<double>(anchors.size() - 1);
  const size_t nearest = nearest_node(spring.along, anchors.size());
  for (size_t i = 0; i < anchors.size(); ++i) {
    const double off = std::abs(static_cast<double>(i) - spring.along * n) / n;
    const double hat = i == nearest ? 1.0 : std::max(0.0, 1.0 - off / spring.radius);
    if (hat == 0.0) continue;
    SoftAnchor& anchor = anchors[i];
    const Point2 target = spring.at + (start[i] - start[nearest]);
    const double weight = anchor.weight + hat * spring.stiffness;
    anchor.target = (anchor.weight * anchor.target + hat * spring.stiffness * target) / weight;
    anchor.weight = weight;
  }
}

Nodes relax(const Evidence& evidence,
            FeatureIndex feature,
            const Nodes& start,
            const std::vector<Force>& forces) {
  const ContourLandscape image(evidence, feature, start);
  const LandscapeUnderMouse landscape(image, forces);
  std::vector<SoftAnchor> anchors;
  for (const Point2& p : start) anchors.push_back({p, kHold});
  for (const Force& force : forces) {
    if (force.kind != MouseForce::kVolcano) add_spring(force, start, anchors);
  }
  SnakeOptions options = snake_options(feature);
  options.max_iterations = kMostIterations;
  Snake snake(start, options);
  snake.set_anchors(anchors);
  snake.relax(&landscape);
  return resample(snake.nodes(), static_cast<int>(start.size()));
}

Nodes difference(Nodes a, const Nodes& b) {
  for (size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return a;
}

Nodes sum(Nodes a, const Nodes& b, double share) {
  for (size_t i = 0; i < a.size(); ++i) a[i] += share * b[i];
  return a;
}

double largest(const Nodes& offset) {
  double most = 0.0;
  for (const Point2& p : offset) most = std::max(most, p.norm());
  return most;
}

Evidence evidence_of(const FaceChart& chart, const ContourSet& set, const LipMap& lips) {
  EvidenceOptions places;
  const Similarity chart_from_image = chart.image_from_chart.inverse();
  if (const Contour* nose = set.visible("nose_tip")) {
    places.nose_base_px = chart_from_image.apply(nose->points_px[nose->points_px.size() / 2]).y();
  }
  if (const Contour* lip = set.visible("upper_lip")) {
    places.mouth_line_px = 0.5 * (chart_from_image.apply(lip->points_px.front()).y() +
                                  chart_from_image.apply(lip->points_px.back()).y());
  }
  return make_evidence(chart, lips, places);
}

// Made when asked for, and the last one kept: few frames of a range are looked at.
class EvidenceOnDemand {
 public:
  EvidenceOnDemand(const FrameRange& range,
                   const std::vector<FaceChart>& charts,
                   const LipMap& lips,
                   const std::vector<ContourSet>& track)
      : range_(range), charts_(charts), lips_(lips), track_(track) {}

  const Evidence& at(size_t k) {
    if (!known_ || *known_ != k) {
      evidence_ = evidence_of(charts_[k], track_[range_.first + static_cast<int>(k)], lips_);
      known_ = k;
    }
    return evidence_;
  }

 private:
  FrameRange range_;
  const std::vector<FaceChart>& charts_;
  const LipMap& lips_;
  const std::vector<ContourSet>& track_;
  std::optional<size_t> known_;
  Evidence evidence_;
};

// The corrections of one contour and what they make of it.
class OneContour {
 public:
  OneContour(FeatureIndex feature,
             const FrameRange& range,
             const std::vector<FaceChart>& charts,
             EvidenceOnDemand& evidence,
             const std::vector<ContourSet>& track)
      : feature_(feature), range_(range), charts_(charts), evidence_(evidence) {
    for (size_t k = 0; k < charts.size(); ++k) {
      Nodes nodes;
      const Contour& contour = track[range.first + static_cast<int>(k)].contours[feature];
      if (!charts[k].grey.empty()) {
        const Similarity chart_from_image = charts[k].image_from_chart.inverse();
        for (const Point2& p : contour.points_px) nodes.push_back(chart_from_image.apply(p));
      }
      automatic_.push_back(std::move(nodes));
    }
    share_.assign(charts.size(), 0.0);
    sum_.resize(charts.size());
    held_.assign(charts.size(), 0);
  }

  // Frames at which the contour is corrected, in order.
  void solve(const std::map<int, std::vector<Correction>>& by_frame) {
    for (auto at = by_frame.begin(); at != by_frame.end(); ++at) {
      const size_t k = static_cast<size_t>(at->first - range_.first);
      if (automatic_[k].empty()) continue;  // lost: nothing to pull at
      const Nodes alone = left_alone(k);
      std::vector<Force> forces = forces_in_chart(at->second, charts_[k]);
      for (Force& force : forces) {
        if (force.kind == MouseForce::kVolcano) continue;
        const size_t node = nearest_node(force.along, alone.size());
        force.at -= automatic_[k][node] - alone[node];
      }
      const Nodes offset =
          difference(relax(evidence_.at(k), feature_, automatic_[k], forces), alone);
      contribute(k, sum(automatic_[k], offset, 1.0), 1.0);
      held_[k] = 1;
      std::vector<Force> pins = forces;
      std::erase_if(pins, [](const Force& f) { return f.kind != MouseForce::kPin; });
      const auto next = std::next(at);
      spread(k, +1, next == by_frame.end() ? 0 : next->first - at->first, offset, pins);
      spread(k, -1, at == by_frame.begin() ? 0 : at->first - std::prev(at)->first, offset, pins);
    }
  }

  bool changed(size_t k) const { return share_[k] > 0.0; }
  bool held(size_t k) const { return held_[k] != 0; }
  const Nodes& automatic(size_t k) const { return automatic_[k]; }

  // Where the contour lies now, chart px; what corrections leave to the automatic track stays its.
  Nodes nodes(size_t k) const {
    Nodes result = automatic_[k];
    if (!changed(k)) return result;
    const double rest = std::max(0.0, 1.0 - share_[k]);
    for (size_t i = 0; i < result.size(); ++i) {
      result[i] = (sum_[k][i] + rest * result[i]) / (share_[k] + rest);
    }
    return result;
  }

 private:
  static std::vector<Force> forces_in_chart(const std::vector<Correction>& corrections,
                                            const FaceChart& chart) {
    const Similarity chart_from_image = chart.image_from_chart.inverse();
    std::vector<Force> forces;
    for (const Correction& c : corrections) {
      const double radius =
          c.force == MouseForce::kVolcano ? c.radius * chart_from_image.scale() : c.radius;
      forces.push_back({c.force, c.along, chart_from_image.apply(c.at_px), c.stiffness, radius});
    }
    return forces;
  }

  void contribute(size_t k, const Nodes& nodes, double share) {
    if (sum_[k].empty()) sum_[k].assign(nodes.size(), Point2::Zero());
    for (size_t i = 0; i < nodes.size(); ++i) sum_[k][i] += share * nodes[i];
    share_[k] += share;
  }

  // Where the snake of the automatic contour goes under this landscape without a mouse: what
  // differs from that is the correction's doing.
  Nodes left_alone(size_t k) { return relax(evidence_.at(k), feature_, automatic_[k], {}); }

  // Takes the correction's offset along, frame by frame. `neighbour`: frames to the next correction
  // that way, 0 = none.
  void spread(size_t from, int way, int neighbour, Nodes offset, const std::vector<Force>& pins) {
    const int reach = neighbour > 0 ? neighbour - 1 : kCorrectionReach;
    std::vector<Nodes> found;
    int same = 0;
    for (int step = 1; step <= reach; ++step) {
      const int at = static_cast<int>(from) + way * step;
      if (at < 0 || at >= static_cast<int>(charts_.size())) break;
      const auto k = static_cast<size_t>(at);
      if (automatic_[k].empty()) break;
      const double keep =
          neighbour > 0 ? 1.0 : std::min(1.0, static_cast<double>(reach - step) / kFadeFrames);
      const Nodes start = sum(automatic_[k], offset, keep);
      offset = difference(relax(evidence_.at(k), feature_, start, pins), left_alone(k));
      found.push_back(sum(automatic_[k], offset, 1.0));
      same = largest(offset) < kSame ? same + 1 : 0;
      if (same == kSameFrames) break;
    }
    const size_t num = found.size() - (same == kSameFrames ? kSameFrames : 0);
    for (size_t step = 1; step <= num; ++step) {
      const size_t k = from + static_cast<size_t>(way * static_cast<int>(step));
      const double share = neighbour > 0 ? 1.0 - static_cast<double>(step) / neighbour : 1.0;
      contribute(k, found[step - 1], share);
      held_[k] = held_[k] || !pins.empty();
    }
  }

  FeatureIndex feature_;
  FrameRange range_;
  const std::vector<FaceChart>& charts_;
  EvidenceOnDemand& evidence_;
  std::vector<Nodes> automatic_;  // chart px; empty: lost
  // Weighted sum of what the corrections found, and its weight.
  std::vector<Nodes> sum_;
  std::vector<double> share_;
  std::vector<char> held_;
};

// The lips share their corners: an end that was corrected takes the other lip's with it, and what
// is next to it by less and less.
void bring_end(Nodes& nodes, bool front, const Point2& to) {
  constexpr size_t kBent = 4;
  const Point2 way = to - (front ? nodes.front() : nodes.back());
  for (size_t i = 0; i < std::min(kBent, nodes.size()); ++i) {
    Point2& p = front ? nodes[i] : nodes[nodes.size() - 1 - i];
    p += (1.0 - static_cast<double>(i) / kBent) * way;
  }
}

void join_corners(const OneContour& upper, const OneContour& lower, size_t k, Nodes& a, Nodes& b) {
  for (const bool front : {true, false}) {
    const Point2 p = front ? a.front() : a.back();
    const Point2 q = front ? b.front() : b.back();
    const double upper_share = upper.changed(k) ? (lower.changed(k) ? 0.5 : 1.0) : 0.0;
    const Point2 corner = upper_share * p + (1.0 - upper_share) * q;
    bring_end(a, front, corner);
    bring_end(b, front, corner);
  }
}

}  // namespace

void Correction::check() const {
  const std::string name = "correction " + std::to_string(id) + ": ";
  require(frame >= 0, name + "frame is " + std::to_string(frame) + ", expected 0 or above");
  require(find_name(kFeatureSchema, contour) >= 0,
          name + "contour is \"" + contour + "\", expected a name such as upper_lip");
  require(at_px.allFinite(), name + "x, y: expected finite numbers of pixels");
  require_range(name + "s", along, 0.0, 1.0);
  require_range(name + "k", stiffness, 1e-3, 1e4);
  if (force == MouseForce::kVolcano) {
    require_range(name + "radius", radius, 0.1, 1e4);
  } else {
    require_range(name + "radius", radius, 1e-3, 1.0);
  }
}

std::vector<FrameRange> reach_of(const std::vector<Correction>& corrections, int num_frames) {
  std::vector<int> frames;
  for (const Correction& correction : corrections) {
    require(correction.frame < num_frames,
            "correction " + std::to_string(correction.id) + ": frame is " +
                std::to_string(correction.frame) + ", expected 0 to " +
                std::to_string(num_frames - 1));
    frames.push_back(correction.frame);
  }
  std::sort(frames.begin(), frames.end());
  std::vector<FrameRange> ranges;
  for (const int frame : frames) {
    const FrameRange range{std::max(0, frame - kCorrectionReach),
                           std::min(num_frames - 1, frame + kCorrectionReach)};
    if (!ranges.empty() && range.first <= ranges.back().last + 1) {
      ranges.back().last = range.last;
    } else {
      ranges.push_back(range);
    }
  }
  return ranges;
}

int apply_corrections(const std::vector<Correction>& corrections,
                      const FrameRange& range,
                      const std::vector<FaceChart>& charts,
                      const LipMap& lips,
                      std::vector<ContourSet>& track) {
  EvidenceOnDemand evidence(range, charts, lips, track);
  std::vector<OneContour> contours;
  for (size_t f = 0; f < kNumFeatures; ++f) {
    std::map<int, std::vector<Correction>> by_frame;
    for (const Correction& correction : corrections) {
      if (correction.contour != kFeatureSchema[f].name) continue;
      if (correction.frame < range.first || correction.frame > range.last) continue;
      by_frame[correction.frame].push_back(correction);
    }
    contours.emplace_back(static_cast<FeatureIndex>(f), range, charts, evidence, track);
    contours.back().solve(by_frame);
  }
  int num_changed = 0;
  for (size_t k = 0; k < charts.size(); ++k) {
    const OneContour& upper = contours[kUpperLip];
    const OneContour& lower = contours[kLowerLip];
    const bool lips_changed = upper.changed(k) || lower.changed(k);
    std::optional<std::pair<Nodes, Nodes>> joined;
    if (lips_changed && !upper.automatic(k).empty() && !lower.automatic(k).empty()) {
      joined.emplace(upper.nodes(k), lower.nodes(k));
      join_corners(upper, lower, k, joined->first, joined->second);
    }
    for (size_t f = 0; f < kNumFeatures; ++f) {
      const bool is_lip = f == kUpperLip || f == kLowerLip;
      if (!contours[f].changed(k) && !(is_lip && joined)) continue;
      const Nodes nodes = !(is_lip && joined) ? contours[f].nodes(k)
                          : f == kUpperLip    ? joined->first
                                              : joined->second;
      Contour& contour = track[range.first + static_cast<int>(k)].contours[f];
      for (size_t i = 0; i < nodes.size(); ++i) {
        contour.points_px[i] = charts[k].image_from_chart.apply(nodes[i]);
      }
      if (contours[f].held(k)) {
        contour.locked = true;
        contour.confidence = 1.0;
      }
      ++num_changed;
    }
  }
  return num_changed;
}

}  // namespace zygoma
