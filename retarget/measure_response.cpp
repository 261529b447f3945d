#include "retarget/measure_response.h"

#include <algorithm>
#include <cassert>

#include "retarget/curve_probe.h"
#include "src/base/check.h"

namespace zygoma {
namespace {

// Squared motion per node and muscle; its column sums tell how far two muscles share nodes.
Eigen::MatrixXd motion_per_node(const Eigen::MatrixXd& linear_mm, int num_muscles) {
  Eigen::MatrixXd motion(kNumNodes, num_muscles);
  for (int i = 0; i < num_muscles; ++i) {
    for (int k = 0; k < kNumNodes; ++k) {
      motion(k, i) = linear_mm.col(i).segment<2>(2 * k).squaredNorm();
    }
  }
  return motion;
}

// Muscles that hardly share nodes go into one group (first fit, in the order of the muscles).
std::vector<std::vector<int>> group_muscles(const Eigen::MatrixXd& motion, double overlap) {
  std::vector<std::vector<int>> groups;
  for (int i = 0; i < motion.cols(); ++i) {
    const auto shares = [&](int j) {
      const double common = motion.col(i).cwiseMin(motion.col(j)).sum();
      return common > overlap * std::min(motion.col(i).sum(), motion.col(j).sum());
    };
    const auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& members) {
      return std::none_of(members.begin(), members.end(), shares);
    });
    if (group != groups.end()) {
      group->push_back(i);
    } else {
      groups.push_back({i});
    }
  }
  return groups;
}

class Measurement {
 public:
  Measurement(Simulator& face, const ResponseOptions& options, const StopQuestion& stop)
      : face_(face),
        stop_(stop),
        probe_(face.anatomy(), options.viewing_distance_mm),
        rest_(face.rest()) {
    std::vector<std::string> names;
    for (const std::string& name : observable_muscles()) {
      const int muscle = face.anatomy().muscle_index(name);
      if (muscle < 0) continue;
      names.push_back(name);
      muscle_.push_back(muscle);
    }
    response_ = FaceResponse::zero(names);
    response_.viewing_distance_mm = options.viewing_distance_mm;
    const Eigen::Index n = response_.num_controls();
    corrective_sum_ = Eigen::MatrixXd::Zero(2 * kNumNodes, n * n);
    bool any = false;
    for (int c = 0; c < kNumContours; ++c) {
      response_.has_contour[static_cast<std::size_t>(c)] = probe_.has(c);
      any = any || probe_.has(c);
    }
    require(any, "the face model names none of the contours among its curves");
    response_.rest_mm = probe_.image(rest_);
    response_.rest_depth_mm = probe_.depth(rest_);
  }

  FaceResponse run(const ResponseOptions& options) {
    response_.linear_mm = sensitivity(slack(), rest_);
    measure_saturation(options.overlap);
    measure_jaw();
    store_pairs();
    return std::move(response_);
  }

 private:
  Controls slack() const { return {std::vector<double>(face_.anatomy().muscles.size(), 0.0), 0.0}; }

  Eigen::MatrixXd sensitivity(const Controls& controls, const FaceState& state) {
    bool damped = false;
    Eigen::MatrixXd result = probe_.sensitivity(face_, muscle_, controls, state, damped);
    if (damped) ++response_.settles_not_converged;
    return result;
  }

  // Displacement of the stack, minus what the linear part already says.
  Eigen::VectorXd beyond_linear(const FaceState& state, const Controls& controls) const {
    Eigen::VectorXd rest = flatten(probe_.image(state) - response_.rest_mm);
    for (std::size_t i = 0; i < muscle_.size(); ++i) {
      const double contraction = controls.contraction[static_cast<std::size_t>(muscle_[i])];
      rest -= contraction * response_.linear_mm.col(static_cast<Eigen::Index>(i));
    }
    rest -= controls.jaw_rad / face_.anatomy().jaw.full_rad * response_.linear_mm.rightCols<1>();
    return rest;
  }

  bool settle(const Controls& controls, FaceState& state) {
    if (stop_ && stop_()) return false;
    if (!face_.settle(controls, state).converged) ++response_.settles_not_converged;
    return std::all_of(state.positions_mm.begin(), state.positions_mm.end(), [](const Vec3& p) {
      return p.allFinite();
    });
  }

  struct Excess {
    Eigen::VectorXd half;
    Eigen::VectorXd full;
    Eigen::MatrixXd slope;  // under half strength
  };

