#include "face/energy.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "face/prism.h"

namespace zygoma {
namespace {

Eigen::Matrix3d cross_matrix(const Vec3& k) {
  Eigen::Matrix3d m;
  m << 0.0, -k.z(), k.y(), k.z(), 0.0, -k.x(), -k.y(), k.x(), 0.0;
  return m;
}

PrismCorners corners(const Prism& prism, const std::vector<Vec3>& x) {
  return {x[prism.node[0]],
          x[prism.node[1]],
          x[prism.node[2]],
          x[prism.node[3]],
          x[prism.node[4]],
          x[prism.node[5]]};
}

void add_piece(ColumnMatrix& h, int offset, const Eigen::Matrix3d& piece) {
  if (offset < 0) return;
  double* values = &h.values[offset];
  const int rows = h.rows(0);  // the same in every column
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) values[c * rows + r] += piece(r, c);
  }
}

}  // namespace

FaceEnergy::FaceEnergy(const Anatomy& anatomy, Lattice lattice, const EnergyOptions& options)
    : anatomy_(anatomy), lattice_(std::move(lattice)), options_(options) {
  muscles_ = make_muscle_field(anatomy_, lattice_);
  find_flaps();
  find_holds();
  find_slots();
  smooth_mandible_weight();
  set_controls(std::vector<double>(anatomy_.muscles.size(), 0.0), 0.0);
}

void FaceEnergy::find_holds() {
  for (int v = 0; v < lattice_.num_columns; ++v) {
    holds_begin_.push_back(static_cast<int>(holds_.size()));
    const double share = muscles_.hold[v] + options_.slip_hold_ratio * flap_[v];
    if (share <= 0.0) continue;
    const double stiffness = options_.muscle_hold_kpa_per_mm * lattice_.area_mm2[v] * share;
    for (int node = lattice_.fascia_node(v); node >= 0; node -= lattice_.num_columns) {
      holds_.push_back({node, stiffness, Vec3::Zero()});
      if (!lattice_.is_thin(v)) break;
    }
  }
  holds_begin_.push_back(static_cast<int>(holds_.size()));
}

void FaceEnergy::set_controls(const std::vector<double>& contraction, double jaw_rad) {
  assert(contraction.size() == anatomy_.muscles.size());
  jaw_rad_ = jaw_rad;
  jaw_motion_ = open_from_closed(anatomy_.jaw, jaw_rad);
  pull_mm_.assign(lattice_.num_columns, Vec3::Zero());
  for (std::size_t m = 0; m < contraction.size(); ++m) {
    if (contraction[m] == 0.0) continue;
    for (const MusclePull& pull : muscles_.pulls[m]) {
      pull_mm_[pull.column] += contraction[m] * pull.displacement_mm;
    }
  }
  for (Hold& hold : holds_) {
    hold.target_mm = carried(hold.node) + pull_mm_[hold.node % lattice_.num_columns];
  }
}

// 1 on lips and lids, fading with the distance along the skin.
void FaceEnergy::find_flaps() {
  std::vector<char> on_flap(lattice_.num_columns, 0);
  for (int v = 0; v < lattice_.num_columns; ++v) on_flap[v] = anatomy_.region[v] != Region::kFace;
  flap_.assign(lattice_.num_columns, 0.0);
  if (std::find(on_flap.begin(), on_flap.end(), 1) == on_flap.end()) return;
  const std::vector<double> distance =
      distance_along(anatomy_.surface, on_flap, options_.slip_reach_mm);
  for (int v = 0; v < lattice_.num_columns; ++v) {
    const double t = std::max(0.0, 1.0 - distance[v] / options_.slip_reach_mm);
    flap_[v] = t * t * (3.0 - 2.0 * t);
  }
}

