#include "retarget/lattice_loop.h"

#include <algorithm>
#include <string>

#include "src/base/check.h"

namespace zygoma {

void LatticeLoopOptions::check() const {
  require_range("max_rounds", max_rounds, 1, 100);
  require_range("tolerance", tolerance, 1e-9, 1.0);
  require_range("refresh_distance", refresh_distance, 0.0, 1.0);
}

LatticeLoop::LatticeLoop(Simulator& face,
                         const FaceResponse& response,
                         const Eigen::VectorXd& gain,
                         const LatticeLoopOptions& options)
    : face_(face),
      response_(response),
      gain_(gain),
      options_(options),
      probe_(face.anatomy(), response.viewing_distance_mm),
      state_(face.rest()) {
  options.check();
  for (const std::string& name : response.muscles) {
    muscle_.push_back(face.anatomy().muscle_index(name));
    require(muscle_.back() >= 0, "the face has no muscle " + name);
  }
  rest_mm_ = flatten(probe_.image(state_));
}

bool LatticeLoop::has_moved(const ModelCorrection& correction,
                            const Eigen::VectorXd& controls) const {
  return correction.at.size() == 0 ||
         (controls - correction.at).lpNorm<Eigen::Infinity>() > options_.tolerance;
}

bool LatticeLoop::correct(const Eigen::VectorXd& controls, ModelCorrection& correction) {
  const int n = response_.num_muscles();
  // A performer who is stronger than the model ends where the model does.
  const Eigen::VectorXd asked = gain_.cwiseProduct(controls).cwiseMax(0.0).cwiseMin(1.0);
  Controls told;
  told.contraction.assign(face_.anatomy().muscles.size(), 0.0);
  for (int i = 0; i < n; ++i) {
    told.contraction[static_cast<std::size_t>(muscle_[static_cast<std::size_t>(i)])] = asked[i];
  }
  told.jaw_rad = asked[n] * face_.anatomy().jaw.full_rad;

  ++figures_.settles;
  const bool settled = face_.settle(told, state_).converged;
  if (!settled) ++figures_.settles_not_converged;
  if (!std::all_of(state_.positions_mm.begin(), state_.positions_mm.end(), [](const Vec3& p) {
        return p.allFinite();
      })) {
    state_ = face_.rest();
    return false;
  }
  Eigen::VectorXd baked;
  Eigen::MatrixXd baked_slope;
  const bool far = slope_at_.size() == 0 ||
                   (controls - slope_at_).lpNorm<Eigen::Infinity>() > options_.refresh_distance;
  response_.displace(controls, baked, far ? &baked_slope : nullptr);
  if (far) {
    ++figures_.sensitivities;
    bool damped = false;
    Eigen::MatrixXd slope = probe_.sensitivity(face_, muscle_, told, state_, damped);
    // At a fork of equilibria the response is the better guide.
    if (!damped && slope.allFinite()) {
      extra_slope_ = slope * gain_.asDiagonal() - baked_slope;
      slope_at_ = controls;
    }
  }
  correction.at = controls;
  correction.offset_mm = flatten(probe_.image(state_)) - rest_mm_ - baked;
  correction.slope_mm = extra_slope_;
  return true;
}

}  // namespace zygoma
