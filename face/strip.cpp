#include "face/strip.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "face/lattice_build.h"
#include "src/base/check.h"

namespace zygoma {
namespace {

constexpr double kInstant_s = 1e-7;       // a jump in time
constexpr double kResidual = 1e-9;        // share of the load
constexpr double kSmallestLoadMn = 1e-2;  // counts as this, so that rest is reached too
constexpr int kMostIterations = 300;
constexpr double kProbeStrain = 1e-5;     // for the modulus: small against every band of the law
constexpr double kLoadTolerance = 1e-10;  // of the stress asked for
constexpr int kMostTrials = 40;           // of the strain that bears a load

// Numbers the nodes of the grid: free ones first and layer by layer, as the lattice wants them.
struct Grid {
  int along, across, layers;  // cells

  int per_layer() const { return (along - 1) * (across + 1); }
  int num_free() const { return (layers + 1) * per_layer(); }
  int num_nodes() const { return (layers + 1) * (along + 1) * (across + 1); }
  bool is_clamped(int i) const { return i == 0 || i == along; }
  int node(int i, int j, int layer) const {
    if (!is_clamped(i)) return layer * per_layer() + (i - 1) * (across + 1) + j;
    const int end = i == 0 ? 0 : 1;
    return num_free() + (end * (layers + 1) + layer) * (across + 1) + j;
  }
  // Two per cell; the diagonals alternate, so that the strip has no handedness.
  template <typename Use>
  void for_each_triangle(const Use& use) const {
    for (int i = 0; i < along; ++i) {
      for (int j = 0; j < across; ++j) {
        using Corner = std::array<int, 2>;
        const Corner a{i, j}, b{i + 1, j}, c{i + 1, j + 1}, d{i, j + 1};
        const bool turned = (i + j) % 2 == 1;
        use(std::array<Corner, 3>{a, b, turned ? d : c});
        use(std::array<Corner, 3>{turned ? b : a, c, d});
      }
    }
  }
};

double share_above(const StripOptions& options, int layer) {
  return layer == 0 ? 0.0 : options.tissue.layers[layer - 1].bottom_share;
}

void add_nodes(const StripOptions& options, const Grid& grid, Lattice& lattice) {
  lattice.num_vertices = grid.per_layer();
  lattice.num_free_nodes = grid.num_free();
  lattice.rest_mm.resize(grid.num_nodes());
  lattice.mass_kg.assign(grid.num_nodes(), 0.0);
  lattice.column_of.resize(grid.num_nodes());
  lattice.columns.resize(grid.per_layer());
  for (int layer = 0; layer <= grid.layers; ++layer) {
    for (int i = 0; i <= grid.along; ++i) {
      for (int j = 0; j <= grid.across; ++j) {
        const int node = grid.node(i, j, layer);
        lattice.rest_mm[node] = {options.length_mm * i / grid.along,
                                 options.width_mm * j / grid.across,
                                 -options.depth_mm * share_above(options, layer)};
        // Clamped nodes count to the column beside them.
        const int column = grid.node(std::clamp(i, 1, grid.along - 1), j, 0);
        lattice.column_of[node] = column;
        if (!grid.is_clamped(i)) lattice.columns[column].nodes.push_back(node);
      }
    }
  }
  for (int c = 0; c < grid.per_layer(); ++c) {
    lattice.columns[c].vertex = {c, c, c};
    lattice.columns[c].on_bone = false;
    lattice.columns[c].depth_mm = options.depth_mm;
  }
}

void add_tissue(const StripOptions& options, const Grid& grid, Lattice& lattice) {
  SpringCollector springs(lattice, options.tissue);
  grid.for_each_triangle([&](const auto& corners) {
    for (int layer = 0; layer < grid.layers; ++layer) {
      const TissueLayer& tissue = options.tissue.layers[layer];
      Prism prism;
      for (int c = 0; c < 3; ++c) {
        prism.node[c] = grid.node(corners[c][0], corners[c][1], layer);
        prism.node[c + 3] = grid.node(corners[c][0], corners[c][1], layer + 1);
      }
      prism.rest_mm3 = signed_volume(prism, lattice.rest_mm);
      prism.bulk_kpa = tissue.bulk_ratio * tissue.modulus_kpa;
      for (const int node : prism.node) {
        lattice.mass_kg[node] += options.tissue.density_kg_per_mm3 * prism.rest_mm3 / 6.0;
      }
      add_prism_springs(prism, tissue, 1.0, springs);
      if (tissue.bulk_ratio > 0.0) lattice.prisms.push_back(prism);
    }
    const TissueLayer epidermis{"epidermis",
                                0.0,
                                options.tissue.epidermis_modulus_kpa,
                                options.tissue.epidermis_stiff_ratio,
                                0.0,
                                options.tissue.epidermis_alpha_mn_per_mm};
    const double area = 0.5 * options.length_mm * options.width_mm / (grid.along * grid.across);
    const double share = area * options.tissue.epidermis_thickness_mm / 3.0;
    for (int c = 0; c < 3; ++c) {
      const auto& [i, j] = corners[c];
      const auto& [k, l] = corners[(c + 1) % 3];
      springs.add(grid.node(i, j, 0), grid.node(k, l, 0), share, epidermis, 1.0);
    }
  });
  springs.finish();
}

void add_surface(const Grid& grid, Strip& strip) {
  Lattice& lattice = strip.lattice;
  Anatomy& anatomy = strip.anatomy;
  const int n = lattice.num_vertices;
  anatomy.surface.positions_mm.assign(lattice.rest_mm.begin(), lattice.rest_mm.begin() + n);
  anatomy.tissue_depth_mm.assign(n, lattice.columns.front().depth_mm);
  anatomy.mandible_weight.assign(n, 0.0);
  anatomy.region.assign(n, Region::kFace);
  std::set<std::array<int, 2>> edges;
  grid.for_each_triangle([&](const auto& corners) {
    Triangle t;
    for (int c = 0; c < 3; ++c) t[c] = grid.node(corners[c][0], corners[c][1], 0);
    const Vec3 u = lattice.rest_mm[t[1]] - lattice.rest_mm[t[0]];
    const Vec3 v = lattice.rest_mm[t[2]] - lattice.rest_mm[t[0]];
    for (const int node : t) {
      if (node < n) lattice.columns[node].area_mm2 += u.cross(v).norm() / 6.0;
    }
    for (int c = 0; c < 3; ++c) {
      const auto [a, b] = std::minmax(t[c], t[(c + 1) % 3]);
      if (b < n) edges.insert({a, b});
    }
    if (*std::max_element(t.begin(), t.end()) < n) anatomy.surface.triangles.push_back(t);
  });
  lattice.edges.assign(edges.begin(), edges.end());
  lattice.neighbors = neighbors_by(lattice.edges, n);
}

}  // namespace

void StripOptions::check() const {
  require_range("strip: length_mm", length_mm, 1.0, 1e3);
  require_range("strip: width_mm", width_mm, 0.1, 1e3);
  require_range("strip: depth_mm", depth_mm, 0.1, 1e3);
  require_range("strip: cells_along", cells_along, 2, 200);
  require_range("strip: cells_across", cells_across, 1, 50);
  tissue.check();
}

Strip make_strip(const StripOptions& options) {
  options.check();
  const Grid grid{
      options.cells_along, options.cells_across, static_cast<int>(options.tissue.layers.size())};
  Strip strip;
  strip.length_mm = options.length_mm;
  strip.area_mm2 = options.width_mm * options.depth_mm;
  add_nodes(options, grid, strip.lattice);
  add_tissue(options, grid, strip.lattice);
  add_surface(grid, strip);
  for (int layer = 0; layer <= grid.layers; ++layer) {
    for (int j = 0; j <= grid.across; ++j) strip.pulled.push_back(grid.node(grid.along, j, layer));
  }
  return strip;
}

TensileTest::TensileTest(Strip strip, const std::vector<EffectChoice>& effects)
    : strip_(std::move(strip)),
      energy_(strip_.anatomy, strip_.lattice, {}, effects),
      solver_(energy_) {
  state_.positions_mm = strip_.lattice.rest_mm;
}

void TensileTest::begin(double step_s) {
  if (step_s != last_step_s_) solver_.forget();
  last_step_s_ = step_s;
  if (step_s > 0.0) energy_.begin_step(state_, step_s);
}

StripPoint TensileTest::end(double step_s, double stress_kpa, bool converged) {
  if (step_s > 0.0) {
    energy_.end_step(state_);
    state_.time_s += step_s;
  } else {
    state_.history.clear();
    state_.velocities_mm_per_s.clear();
    state_.time_s = 0.0;
  }
  return {state_.time_s, strain_, stress_kpa, converged};
}

// Of the strip at equilibrium with its end at a strain; leaves it there.
double TensileTest::stress_at(double strain, bool& converged) {
  std::vector<Vec3>& x = state_.positions_mm;
  // Everything goes along in proportion, then finds its place.
  const double stretch = (1.0 + strain) / (1.0 + strain_);
  for (int k = 0; k < strip_.lattice.num_free_nodes; ++k) x[k].x() *= stretch;
  for (const int node : strip_.pulled) {
    x[node].x() = strip_.lattice.rest_mm[node].x() + strain * strip_.length_mm;
  }
  strain_ = strain;
  converged = solver_.solve(x, {kResidual, kSmallestLoadMn, kMostIterations}).converged;
  energy_.evaluate(x, gradient_);
  double force_mn = 0.0;
  for (const int node : strip_.pulled) force_mn += gradient_[3 * node];
  return force_mn / strip_.area_mm2;
}

StripPoint TensileTest::hold(double strain, double step_s) {
  begin(step_s);
  bool converged = false;
  const double stress = stress_at(strain, converged);
  return end(step_s, stress, converged);
}

// Secants from where the strip is: its slope hardly changes from step to step.
StripPoint TensileTest::load(double stress_kpa, double step_s) {
  begin(step_s);
  bool settled = false;
  double strain = strain_;
  double stress = stress_at(strain, settled);
  if (slope_kpa_ == 0.0) {
    const double probed = stress_at(strain + kProbeStrain, settled);
    slope_kpa_ = (probed - stress) / kProbeStrain;
  }
  bool converged = false;
  for (int trial = 0; trial < kMostTrials && !converged; ++trial) {
    const double next = strain + (stress_kpa - stress) / slope_kpa_;
    const double stress_there = stress_at(next, settled);
    const double rise = stress_there - stress;
    // A secant over nearly nothing is all rounding.
    if (std::abs(next - strain) > kProbeStrain && rise * (next - strain) > 0.0) {
      slope_kpa_ = rise / (next - strain);
    }
    strain = next;
    stress = stress_there;
    converged = settled && std::abs(stress - stress_kpa) <= kLoadTolerance * std::abs(stress_kpa);
  }
  return end(step_s, stress, converged);
}

double TensileTest::modulus_kpa() {
  const double up = hold(kProbeStrain).stress_kpa;
  hold(0.0);
  return up / kProbeStrain;
}

double StandardLinearSolid::relaxing_stress(double strain, double time_s) const {
  return modulus_kpa * strain * (1.0 + ratio * std::exp(-time_s / relaxation_s));
}

double StandardLinearSolid::creeping_strain(double stress_kpa, double time_s) const {
  const double slower_s = (1.0 + ratio) * relaxation_s;
  return stress_kpa / modulus_kpa * (1.0 - ratio / (1.0 + ratio) * std::exp(-time_s / slower_s));
}

double StandardLinearSolid::cycling_stress(double mean_strain,
                                           double period_s,
                                           double time_s) const {
  const double w = 2.0 * std::numbers::pi / period_s;
  const double wt = w * relaxation_s;
  const double slow =
      ratio * mean_strain * wt / (1.0 + wt * wt) *
      (std::sin(w * time_s) - wt * std::cos(w * time_s) + wt * std::exp(-time_s / relaxation_s));
  return modulus_kpa * (mean_strain * (1.0 - std::cos(w * time_s)) + slow);
}

std::vector<StripPoint> stretch_slowly(TensileTest& test, double highest_strain, int num_steps) {
  std::vector<StripPoint> points;
  for (int k = 0; k <= num_steps; ++k) points.push_back(test.hold(highest_strain * k / num_steps));
  return points;
}

std::vector<StripPoint> relax(TensileTest& test, double strain, double duration_s, double step_s) {
  test.hold(0.0);
  std::vector<StripPoint> points{test.hold(strain, kInstant_s)};
  while (points.back().time_s < duration_s) points.push_back(test.hold(strain, step_s));
  return points;
}

std::vector<StripPoint> creep(TensileTest& test,
                              double stress_kpa,
                              double duration_s,
                              double step_s) {
  test.hold(0.0);
  std::vector<StripPoint> points{test.load(stress_kpa, kInstant_s)};
  while (points.back().time_s < duration_s) points.push_back(test.load(stress_kpa, step_s));
  return points;
}

std::vector<StripPoint> cycle(
    TensileTest& test, double mean_strain, double period_s, int num_cycles, int steps_per_cycle) {
  std::vector<StripPoint> points{test.hold(0.0)};
  const double step_s = period_s / steps_per_cycle;
  for (int k = 1; k <= num_cycles * steps_per_cycle; ++k) {
    const double phase = 2.0 * std::numbers::pi * k / steps_per_cycle;
    points.push_back(test.hold(mean_strain * (1.0 - std::cos(phase)), step_s));
  }
  return points;
}

}  // namespace zygoma