// Soft tissue between the two bones shares their motion gently; the slit of the mouth separates.
void FaceEnergy::smooth_mandible_weight() {
  constexpr int kRounds = 6;
  mandible_weight_ = anatomy_.mandible_weight;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> mean(mandible_weight_.size());
    for (int v = 0; v < lattice_.num_columns; ++v) {
      double sum = 0.0;
      for (const int u : lattice_.neighbors[v]) sum += mandible_weight_[u];
      mean[v] =
          0.5 * (mandible_weight_[v] + sum / static_cast<double>(lattice_.neighbors[v].size()));
    }
    mandible_weight_ = std::move(mean);
  }
}

Vec3 FaceEnergy::carried(int node) const {
  const Vec3& rest = lattice_.rest_mm[node];
  const double weight = mandible_weight_[node % lattice_.num_columns];
  if (jaw_rad_ == 0.0 || weight == 0.0) return rest;
  return rest + weight * (jaw_motion_ * rest - rest);
}

void FaceEnergy::place_bone(std::vector<Vec3>& x) const {
  for (int v = 0; v < lattice_.num_columns; ++v) {
    Vec3& bone = x[lattice_.bone_node(v)];
    bone = carried(lattice_.bone_node(v));
    bone += floor_slip(v) * pull_mm_[v];
  }
}

FaceEnergy::Jet FaceEnergy::prism_jet(const Prism& prism, double volume) const {
  const double j = volume / prism.rest_mm3;
  const double k = prism.bulk_kpa;
  Jet jet{0.5 * k * prism.rest_mm3 * (j - 1.0) * (j - 1.0), k * (j - 1.0), k / prism.rest_mm3};
  const double short_of = options_.barrier_start - j;
  if (short_of > 0.0) {
    const double b = options_.barrier_ratio * k;
    jet.energy += b * prism.rest_mm3 * short_of * short_of * short_of;
    jet.first -= 3.0 * b * short_of * short_of;
    jet.second += 6.0 * b * short_of / prism.rest_mm3;
  }
  return jet;
}

double FaceEnergy::evaluate(const std::vector<Vec3>& x, Eigen::VectorXd& gradient) const {
  // Bone rows are accumulated too and cut off: cheaper than asking at every element.
  gradient.setZero(3 * static_cast<Eigen::Index>(lattice_.rest_mm.size()));
  const auto at = [&](int node) { return gradient.segment<3>(3 * node); };
  double energy = 0.0;
  for (const Spring& spring : lattice_.springs) {
    Vec3 g;
    energy += spring_energy(spring, x[spring.j] - x[spring.i], g);
    at(spring.i) -= g;
    at(spring.j) += g;
  }
  for (const Prism& prism : lattice_.prisms) {
    PrismCorners g;
    const Jet jet = prism_jet(prism, prism_volume(corners(prism, x), g));
    energy += jet.energy;
    for (int c = 0; c < 6; ++c) at(prism.node[c]) += jet.first * g[c];
  }
  for (const Hold& hold : holds_) {
    const Vec3 off = x[hold.node] - hold.target_mm;
    energy += 0.5 * hold.stiffness * off.squaredNorm();
    at(hold.node) += hold.stiffness * off;
  }
  gradient.conservativeResize(num_unknowns());
  return energy;
}

int FaceEnergy::slot(int a, int b, bool& first_is_row) const {
  const int free = lattice_.num_free_nodes();
  if (a >= free || b >= free) return -1;
  const int n = lattice_.num_columns;
  const int rows = 3 * (lattice_.num_node_layers - 1);
  int column_a = a % n;
  int column_b = b % n;
  int layer_a = a / n;
  int layer_b = b / n;
  // Lower blocks only: the row is the later column, or the lower layer of one column.
  first_is_row = std::pair(column_a, layer_a) >= std::pair(column_b, layer_b);
  if (!first_is_row) {
    std::swap(column_a, column_b);
    std::swap(layer_a, layer_b);
  }
  std::size_t block = column_a;
  if (column_a != column_b) {
    const std::array<int, 2> edge{column_b, column_a};
    const auto at = std::lower_bound(lattice_.edges.begin(), lattice_.edges.end(), edge);
    assert(at != lattice_.edges.end() && *at == edge);
    block = n + (at - lattice_.edges.begin());
  }
  return static_cast<int>(block * rows * rows) + 3 * layer_b * rows + 3 * layer_a;
}

