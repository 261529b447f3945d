#include "retarget/measure_response.h"

#include <algorithm>
#include <cassert>

#include "src/base/check.h"

namespace zygoma {
namespace {

using CurvePoints = std::array<std::vector<Vec3>, kNumContours>;

// Evaluates the anatomy's curves in a state of the face.
class CurveProbe {
 public:
  CurveProbe(const Anatomy& anatomy, double viewing_distance_mm)
      : anatomy_(anatomy), distance_mm_(viewing_distance_mm) {
    for (const NamedCurve& curve : anatomy.curves) {
      const int contour = contour_index(curve.name);
      if (contour >= 0 && curve.skin_vertices.size() >= 2) {
        vertices_[static_cast<std::size_t>(contour)] = curve.skin_vertices;
      }
    }
  }

  bool has(int contour) const { return !vertices_[static_cast<std::size_t>(contour)].empty(); }

  CurvePoints curves(const FaceState& state) const {
    CurvePoints result;
    for (std::size_t c = 0; c < vertices_.size(); ++c) {
      for (const int vertex : vertices_[c]) {
        Vec3 point = anatomy_.skin.mesh.positions_mm[static_cast<std::size_t>(vertex)];
        for_each_support(vertex, [&](int j, double weight) {
          const auto node = static_cast<std::size_t>(j);
          point += weight * (state.positions_mm[node] - anatomy_.surface.positions_mm[node]);
        });
        result[c].push_back(point);
      }
    }
    return result;
  }

  // Velocities of the curves' points for one column of a surface sensitivity.
  CurvePoints velocities(const Eigen::Ref<const Eigen::VectorXd>& column) const {
    CurvePoints result;
    for (std::size_t c = 0; c < vertices_.size(); ++c) {
      for (const int vertex : vertices_[c]) {
        Vec3 velocity = Vec3::Zero();
        for_each_support(
            vertex, [&](int j, double weight) { velocity += weight * column.segment<3>(3 * j); });
        result[c].push_back(velocity);
      }
    }
    return result;
  }

  // The stack of nodes in the image (mm) and its velocity.
  void image(const CurvePoints& points,
             const CurvePoints& velocity,
             NodeStack& nodes_mm,
             NodeStack& node_velocity) const {
    nodes_mm.setZero();
    node_velocity.setZero();
    for (int c = 0; c < kNumContours; ++c) {
      const auto index = static_cast<std::size_t>(c);
      if (!has(c)) continue;
      std::vector<Point2> flat;
      std::vector<Point2> flat_velocity;
      for (std::size_t i = 0; i < points[index].size(); ++i) {
        const Vec3& p = points[index][i];
        const Vec3& v = velocity[index][i];
        const double magnify = distance_mm_ / (distance_mm_ - p.z());
        const double magnify_rate = magnify * magnify / distance_mm_ * v.z();
        flat.emplace_back(magnify * p.x(), -magnify * p.y());
        flat_velocity.emplace_back(magnify * v.x() + magnify_rate * p.x(),
                                   -magnify * v.y() - magnify_rate * p.y());
      }
      std::vector<Point2> nodes(static_cast<std::size_t>(num_nodes(c)));
      std::vector<Point2> velocities;
      resample_by_arc_length(flat, flat_velocity, nodes, velocities);
      for (int k = 0; k < num_nodes(c); ++k) {
        nodes_mm.col(node_begin(c) + k) = nodes[static_cast<std::size_t>(k)];
        node_velocity.col(node_begin(c) + k) = velocities[static_cast<std::size_t>(k)];
      }
    }
  }

  NodeStack image(const FaceState& state) const {
    const CurvePoints points = curves(state);
    NodeStack nodes_mm;
    NodeStack ignored;
    image(points, points, nodes_mm, ignored);
    return nodes_mm;
  }

  // Depth of the nodes, by linear interpolation over the same arc length.
  Eigen::VectorXd depth(const FaceState& state) const {
    const CurvePoints points = curves(state);
    Eigen::VectorXd result = Eigen::VectorXd::Zero(kNumNodes);
    for (int c = 0; c < kNumContours; ++c) {
      const std::vector<Vec3>& curve = points[static_cast<std::size_t>(c)];
      for (int k = 0; has(c) && k < num_nodes(c); ++k) {
        const double at =
            static_cast<double>(k) / (num_nodes(c) - 1) * static_cast<double>(curve.size() - 1);
        const auto i = std::min(static_cast<std::size_t>(at), curve.size() - 2);
        const double t = at - static_cast<double>(i);
        result[node_begin(c) + k] = (1.0 - t) * curve[i].z() + t * curve[i + 1].z();
      }
    }
    return result;
  }

 private:
  template <typename Visit>
  void for_each_support(int vertex, Visit&& visit) const {
    const Embedding& e = anatomy_.skin.embedding;
    const auto v = static_cast<std::size_t>(vertex);
    for (int k = e.begin[v]; k < e.begin[v + 1]; ++k) {
      const auto entry = static_cast<std::size_t>(k);
      visit(e.index[entry], static_cast<double>(e.weight[entry]));
    }
  }

