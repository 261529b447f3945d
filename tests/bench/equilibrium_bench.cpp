// What the tissue costs and how far it is from the truth: frames of an animation settled warm,
// steps of implicit time, renewed factors and sensitivities, at several densities of the generic
// head.
//
//   equilibrium_bench [REPEATS] [RESULT.csv]
//
// The animation is a broad smile with raised brows in which no contraction changes by more than
// 0.02 per frame. CPU time of one thread; the sizes alternate within a repeat, medians are
// reported. Errors are distances of surface vertices from the same frame settled to a residual of
// 1e-10, from the state at hand (what the tolerance leaves) and along a path of its own (what
// history adds: folds may lie one way or another).
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "face/generic_head.h"
#include "face/simulator.h"
#include "face/solvers/equilibrium.h"
#include "tests/bench/bench_tools.h"

namespace zygoma {
namespace {

constexpr int kFrames = 100;
constexpr double kFrameS = 1.0 / 60.0;

using bench::cpu_ms;
using bench::median;

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

struct Distance {
  double largest = 0.0;
  double sum2 = 0.0;
  std::size_t count = 0;

  void add(const std::vector<Vec3>& a, const std::vector<Vec3>& b, std::size_t num_vertices) {
    for (std::size_t v = 0; v < num_vertices; ++v) {
      const double d2 = (a[v] - b[v]).squaredNorm();
      largest = std::max(largest, std::sqrt(d2));
      sum2 += d2;
    }
    count += num_vertices;
  }
  double rms() const { return std::sqrt(sum2 / static_cast<double>(count)); }
};

Controls smile(const Anatomy& anatomy, int frame) {
  const auto wave = [&](double period) {
    return 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * frame / period);
  };
  Controls controls{std::vector<double>(anatomy.muscles.size(), 0.0), 0.08 * wave(200.0)};
  for (std::size_t m = 0; m < anatomy.muscles.size(); ++m) {
    const std::string& name = anatomy.muscles[m].name;
    if (name.starts_with("zygomaticus_major")) controls.contraction[m] = wave(160.0);
    if (name.starts_with("occipitofrontalis")) controls.contraction[m] = 0.8 * wave(200.0);
    if (name.starts_with("levator_labii_superioris_alaeque")) continue;
    if (name.starts_with("levator_labii_superioris")) controls.contraction[m] = 0.6 * wave(160.0);
  }
  return controls;
}

class Bench {
 public:
  explicit Bench(int surface_vertices)
      : anatomy_(std::make_shared<const Anatomy>(make_generic_head(
            {},
            {.num_surface_vertices = surface_vertices, .skin_levels = 0, .albedo_size_px = 64}))),
        energy_(*anatomy_),
        solver_(energy_),
        factor_(solver_.hessian().free()) {
    dynamic_.effects.push_back({"inertia", {}});
  }

  void repeat() {
    parts();
    warm_frames();
    implicit_steps();
  }

  // Once: distances do not depend on the clock.
  void measure_errors() {
    Simulator face(anatomy_);
    SettleOptions tight;
    tight.relative_residual = 1e-10;
    tight.max_iterations = 500;
    Simulator reference(anatomy_, {}, tight);
    FaceState state = face.rest();
    FaceState own_path = state;
    for (int f = 0; f < kFrames; ++f) {
      const Controls controls = smile(*anatomy_, f);
      const SettleReport report = face.settle(controls, state);
      iterations_.push_back(report.iterations);
      factorisations_.push_back(report.factorisations);
      unsettled_ += !report.converged;
      inverted_ = std::max(inverted_, report.inverted_elements);
      reference.settle(controls, own_path);
      if (f % 5 != 0) continue;
      FaceState settled = state;
      Simulator(anatomy_, {}, tight).settle(controls, settled);
      const std::size_t n = anatomy_->surface.positions_mm.size();
      tolerance_error_.add(state.positions_mm, settled.positions_mm, n);
      path_error_.add(state.positions_mm, own_path.positions_mm, n);
    }
  }

  void print(std::ostream& out) const {
    const Lattice& lattice = energy_.lattice();
    out << lattice.num_vertices << ',' << lattice.rest_mm.size() << ',' << lattice.springs.size()
        << ',' << lattice.prisms.size() << ',' << factor_.size();
    for (const auto* ms : {&evaluate_ms_,
                           &hessian_ms_,
                           &factor_ms_,
                           &solve_ms_,
                           &block_ms_,
                           &frame_ms_,
                           &step_ms_}) {
      out << ',' << median(*ms);
    }
    out << ',' << mean(iterations_) << ',' << mean(factorisations_) << ','
        << tolerance_error_.largest << ',' << tolerance_error_.rms() << ',' << path_error_.largest
        << ',' << path_error_.rms() << ',' << unsettled_ << ',' << inverted_ << '\n';
  }