void FaceEnergy::find_slots() {
  bool first_is_row = false;
  for (const Spring& spring : lattice_.springs) {
    spring_slots_.push_back({slot(spring.i, spring.i, first_is_row),
                             slot(spring.j, spring.j, first_is_row),
                             slot(spring.i, spring.j, first_is_row)});
  }
  for (const Prism& prism : lattice_.prisms) {
    PrismSlots slots;
    int pair = 0;
    for (int p = 0; p < 6; ++p) {
      slots.diagonal[p] = slot(prism.node[p], prism.node[p], first_is_row);
      for (int q = p + 1; q < 6; ++q, ++pair) {
        slots.pair[pair] = slot(prism.node[p], prism.node[q], first_is_row);
        slots.second_is_row[pair] = !first_is_row;
      }
    }
    prism_slots_.push_back(slots);
  }
}

ColumnMatrix FaceEnergy::make_pattern() const {
  std::vector<std::vector<int>> nodes(lattice_.num_columns);
  for (int node = 0; node < lattice_.num_free_nodes(); ++node) {
    nodes[node % lattice_.num_columns].push_back(node);
  }
  ColumnMatrix h;
  h.reset(std::move(nodes), lattice_.edges);
  return h;
}

void FaceEnergy::hessian(const std::vector<Vec3>& x, ColumnMatrix& h) const {
  h.set_zero();
  for (std::size_t k = 0; k < lattice_.springs.size(); ++k) {
    const Spring& spring = lattice_.springs[k];
    const SpringSlots& slots = spring_slots_[k];
    const Eigen::Matrix3d piece = spring_hessian(spring, x[spring.j] - x[spring.i]);
    add_piece(h, slots.ii, piece);
    add_piece(h, slots.jj, piece);
    add_piece(h, slots.ij, -piece);
  }
  for (std::size_t e = 0; e < lattice_.prisms.size(); ++e) {
    const Prism& prism = lattice_.prisms[e];
    const PrismSlots& slots = prism_slots_[e];
    const PrismCorners corner = corners(prism, x);
    PrismCorners g;
    PrismCurvature k;
    const Jet jet = prism_jet(prism, prism_volume(corner, g));
    prism_curvature(corner, k);
    int pair = 0;
    for (int p = 0; p < 6; ++p) {
      const Vec3 scaled = jet.second * g[p];
      add_piece(h, slots.diagonal[p], scaled * g[p].transpose());
      for (int q = p + 1; q < 6; ++q, ++pair) {
        if (slots.pair[pair] < 0) continue;
        const Eigen::Matrix3d piece = scaled * g[q].transpose() + cross_matrix(jet.first * k[p][q]);
        if (slots.second_is_row[pair]) {
          add_piece(h, slots.pair[pair], piece.transpose());
        } else {
          add_piece(h, slots.pair[pair], piece);
        }
      }
    }
  }
  for (const Hold& hold : holds_) {
    bool unused = false;
    add_piece(h, slot(hold.node, hold.node, unused), hold.stiffness * Eigen::Matrix3d::Identity());
  }
}