  const Anatomy& anatomy_;
  double distance_mm_;
  std::array<std::vector<int>, kNumContours> vertices_;
};

Eigen::VectorXd flatten(const NodeStack& nodes) {
  return Eigen::Map<const Eigen::VectorXd>(nodes.data(), nodes.size());
}

// d(stack)/d(controls) at an equilibrium, for these muscles of the anatomy and the jaw; the jaw's
// column per unit of jaw, not per radian. Counts up `num_damped` where the derivatives are only
// damped ones.
Eigen::MatrixXd image_sensitivity(Simulator& face,
                                  const CurveProbe& probe,
                                  const std::vector<int>& muscles,
                                  const Controls& controls,
                                  const FaceState& state,
                                  int& num_damped) {
  const Sensitivity sensitivity = face.surface_sensitivity(controls, state);
  if (sensitivity.damped) ++num_damped;
  const Eigen::MatrixXd& surface = sensitivity.mm;
  const CurvePoints points = probe.curves(state);
  std::vector<Eigen::Index> columns(muscles.begin(), muscles.end());
  columns.push_back(surface.cols() - 1);  // the jaw
  Eigen::MatrixXd result(2 * kNumNodes, static_cast<Eigen::Index>(columns.size()));
  NodeStack nodes;
  NodeStack velocity;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    probe.image(points, probe.velocities(surface.col(columns[i])), nodes, velocity);
    result.col(static_cast<Eigen::Index>(i)) = flatten(velocity);
  }
  result.rightCols<1>() *= face.anatomy().jaw.full_rad;
  return result;
}

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
    bool any = false;
    for (int c = 0; c < kNumContours; ++c) {
      response_.has_contour[static_cast<std::size_t>(c)] = probe_.has(c);
      any = any || probe_.has(c);
    }
    require(any, "the face model names none of the nine contours among its curves");
    response_.rest_mm = probe_.image(rest_);
    response_.rest_depth_mm = probe_.depth(rest_);
  }

  FaceResponse run(const ResponseOptions& options) {
    response_.linear_mm = sensitivity(slack(), rest_);
    measure_saturation(options.overlap);
    measure_jaw();
    return std::move(response_);
  }

 private:
  Controls slack() const { return {std::vector<double>(face_.anatomy().muscles.size(), 0.0), 0.0}; }

  Eigen::MatrixXd sensitivity(const Controls& controls, const FaceState& state) {
    return image_sensitivity(
        face_, probe_, muscle_, controls, state, response_.settles_not_converged);
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

  // d = l u + q u^2 through a settled strong contraction; not the full one, which folds tissue.
  void measure_saturation(double overlap) {
    constexpr double kStrong = 0.6;
    const int num_muscles = response_.num_muscles();
    const Eigen::MatrixXd motion = motion_per_node(response_.linear_mm, num_muscles);
    for (const std::vector<int>& group : group_muscles(motion, overlap)) {
      Controls controls = slack();
      for (const int i : group) {
        const int muscle = muscle_[static_cast<std::size_t>(i)];
        controls.contraction[static_cast<std::size_t>(muscle)] = kStrong;
      }
      FaceState state = rest_;
      if (!settle(controls, state)) continue;
      const Eigen::VectorXd excess = beyond_linear(state, controls) / (kStrong * kStrong);
      for (int k = 0; k < kNumNodes; ++k) {
        double total = 0.0;
        for (const int i : group) total += motion(k, i);
        for (const int i : group) {
          if (total <= 0.0) break;
          response_.quadratic_mm.col(i).segment<2>(2 * k) =
              motion(k, i) / total * excess.segment<2>(2 * k);
        }
      }
    }
  }

  // g(j) = l j + q j^2 + r j^3 through the settled half and full opening.
  void measure_jaw() {
    Controls controls = slack();
    FaceState state = rest_;
    controls.jaw_rad = 0.5 * face_.anatomy().jaw.full_rad;
    if (!settle(controls, state)) return;
    const Eigen::VectorXd half = beyond_linear(state, controls);
    controls.jaw_rad = face_.anatomy().jaw.full_rad;
    if (!settle(controls, state)) return;
    const Eigen::VectorXd full = beyond_linear(state, controls);
    response_.quadratic_mm.rightCols<1>() = 8.0 * half - full;
    response_.jaw_cubic_mm = 2.0 * full - 8.0 * half;
    const Eigen::MatrixXd open = sensitivity(controls, state);
    const Eigen::Index n = response_.num_muscles();
    if (open.allFinite()) {
      response_.jaw_cross_mm = open.leftCols(n) - response_.linear_mm.leftCols(n);
    }
  }

  Simulator& face_;
  const StopQuestion& stop_;
  CurveProbe probe_;
  FaceState rest_;
  std::vector<int> muscle_;  // of the anatomy, per muscle of the response
  FaceResponse response_;
};

}  // namespace

void ResponseOptions::check() const {
  require(viewing_distance_mm >= 200.0 && viewing_distance_mm <= 1e6,
          "viewing_distance_mm is " + std::to_string(viewing_distance_mm) +
              "; expected a value in [200, 1e6]");
  require(overlap >= 0.0 && overlap <= 1.0,
          "overlap is " + std::to_string(overlap) + "; expected a value in [0, 1]");
}

FaceResponse measure_response(Simulator& face,
                              const ResponseOptions& options,
                              const StopQuestion& stop) {
  options.check();
  return Measurement(face, options, stop).run(options);
}

}  // namespace zygoma