  static const char* header() {
    return "surface_vertices,nodes,springs,elements,factor_numbers,evaluate_ms,hessian_ms,factor_"
           "ms,"
           "solve_ms,sensitivities_ms,warm_frame_ms,implicit_step_ms,iterations_per_frame,"
           "factors_per_frame,tolerance_error_max_mm,tolerance_error_rms_mm,path_error_max_mm,"
           "path_error_rms_mm,unsettled_frames,inverted_elements\n";
  }

 private:
  template <typename Work>
  static double time(int times, const Work& work) {
    const double begin = cpu_ms();
    for (int k = 0; k < times; ++k) work();
    return (cpu_ms() - begin) / times;
  }

  void parts() {
    const Controls controls = smile(*anatomy_, 50);
    FaceState state;
    {
      Simulator face(anatomy_);
      state = face.rest();
      face.settle(controls, state);
    }
    const std::vector<Vec3>& x = state.positions_mm;
    energy_.set_controls(controls.contraction, controls.jaw_rad);
    Eigen::VectorXd gradient;
    evaluate_ms_.push_back(time(200, [&] { energy_.evaluate(x, gradient); }));
    TissueHessian hessian = energy_.make_hessian();
    hessian_ms_.push_back(time(5, [&] { energy_.hessian(x, hessian); }));
    factor_ms_.push_back(time(5, [&] { factor_.compute(hessian.free(), 0.0); }));
    Eigen::VectorXd one = Eigen::VectorXd::Ones(energy_.num_unknowns());
    solve_ms_.push_back(time(50, [&] { factor_.solve_roughly(one); }));
    const Eigen::MatrixXd forces = energy_.control_forces(x, hessian);
    Eigen::MatrixXd block(forces.rows(), 20);
    for (int k = 0; k < block.cols(); ++k) block.col(k) = forces.col(k % forces.cols());
    const Eigen::MatrixXd right_hand_sides = block;
    block_ms_.push_back(time(5, [&] {
      block = right_hand_sides;
      factor_.solve(block);
    }));
  }

  void warm_frames() {
    Simulator face(anatomy_);
    FaceState state = face.rest();
    face.settle(smile(*anatomy_, 1), state);
    const double begin = cpu_ms();
    for (int f = 2; f < kFrames; ++f) face.settle(smile(*anatomy_, f), state);
    frame_ms_.push_back((cpu_ms() - begin) / (kFrames - 2));
  }

  void implicit_steps() {
    Simulator face(anatomy_, dynamic_);
    FaceState state = face.rest();
    face.advance(smile(*anatomy_, 1), kFrameS, state);
    const double begin = cpu_ms();
    for (int f = 2; f < kFrames; ++f) face.advance(smile(*anatomy_, f), kFrameS, state);
    step_ms_.push_back((cpu_ms() - begin) / (kFrames - 2));
  }

  std::shared_ptr<const Anatomy> anatomy_;
  FaceEnergy energy_;
  EquilibriumSolver solver_;
  Factor factor_;
  TissueModel dynamic_;
  std::vector<double> evaluate_ms_, hessian_ms_, factor_ms_, solve_ms_, block_ms_, frame_ms_,
      step_ms_;
  std::vector<double> iterations_, factorisations_;
  Distance tolerance_error_, path_error_;
  int unsettled_ = 0;
  int inverted_ = 0;
};

int run_bench(int repeats, const char* csv) {
  std::vector<std::unique_ptr<Bench>> sizes;
  for (const int surface_vertices : {325, 500, 1000, 2000}) {
    sizes.push_back(std::make_unique<Bench>(surface_vertices));
  }
  for (int r = 0; r < repeats; ++r) {
    for (const auto& size : sizes) size->repeat();
  }
  std::string table = Bench::header();
  std::ostringstream rows;
  for (const auto& size : sizes) {
    size->measure_errors();
    size->print(rows);
  }
  table += rows.str();
  std::printf("%s", table.c_str());
  if (csv) {
    std::ofstream out(csv);
    out << "# equilibrium_bench " << repeats << "; medians\n" << table;
    if (!out) return 1;
  }
  return 0;
}

}  // namespace
}  // namespace zygoma

int main(int argc, char** argv) {
  return zygoma::run_bench(argc > 1 ? std::atoi(argv[1]) : 5, argc > 2 ? argv[2] : nullptr);
}
