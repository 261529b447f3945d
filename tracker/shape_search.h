// Finds the best member of a family of curves: a few parameters with usual values and spreads (a
// Gaussian prior) and a score of how much of the picture speaks for them.
//
// A grid over the first parameters finds the hill, a pattern search its top. Derivative free,
// bounded and without random numbers.
#pragma once

#include <functional>
#include <vector>

namespace zygoma {

struct ShapeFamily {
  std::vector<double> usual;
  std::vector<double> spread;  // of the prior, > 0
  std::vector<double> reach;   // the search stays within usual +- reach
  std::function<double(const std::vector<double>&)> evidence;
  double prior_weight = 0.1;  // of half a squared standard deviation, against the evidence
};

double shape_score(const ShapeFamily& family, const std::vector<double>& p);

// Climbs from `start` with steps that shrink from `coarse` to `fine` (shares of the reach).
std::vector<double> climb(const ShapeFamily& family,
                          std::vector<double> start,
                          double coarse,
                          double fine);

// The best over the whole reach: a grid in the first two parameters, then climbs from its best.
std::vector<double> search(const ShapeFamily& family);

}  // namespace zygoma
