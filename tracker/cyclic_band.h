// Solves A x = r for a symmetric, positive definite A with two diagonals beside the main one, which
// may run round: rows of a closed chain couple its last nodes to its first.
//
// An open chain is a plain band: L D L^T in O(n). If anything couples round, the last two unknowns
// are taken out as a border C of two columns,
//   A = [B C; C' D],   S = D - C' B^-1 C,   x2 = S^-1 (r2 - C' B^-1 r1),   x1 = B^-1 r1 - B^-1 C
//   x2,
// where B is a plain band again and B^-1 C is kept from the factorisation.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tracker/contour_set.h"

namespace zygoma {

class CyclicBand {
 public:
  // A[i, i] = h0[i], A[i, i+1] = h1[i], A[i, i+2] = h2[i], indices taken round. At least five rows
  // if anything couples round, else three.
  void factor(std::vector<double> h0, std::vector<double> h1, std::vector<double> h2);
  // Both coordinates at once, in place.
  void solve(std::vector<Point2>& x) const;

 private:
  void solve_band(std::vector<Point2>& x) const;

  size_t band_ = 0;                                 // rows of B
  std::vector<double> diagonal_, lower1_, lower2_;  // L D L^T of B
  std::vector<Point2> border_;                      // B^-1 C, a row per row of B
  std::vector<Point2> coupling_;                    // C
  Eigen::Matrix2d corner_;                          // S^-1
};

}  // namespace zygoma
