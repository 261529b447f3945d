#include "tracker/confidence.h"

#include <algorithm>
#include <cmath>

#include "tracker/confidence_table.h"

namespace zygoma {
namespace {

double log_of(double term) { return std::log(std::clamp(term, kLeastTerm, 1.0)); }

}  // namespace

std::string_view to_string(ConfidenceTerm term) {
  constexpr std::array<std::string_view, kNumConfidenceTerms> kNames{
      "presence", "sameness", "sight", "likeness", "nearness", "usualness"};
  return kNames[term];
}

const ConfidenceMap& confidence_map(std::string_view contour) {
  for (const NamedConfidenceMap& named : kConfidenceMaps) {
    if (contour.starts_with(named.contours)) return named.map;
  }
  return kConfidenceMaps.back().map;
}

double confidence_of(const ConfidenceMap& map, const ConfidenceTerms& terms) {
  double z = map.bias;
  for (unsigned k = 0; k < kNumConfidenceTerms; ++k) z += map.weight[k] * log_of(terms[k]);
  return std::clamp(1.0 / (1.0 + std::exp(-z)), 1e-3, kMostConfidence);
}

ConfidenceTerm weakest_term(const ConfidenceMap& map, const ConfidenceTerms& terms) {
  unsigned weakest = 0;
  for (unsigned k = 1; k < kNumConfidenceTerms; ++k) {
    if (map.weight[k] * log_of(terms[k]) < map.weight[weakest] * log_of(terms[weakest]))
      weakest = k;
  }
  return static_cast<ConfidenceTerm>(weakest);
}

}  // namespace zygoma
