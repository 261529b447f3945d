// How far a contour is to be trusted, and why.
//
// Six terms say what is seen of a contour in a frame, each in [kLeastTerm, 1] with 1 for the best:
//
//   presence   evidence of its edge under it, against that of a clear edge
//   sameness   the same, against what lay under it at the start
//   sight      forward-backward check of the flow that carried its nodes here
//   likeness   of its part of the face to the most similar remembered look
//   nearness   exp(-d / 1.5 px), d from where flow and model expected it to where it settled
//   usualness  exp(-d / 8 px), d from where such a contour usually lies to where it was placed at
//              the start, chart px
//
// The confidence is a probability: the share of frames that look like this in which the contour is
// within kTrustedDistance of the truth on average (mean distance of its line to the true line, less
// the fixed offset between the feature and the line of the face model that stands for it). It is a
// monotone map of the terms,
//
//   c = 1 / (1 + exp(-z)),   z = bias + sum_k weight_k log(term_k),   weight_k >= 0,
//
// fitted per kind of contour on performers whose contours are known, disturbed in many ways, and
// verified on others (tests/hard/tracker_confidence_test.cpp; docs/tracking.md has the table).
// Performers are cleaner than people, so c stays below kMostConfidence.
#pragma once

#include <array>
#include <string_view>

namespace zygoma {

enum ConfidenceTerm : unsigned {
  kPresence,
  kSameness,
  kSight,
  kLikeness,
  kNearness,
  kUsualness,
  kNumConfidenceTerms
};
using ConfidenceTerms = std::array<double, kNumConfidenceTerms>;
inline constexpr ConfidenceTerms kBestTerms{1.0, 1.0, 1.0, 1.0, 1.0, 1.0};

inline constexpr double kTrustedDistance = 0.02;  // of the eye distance
inline constexpr double kMostConfidence = 0.9;
inline constexpr double kLeastTerm = 0.02;

std::string_view to_string(ConfidenceTerm term);

struct ConfidenceMap {
  double bias = 0.0;
  ConfidenceTerms weight{};
};

// The map fitted for a contour of the schema; that of all contours for one it was not fitted for.
const ConfidenceMap& confidence_map(std::string_view contour);
double confidence_of(const ConfidenceMap& map, const ConfidenceTerms& terms);
// The term that costs most: why a confidence is not higher.
ConfidenceTerm weakest_term(const ConfidenceMap& map, const ConfidenceTerms& terms);

}  // namespace zygoma
