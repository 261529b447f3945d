#include "retarget/curve_probe.h"

#include <algorithm>

namespace zygoma {

template <typename Visit>
void CurveProbe::for_each_support(int vertex, Visit&& visit) const {
  const Embedding& e = anatomy_.skin.embedding;
  const auto v = static_cast<std::size_t>(vertex);
  for (int k = e.begin[v]; k < e.begin[v + 1]; ++k) {
    const auto entry = static_cast<std::size_t>(k);
    visit(e.index[entry], static_cast<double>(e.weight[entry]));
  }
}

CurveProbe::CurveProbe(const Anatomy& anatomy, double viewing_distance_mm)
    : anatomy_(anatomy), distance_mm_(viewing_distance_mm) {
  for (const NamedCurve& curve : anatomy.curves) {
    const int contour = contour_index(curve.name);
    if (contour >= 0 && curve.skin_vertices.size() >= 2) {
      vertices_[static_cast<std::size_t>(contour)] = curve.skin_vertices;
    }
  }
}

CurvePoints CurveProbe::curves(const FaceState& state) const {
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

CurvePoints CurveProbe::velocities(const Eigen::Ref<const Eigen::VectorXd>& column) const {
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

void CurveProbe::project(const CurvePoints& points,
                         const CurvePoints& velocity,
                         NodeStack& nodes_mm,
                         NodeStack& node_velocity) const {
  constexpr int kRounds = 4;
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
    // Nodes of a tracked contour are even along the line through themselves, not along the curve
    // that it follows; a few rounds make these so, too.
    for (int round = 0; round < kRounds; ++round) {
      resample_by_arc_length(flat, flat_velocity, nodes, velocities);
      flat = nodes;
      flat_velocity = velocities;
    }
    for (int k = 0; k < num_nodes(c); ++k) {
      nodes_mm.col(node_begin(c) + k) = nodes[static_cast<std::size_t>(k)];
      node_velocity.col(node_begin(c) + k) = velocities[static_cast<std::size_t>(k)];
    }
  }
}

NodeStack CurveProbe::image(const FaceState& state) const {
  const CurvePoints points = curves(state);
  NodeStack nodes_mm;
  NodeStack ignored;
  project(points, points, nodes_mm, ignored);
  return nodes_mm;
}

Eigen::VectorXd CurveProbe::depth(const FaceState& state) const {
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

Eigen::MatrixXd CurveProbe::sensitivity(Simulator& face,
                                        const std::vector<int>& muscles,
                                        const Controls& controls,
                                        const FaceState& state,
                                        bool& damped) const {
  const Sensitivity sensitivity = face.surface_sensitivity(controls, state);
  damped = sensitivity.damped;
  const Eigen::MatrixXd& surface = sensitivity.mm;
  const CurvePoints points = curves(state);
  std::vector<Eigen::Index> columns(muscles.begin(), muscles.end());
  columns.push_back(surface.cols() - 1);  // the jaw
  Eigen::MatrixXd result(2 * kNumNodes, static_cast<Eigen::Index>(columns.size()));
  NodeStack nodes;
  NodeStack velocity;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    project(points, velocities(surface.col(columns[i])), nodes, velocity);
    result.col(static_cast<Eigen::Index>(i)) = flatten(velocity);
  }
  result.rightCols<1>() *= face.anatomy().jaw.full_rad;
  return result;
}

}  // namespace zygoma
