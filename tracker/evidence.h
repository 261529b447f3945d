// What each contour looks for in the picture.
//
//   brow      upper edge of a dark band: brightness falls downwards
//   upper lip outer border: the lip map (lip_map.h) rises downwards, brightness falls
//   lower lip outer border: the lip map falls downwards, brightness rises
//   nose tip  base of the nose: brightness rises downwards, from the nostrils to the lip
//   chin      the broad shading edge below the chin, at a large scale: brightness falls downwards
//   furrow    any edge, weakly; at rest there is often none and flow alone carries it
//   hairline  the strongest edge between skin and hair, either sign
//   eyelid    where skin gives way to lashes: brightness falls downwards
//
// The lip map takes in the dark line between the lips, which reaches further into the corners of
// the mouth than the colour of the lips does.
//
// Each contour's landscape is a sum of such terms, every term normalised by itself, so that the
// weights add up to one.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "tracker/face_chart.h"
#include "tracker/feature_schema.h"
#include "tracker/lip_map.h"
#include "tracker/potential_field.h"
#include "tracker/snake.h"

namespace zygoma {

// Places in kFeatureSchema.
enum FeatureIndex : size_t {
  kBrowLeft,
  kBrowRight,
  kFurrowLeft,
  kFurrowRight,
  kNoseTip,
  kUpperLip,
  kLowerLip,
  kChinBoss,
  kHairline,
  kEyelidLeft,
  kEyelidRight,
  kNumFeatures
};
using ContourNodes = std::array<std::vector<Point2>, kNumFeatures>;  // chart px

// The landscapes of one chart.
struct Evidence {
  PotentialField fine;  // brightness, small scale: brows, nose, lips
  PotentialField chin;  // brightness, large scale, about the chin
  PotentialField hair;  // the same about the hairline
  PotentialField lips;  // the lip map
  // The filled lip map (of one) of the lower face summed down each column, row r: above r.
  cv::Mat lip_sums;

  // Integral of the lip map down a column between two heights, chart px.
  double lip_column(double x, double top, double bottom) const;
};

struct EvidenceOptions {
  double fine_sigma_px = 1.6;    // [0.7, 4]
  double coarse_sigma_px = 3.0;  // [1, 8]
  double lips_sigma_px = 1.8;    // [1, 5]: chroma is stored at half resolution in most video
  double nose_base_px = 151.0;   // chart row of the base of the nose: no mouth above it
  double mouth_line_px = 177.6;  // chart row of the corners of the mouth: dark lines count near it
};

Evidence make_evidence(const FaceChart& chart,
                       const LipMap& lips,
                       const EvidenceOptions& options = {});

// One of the edges that a contour looks for.
struct EvidenceTerm {
  const PotentialField* field = nullptr;
  double weight = 0.0;
  double sign = 0.0;  // of the downward normal along which the field should rise; 0: either
};
using EvidenceTerms = std::array<EvidenceTerm, 2>;  // those with a field

// The landscape of one contour about its present nodes: their normals fix the polarity.
class ContourLandscape : public ImageLandscape {
 public:
  ContourLandscape(const Evidence& evidence,
                   FeatureIndex feature,
                   const std::vector<Point2>& nodes);
  double potential(size_t node, const Point2& x) const override;
  Point2 gradient(size_t node, const Point2& x) const override;

 private:
  EvidenceTerms terms_;
  std::vector<Point2> normals_;  // to the right of the walk from the subject's right to left: down
};

// Mean of -P along the nodes: how much of the wanted edge is under the contour, about [0, 1.5].
double evidence_under(const Evidence& evidence,
                      FeatureIndex feature,
                      const std::vector<Point2>& nodes);

}  // namespace zygoma