  // Beyond the linear part at half and at full strength of these controls; false when the face does
  // not get there.
  bool measure_excess(const Controls& full, Excess& excess) {
    Controls half = full;
    for (double& c : half.contraction) c *= 0.5;
    half.jaw_rad *= 0.5;
    FaceState state = rest_;
    if (!settle(half, state)) return false;
    excess.half = beyond_linear(state, half);
    excess.slope = sensitivity(half, state);
    if (!excess.slope.allFinite() || !settle(full, state)) return false;
    excess.full = beyond_linear(state, full);
    return true;
  }

  // d = l u + q u^2 + r u^3 through both.
  static Eigen::VectorXd quadratic(const Excess& e) { return 8.0 * e.half - e.full; }
  static Eigen::VectorXd cubic(const Excess& e) { return 2.0 * e.full - 8.0 * e.half; }

  void measure_saturation(double overlap) {
    const int num_muscles = response_.num_muscles();
    const Eigen::MatrixXd motion = motion_per_node(response_.linear_mm, num_muscles);
    for (const std::vector<int>& group : group_muscles(motion, overlap)) {
      Controls controls = slack();
      for (const int i : group) {
        const int muscle = muscle_[static_cast<std::size_t>(i)];
        controls.contraction[static_cast<std::size_t>(muscle)] = 1.0;
      }
      Excess excess;
      if (!measure_excess(controls, excess)) continue;
      share_out(group, motion, excess);
    }
  }

  // To the muscles of a group by how much they move a node.
  void share_out(const std::vector<int>& group,
                 const Eigen::MatrixXd& motion,
                 const Excess& excess) {
    const Eigen::VectorXd q = quadratic(excess);
    const Eigen::VectorXd r = cubic(excess);
    const Eigen::MatrixXd change = 2.0 * (excess.slope - response_.linear_mm);
    for (int k = 0; k < kNumNodes; ++k) {
      double total = 0.0;
      for (const int i : group) total += motion(k, i);
      for (const int i : group) {
        if (total <= 0.0) break;
        const double share = motion(k, i) / total;
        response_.quadratic_mm.col(i).segment<2>(2 * k) = share * q.segment<2>(2 * k);
        response_.cubic_mm.col(i).segment<2>(2 * k) = share * r.segment<2>(2 * k);
        for (int other = 0; other < response_.num_controls(); ++other) {
          if (std::find(group.begin(), group.end(), other) != group.end()) continue;
          corrective(i, other).segment<2>(2 * k) += share * change.col(other).segment<2>(2 * k);
        }
      }
    }
  }

  void measure_jaw() {
    Controls controls = slack();
    controls.jaw_rad = face_.anatomy().jaw.full_rad;
    Excess excess;
    if (!measure_excess(controls, excess)) return;
    response_.quadratic_mm.rightCols<1>() = quadratic(excess);
    response_.cubic_mm.rightCols<1>() = cubic(excess);
    const Eigen::MatrixXd change = 2.0 * (excess.slope - response_.linear_mm);
    for (int i = 0; i < response_.num_muscles(); ++i) {
      corrective(i, response_.num_muscles()) += change.col(i);
    }
  }

  // Two estimates of each, from either side of the pair, add up here.
  Eigen::Ref<Eigen::VectorXd> corrective(int a, int b) {
    const int n = response_.num_controls();
    return corrective_sum_.col(std::min(a, b) * n + std::max(a, b));
  }

  void store_pairs() {
    constexpr double kLeast_mm = 0.3;  // at full strength of both; less is not worth its time
    const int n = response_.num_controls();
    std::vector<Eigen::VectorXd> columns;
    for (int a = 0; a < n; ++a) {
      for (int b = a + 1; b < n; ++b) {
        const Eigen::VectorXd x = 0.5 * corrective(a, b);
        if (x.lpNorm<Eigen::Infinity>() < kLeast_mm) continue;
        response_.pairs.emplace_back(a, b);
        columns.push_back(x);
      }
    }
    response_.pair_mm.resize(2 * kNumNodes, static_cast<Eigen::Index>(columns.size()));
    for (std::size_t p = 0; p < columns.size(); ++p) {
      response_.pair_mm.col(static_cast<Eigen::Index>(p)) = columns[p];
    }
  }

  Simulator& face_;
  const StopQuestion& stop_;
  CurveProbe probe_;
  FaceState rest_;
  std::vector<int> muscle_;  // of the anatomy, per muscle of the response
  FaceResponse response_;
  Eigen::MatrixXd corrective_sum_;  // column a * num_controls + b, a < b
};

}  // namespace

void ResponseOptions::check() const {
  require_range("viewing_distance_mm", viewing_distance_mm, 200.0, 1e6);
  require_range("overlap", overlap, 0.0, 1.0);
}

FaceResponse measure_response(Simulator& face,
                              const ResponseOptions& options,
                              const StopQuestion& stop) {
  options.check();
  return Measurement(face, options, stop).run(options);
}

}  // namespace zygoma