Eigen::VectorXd FaceEnergy::hessian_times(const std::vector<Vec3>& x,
                                          const std::vector<Vec3>& motion) const {
  Eigen::VectorXd product =
      Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(lattice_.rest_mm.size()));
  const auto at = [&](int node) { return product.segment<3>(3 * node); };
  for (const Spring& spring : lattice_.springs) {
    const Vec3 difference = motion[spring.j] - motion[spring.i];
    if (difference.isZero(0.0)) continue;
    const Vec3 g = spring_hessian(spring, x[spring.j] - x[spring.i]) * difference;
    at(spring.i) -= g;
    at(spring.j) += g;
  }
  for (const Prism& prism : lattice_.prisms) {
    const PrismCorners moved = corners(prism, motion);
    if (std::all_of(moved.begin(), moved.end(), [](const Vec3& m) { return m.isZero(0.0); })) {
      continue;
    }
    const PrismCorners corner = corners(prism, x);
    PrismCorners g;
    PrismCurvature k;
    const Jet jet = prism_jet(prism, prism_volume(corner, g));
    prism_curvature(corner, k);
    double rate = 0.0;
    for (int p = 0; p < 6; ++p) rate += g[p].dot(moved[p]);
    for (int p = 0; p < 6; ++p) {
      at(prism.node[p]) += (jet.second * rate) * g[p];
      for (int q = p + 1; q < 6; ++q) {
        at(prism.node[p]) += jet.first * k[p][q].cross(moved[q]);
        at(prism.node[q]) -= jet.first * k[p][q].cross(moved[p]);
      }
    }
  }
  for (const Hold& hold : holds_) at(hold.node) += hold.stiffness * motion[hold.node];
  product.conservativeResize(num_unknowns());
  return product;
}

Eigen::MatrixXd FaceEnergy::control_forces(const std::vector<Vec3>& x) const {
  const std::size_t num_muscles = muscles_.pulls.size();
  Eigen::MatrixXd forces = Eigen::MatrixXd::Zero(num_unknowns(), num_muscles + 1);
  std::vector<Vec3> bone_motion(lattice_.rest_mm.size(), Vec3::Zero());
  for (std::size_t m = 0; m < num_muscles; ++m) {
    for (const MusclePull& pull : muscles_.pulls[m]) {
      bone_motion[lattice_.bone_node(pull.column)] = floor_slip(pull.column) * pull.displacement_mm;
    }
    forces.col(m) = -hessian_times(x, bone_motion);
    for (const MusclePull& pull : muscles_.pulls[m]) {
      for (int k = holds_begin_[pull.column]; k < holds_begin_[pull.column + 1]; ++k) {
        forces.block<3, 1>(3 * holds_[k].node, m) += holds_[k].stiffness * pull.displacement_mm;
      }
      bone_motion[lattice_.bone_node(pull.column)].setZero();
    }
  }
  const auto rate = [&](int node) -> Vec3 {
    return mandible_weight_[node % lattice_.num_columns] *
           opening_rate(anatomy_.jaw, jaw_rad_, lattice_.rest_mm[node]);
  };
  for (int v = 0; v < lattice_.num_columns; ++v) {
    bone_motion[lattice_.bone_node(v)] = rate(lattice_.bone_node(v));
  }
  forces.col(num_muscles) = -hessian_times(x, bone_motion);
  for (const Hold& hold : holds_) {
    forces.block<3, 1>(3 * hold.node, num_muscles) += hold.stiffness * rate(hold.node);
  }
  return forces;
}

double FaceEnergy::largest_muscle_force() const {
  double largest = 0.0;
  for (const Hold& hold : holds_) {
    largest = std::max(largest, hold.stiffness * pull_mm_[hold.node % lattice_.num_columns].norm());
  }
  return largest;
}

FaceEnergy::VolumeReport FaceEnergy::volumes(const std::vector<Vec3>& x) const {
  VolumeReport report;
  PrismCorners unused;
  for (const Prism& prism : lattice_.prisms) {
    const double j = prism_volume(corners(prism, x), unused) / prism.rest_mm3;
    if (j < 0.0) ++report.inverted;
    report.mean_change += std::abs(j - 1.0);
  }
  report.mean_change /= static_cast<double>(lattice_.prisms.size());
  return report;
}

}  // namespace zygoma
