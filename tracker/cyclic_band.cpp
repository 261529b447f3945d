#include "tracker/cyclic_band.h"

#include <Eigen/LU>
#include <cassert>

namespace zygoma {

void CyclicBand::factor(std::vector<double> h0, std::vector<double> h1, std::vector<double> h2) {
  const size_t n = h0.size();
  const bool runs_round = h1[n - 1] != 0.0 || h2[n - 2] != 0.0 || h2[n - 1] != 0.0;
  assert(n >= (runs_round ? 5 : 3));
  band_ = runs_round ? n - 2 : n;
  diagonal_.assign(band_, 0.0);
  lower1_.assign(band_, 0.0);
  lower2_.assign(band_, 0.0);
  for (size_t i = 0; i < band_; ++i) {
    double d = h0[i];
    double first = h1[i];
    if (i >= 1) {
      d -= lower1_[i - 1] * lower1_[i - 1] * diagonal_[i - 1];
      first -= lower1_[i - 1] * lower2_[i - 1] * diagonal_[i - 1];
    }
    if (i >= 2) d -= lower2_[i - 2] * lower2_[i - 2] * diagonal_[i - 2];
    diagonal_[i] = d;
    lower1_[i] = first / d;
    lower2_[i] = h2[i] / d;
  }
  coupling_.clear();
  border_.clear();
  if (!runs_round) return;
  coupling_.assign(band_, Point2::Zero());
  coupling_[band_ - 2].x() += h2[n - 4];  // with row n-2
  coupling_[band_ - 1] += Point2(h1[n - 3], h2[n - 3]);
  coupling_[0] += Point2(h2[n - 2], h1[n - 1]);
  coupling_[1].y() += h2[n - 1];
  border_ = coupling_;
  solve_band(border_);
  Eigen::Matrix2d schur;
  schur << h0[n - 2], h1[n - 2], h1[n - 2], h0[n - 1];
  for (size_t i = 0; i < band_; ++i) schur -= coupling_[i] * border_[i].transpose();
  corner_ = schur.inverse();
}

void CyclicBand::solve_band(std::vector<Point2>& x) const {
  for (size_t i = 0; i < band_; ++i) {
    if (i >= 1) x[i] -= lower1_[i - 1] * x[i - 1];
    if (i >= 2) x[i] -= lower2_[i - 2] * x[i - 2];
  }
  for (size_t i = 0; i < band_; ++i) x[i] /= diagonal_[i];
  for (size_t i = band_; i-- > 0;) {
    if (i + 1 < band_) x[i] -= lower1_[i] * x[i + 1];
    if (i + 2 < band_) x[i] -= lower2_[i] * x[i + 2];
  }
}

void CyclicBand::solve(std::vector<Point2>& x) const {
  assert(x.size() == band_ + (border_.empty() ? 0 : 2));
  solve_band(x);
  if (border_.empty()) return;
  // Rows of unknowns, columns of coordinates.
  Eigen::Matrix2d last;
  last.row(0) = x[band_];
  last.row(1) = x[band_ + 1];
  for (size_t i = 0; i < band_; ++i) last -= coupling_[i] * x[i].transpose();
  last = (corner_ * last).eval();
  for (size_t i = 0; i < band_; ++i) x[i] -= last.transpose() * border_[i];
  x[band_] = last.row(0);
  x[band_ + 1] = last.row(1);
}

}  // namespace zygoma
