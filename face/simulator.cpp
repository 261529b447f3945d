#include "face/simulator.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "face/active_region.h"
#include "face/effect_chooser.h"
#include "face/energy.h"
#include "face/explicit_face.h"
#include "face/resting_tissue.h"
#include "face/solvers/equilibrium.h"
#include "src/base/check.h"

namespace zygoma {
namespace {

// Larger changes of the controls are walked in equal parts, so that a jump ends in the same
// equilibrium as a slow motion.
constexpr double kLongestContractionStep = 0.34;
constexpr double kLongestJawStepRad = 0.12;
constexpr double kPathTolerance = 0.2;  // of the load, at the points in between
constexpr double kAnyWayMm = 1e3;       // left there
constexpr double kWayLeftMm = 0.02;
constexpr double kJumpShare = 0.1;  // of the tolerance, at the end of a jump: it has stirred the
                                    // soft motions that forces hardly show
constexpr double kSmallestLoadMm = 1e-5;  // a load below this stretch counts as this
constexpr double kLongestExtrapolation = 1.5;
constexpr double kLookAhead = 3.0;   // frames: half the life of a factor in a steady motion
constexpr double kHeapShare = 0.01;  // of the elements
constexpr double kWidestJawRad = 0.7;
constexpr double kSameStepShare = 1e-3;  // steps that differ less share a factor

// Explicit steps bring inertia with them: as an effect they take it only for its parameters.
TissueModel without_inertia(const TissueModel& tissue) {
  TissueModel rest = tissue;
  std::erase_if(rest.effects, [](const EffectChoice& choice) { return choice.name == "inertia"; });
  return rest;
}

constexpr double kCreepS = 0.5;        // a face that creeps goes on at that speed for about so long
constexpr double kSteadyShare = 0.01;  // of the tolerance: controls that move the face less stand
constexpr double kUnseenShare = 0.5;   // of the tolerance: a frame that moves no more is left out
// Of the tolerance: a frame this near to its end is done. By the number of contacts that act:
// tissue that slides on something snaps at times, and more so between two things. A frame that ends
// too early is then a snap too late.
constexpr std::array<double, 3> kNearShares{0.5, 0.2, 0.05};

// Contractions, and the jaw last.
std::vector<double> all_of(const Controls& controls) {
  std::vector<double> all = controls.contraction;
  all.push_back(controls.jaw_rad);
  return all;
}

// What a scene that chooses needs beside the simulation.
struct Choice {
  Choice(FaceEnergy& energy, EquilibriumSolver& solver, double tolerance)
      : tolerance_mm(tolerance),
        reach(find_control_reach(energy, solver)),
        chooser(energy, tolerance),
        resting(energy, reach, tolerance) {}

  // How far the controls move what they move furthest, to first order.
  double moved_mm(const Controls& from, const Controls& to) const {
    std::vector<double> moved(reach.stiffness.size(), 0.0);
    const auto add = [&](std::size_t control, double change) {
      if (change == 0.0) return;
      for (std::size_t c = 0; c < moved.size(); ++c) {
        moved[c] += std::abs(change) * reach.mm[control][c];
      }
    };
    for (std::size_t m = 0; m < to.contraction.size(); ++m) {
      add(m, to.contraction[m] - from.contraction[m]);
    }
    add(to.contraction.size(), to.jaw_rad - from.jaw_rad);
    return *std::max_element(moved.begin(), moved.end());
  }

  double near_mm() const {
    const std::size_t contacts = chooser.num_contacts();
    return kNearShares[std::min(contacts, kNearShares.size() - 1)] * tolerance_mm;
  }

  bool leaves_out() const { return !chooser.all_act() || resting.moving_share() < 1.0; }

  double tolerance_mm;
  ControlReach reach;
  EffectChooser chooser;
  RestingTissue resting;
  double owed_s = 0.0;          // time that has passed without being solved for
  double speed_mm_per_s = 0.0;  // of the face, in the last frame that was solved for
  double creep_mm_per_s = 0.0;  // as far as not by the controls; infinite = unknown
  bool stood_still = false;     // the frame before was left out
  SettleReport last;
};

}  // namespace

void SettleOptions::check() const {
  require(relative_residual > 0.0 && relative_residual <= 1.0,
          "relative_residual is " + shortest_text(relative_residual) + ", expected (0, 1]");
  require_range("max_iterations", max_iterations, 1, 1e6);
  require_range("still_mm", still_mm, 0.0, 10.0);
  require_range("choose_mm", choose_mm, 0.0, kMostChooseMm);
}

struct Simulator::Impl {
  Impl(std::shared_ptr<const Anatomy> a, const TissueModel& tissue, const SettleOptions& o)
      : anatomy(std::move(a)),
        options(o),
        energy(*anatomy, o.solver == Solver::kExplicit ? without_inertia(tissue) : tissue),
        solver(energy),
        region(energy),
        sensitivity_factor(solver.factor()),
        known(energy.lattice().rest_mm),
        known_controls(zero_controls()) {
    options.check();
    double area = 0.0;
    for (const Column& column : energy.lattice().columns) area += column.area_mm2;
    smallest_load =
        kSmallestLoadMm * tissue.muscles.hold_kpa_per_mm * area / energy.lattice().num_vertices;
    if (options.solver == Solver::kExplicit) {
      const EffectValues inertia = effect_values("inertia", tissue.effects);
      explicit_face =
          std::make_unique<ExplicitFace>(energy, inertia["mass_factor"], inertia["damping_per_s"]);
    } else if (options.choose_mm > 0.0) {
      choice.emplace(energy, solver, options.choose_mm);
    }
  }

  Controls zero_controls() const {
    return {std::vector<double>(anatomy->muscles.size(), 0.0), 0.0};
  }

  void check(const Controls& controls) const {
    assert(controls.contraction.size() == anatomy->muscles.size());
    for (std::size_t m = 0; m < controls.contraction.size(); ++m) {
      const double c = controls.contraction[m];
      if (c >= 0.0 && c <= 1.0) continue;
      throw InputError("contraction of " + anatomy->muscles[m].name + ": " + std::to_string(c) +
                       ", expected a value in [0, 1]");
    }
    require(controls.jaw_rad >= 0.0 && controls.jaw_rad <= kWidestJawRad,
            "jaw opening: " + std::to_string(controls.jaw_rad) + " rad, expected [0, " +
                std::to_string(kWidestJawRad) + "]");
  }

  // Sets the controls and takes every node along with the bone below it.
  void carry(const Controls& from, const Controls& to, std::vector<Vec3>& x) {
    if (from.jaw_rad != to.jaw_rad) {
      energy.set_controls(from.contraction, from.jaw_rad);
      std::vector<Vec3> before(x.size());
      for (std::size_t k = 0; k < x.size(); ++k) before[k] = energy.carried(static_cast<int>(k));
      energy.set_controls(to.contraction, to.jaw_rad);
      for (std::size_t k = 0; k < x.size(); ++k) {
        x[k] += energy.carried(static_cast<int>(k)) - before[k];
      }
    } else {
      energy.set_controls(to.contraction, to.jaw_rad);
    }
    energy.place_bone(x);
  }

  // Controls that go on as they went take the tissue on as it went: starts there if that is lower
  // in energy than where x stands.
  void extrapolate(const Controls& from,
                   const Controls& to,
                   const std::vector<Vec3>& before,
                   std::vector<Vec3>& x) {
    if (previous.empty() || before != known) return;
    double along = 0.0;
    double length2 = 0.0;
    const auto compare = [&](double p, double f, double t) {
      along += (f - p) * (t - f);
      length2 += (f - p) * (f - p);
    };
    for (std::size_t m = 0; m < to.contraction.size(); ++m) {
      compare(previous_controls.contraction[m], from.contraction[m], to.contraction[m]);
    }
    compare(previous_controls.jaw_rad, from.jaw_rad, to.jaw_rad);
    if (!(along > 0.0)) return;
    const double share = std::min(along / length2, kLongestExtrapolation);
    std::vector<Vec3> further = before;
    for (std::size_t k = 0; k < x.size(); ++k) further[k] += share * (before[k] - previous[k]);
    energy.place_bone(further);
    start_if_lower(further, x);
    ahead = x;
    for (std::size_t k = 0; k < x.size(); ++k) {
      ahead[k] += kLookAhead * share * (before[k] - previous[k]);
    }
  }

  // Without controls rest is an equilibrium by construction, or close to one.
  void start_at_rest_if_lower(std::vector<Vec3>& x) {
    std::vector<Vec3> rest = energy.lattice().rest_mm;
    start_if_lower(rest, x);
  }

  void start_if_lower(std::vector<Vec3>& candidate, std::vector<Vec3>& x) {
    if (energy.evaluate(candidate, scratch) < energy.evaluate(x, scratch)) x.swap(candidate);
  }

  void minimise(double share_of_load,
                double way_left_mm,
                std::vector<Vec3>& x,
                SettleReport& report,
                const std::vector<Vec3>* start = nullptr) {
    const EquilibriumReport solved =
        solver.solve(x,
                     {share_of_load, smallest_load, options.max_iterations, way_left_mm, near_mm},
                     {start, ahead.empty() ? nullptr : &ahead});
    report.iterations += solved.iterations;
    report.factorisations += solved.factorisations;
    report.residual = solved.residual_mn / solved.load_mn;
    report.converged = solved.converged;
  }

  // From an equilibrium under `from` to one under `to`, in `parts` equal parts.
  bool walk(const Controls& from,
            const Controls& to,
            int parts,
            std::vector<Vec3>& x,
            SettleReport& report) {
    Controls at = from;
    for (int part = 1; part <= parts; ++part) {
      const double share = static_cast<double>(part) / parts;
      Controls next = to;
      if (part < parts) {
        for (std::size_t m = 0; m < next.contraction.size(); ++m) {
          next.contraction[m] =
              from.contraction[m] + share * (to.contraction[m] - from.contraction[m]);
        }
        next.jaw_rad = from.jaw_rad + share * (to.jaw_rad - from.jaw_rad);
      }
      const std::vector<Vec3> before = x;
      carry(at, next, x);
      ahead.clear();
      if (parts == 1) extrapolate(from, to, before, x);
      if (part == parts && to == zero_controls()) start_at_rest_if_lower(x);
      if (part < parts) {
        minimise(kPathTolerance, kAnyWayMm, x, report);
      } else {
        const double tolerance = (parts > 1 ? kJumpShare : 1.0) * options.relative_residual;
        minimise(tolerance, kWayLeftMm, x, report);
        report.converged = report.converged || report.residual <= options.relative_residual;
      }
      at = std::move(next);
    }
    return report.converged;
  }

  static int parts_between(const Controls& from, const Controls& to) {
    double parts = std::abs(to.jaw_rad - from.jaw_rad) / kLongestJawStepRad;
    for (std::size_t m = 0; m < to.contraction.size(); ++m) {
      parts = std::max(parts,
                       std::abs(to.contraction[m] - from.contraction[m]) / kLongestContractionStep);
    }
    return std::max(1, static_cast<int>(std::ceil(parts)));
  }

  // Where that many elements are inside out, nothing can be told from the places of the nodes.
  bool is_heap(const FaceState& state) const {
    if (state.positions_mm == known) return false;
    const double inverted = energy.volumes(state.positions_mm).inverted;
    return inverted > kHeapShare * static_cast<double>(energy.lattice().prisms.size());
  }

  // The controls a state is known to be the equilibrium of; without knowledge, those wanted, with
  // the jaw of the state.
  Controls controls_of(const FaceState& state, const Controls& wanted) const {
    if (state.positions_mm == known) return known_controls;
    if (state.positions_mm == energy.lattice().rest_mm) return zero_controls();
    Controls controls = wanted;
    controls.jaw_rad = state.jaw_rad;
    return controls;
  }

  // The path decides where the face ends. From a heap that may be a folded equilibrium: it has to
  // compare with the path from rest.
  SettleReport settle_moving(const Controls& from,
                             const Controls& to,
                             bool from_heap,
                             std::vector<Vec3>& x) {
    SettleReport report;
    const bool there = walk(from, to, parts_between(from, to), x, report);
    if (there && !from_heap) return report;
    SettleReport again = report;
    std::vector<Vec3> other = energy.lattice().rest_mm;
    const Controls zero = zero_controls();
    const bool there_too = walk(zero, to, 3 * parts_between(zero, to), other, again);
    const bool better = there && there_too
                            ? energy.evaluate(other, scratch) < energy.evaluate(x, scratch)
                            : again.residual < report.residual;
    if (better) {
      x = std::move(other);
    } else {
      again.residual = report.residual;
      again.converged = report.converged;
    }
    return again;
  }

  void enter_step(double step_s) {
    // Frames of one rate are of equal length up to rounding.
    if (std::abs(step_s - last_step_s) <= kSameStepShare * last_step_s) return;
    last_step_s = step_s;
    solver.forget();
  }

  // An implicit step. Starts where the velocities lead, if that is lower in energy than where the
  // tissue stands.
  void step_to_minimum(double step_s, FaceState& state, SettleReport& report) {
    const bool moves = !state.velocities_mm_per_s.empty();
    std::vector<Vec3> coasted;
    if (moves) {
      coasted = state.positions_mm;
      for (int k = 0; k < energy.lattice().num_free_nodes; ++k) {
        coasted[k] += step_s * state.velocities_mm_per_s[k];
      }
    }
    ahead.clear();
    minimise(options.relative_residual,
             kWayLeftMm,
             state.positions_mm,
             report,
             moves ? &coasted : nullptr);
  }

  SettleReport advance_explicitly(const Controls& controls, double step_s, FaceState& state) {
    check(controls);
    energy.set_controls(controls.contraction, controls.jaw_rad);
    const ExplicitReport done = explicit_face->advance(step_s, state);
    state.time_s += step_s;
    SettleReport report;
    report.converged = !done.gave_up;
    report.substeps = done.substeps;
    report.stable_step_s = done.bound_s;
    report.restores = done.restores;
    report.residual =
        done.residual_mn / std::max(smallest_load, energy.largest_muscle_force(state.positions_mm));
    finish(controls, state, report);
    return report;
  }

  // All effects act and all tissue moves, after what is no motion from the frame before.
  void choose_all(const Controls& controls) {
    choice->chooser.let_all_act();
    choice->resting.wake_all(all_of(controls), solver);
    choice->owed_s = 0.0;
    choice->stood_still = false;
    choice->speed_mm_per_s = 0.0;
    choice->creep_mm_per_s = std::numeric_limits<double>::infinity();
  }

  // A frame with as much as it needs.
  SettleReport advance_by_choice(const Controls& controls, double frame_s, FaceState& state) {
    check(controls);
    if (state.positions_mm != known) choose_all(controls_of(state, controls));
    Choice& c = *choice;
    const double step_s = c.owed_s + frame_s;
    const double moved_mm = c.moved_mm(known_controls, controls);
    state.time_s += frame_s;
    if (moved_mm + c.creep_mm_per_s * step_s <= kUnseenShare * c.tolerance_mm) {
      c.owed_s = step_s;
      c.stood_still = true;
      SettleReport report = c.last;
      report.solved = false;
      report.iterations = report.factorisations = 0;
      return report;
    }
    c.chooser.expect(
        {step_s, moved_mm, std::abs(moved_mm - step_s * c.speed_mm_per_s), c.reach.sag_mm});
    const bool at_rest =
        c.stood_still && kCreepS * c.creep_mm_per_s <= kUnseenShare * c.tolerance_mm;
    c.resting.follow(all_of(controls), step_s, at_rest, solver);
    const FaceState before = state;
    SettleReport report;
    while (!step(controls, step_s, state, report)) state = before;
    c.chooser.dismiss(state);
    double largest2 = 0.0;
    for (std::size_t k = 0; k < before.positions_mm.size(); ++k) {
      largest2 = std::max(largest2, (state.positions_mm[k] - before.positions_mm[k]).squaredNorm());
    }
    const bool steady = moved_mm <= kSteadyShare * c.tolerance_mm && report.converged;
    c.creep_mm_per_s = std::numeric_limits<double>::infinity();
    if (steady) c.creep_mm_per_s = c.chooser.looks_back() ? std::sqrt(largest2) / step_s : 0.0;
    c.speed_mm_per_s = moved_mm / step_s;
    c.owed_s = 0.0;
    c.stood_still = false;
    finish(controls, state, report);
    report.moving_share = c.resting.moving_share();
    c.last = report;
    return report;
  }

  // False if an effect was missing, which then is there.
  bool step(const Controls& controls, double step_s, FaceState& state, SettleReport& report) {
    const Controls from = controls_of(state, controls);
    const bool looks_back = choice->chooser.looks_back();
    const std::vector<Vec3> before = state.positions_mm;
    if (last_step_s == 0.0) enter_step(step_s);
    // With everything there, the frame is that of everything to the bit.
    near_mm = choice->leaves_out() ? choice->near_mm() : 0.0;
    if (looks_back) {
      energy.begin_step(state, step_s);
      carry(from, controls, state.positions_mm);
      step_to_minimum(step_s, state, report);
    } else {
      report = settle_moving(from, controls, false, state.positions_mm);
    }
    near_mm = 0.0;
    const bool complete = choice->chooser.accept(state.positions_mm, step_s, solver);
    if (looks_back) {
      std::vector<double> left_mm;
      if (complete && choice->resting.could_shrink()) left_mm = way_to_creep(state.positions_mm);
      energy.end_step(state);
      if (!left_mm.empty()) choice->resting.shrink(left_mm, solver);
    }
    // Of the last step also where inertia is away: it may come with the next.
    state.velocities_mm_per_s.resize(before.size());
    for (std::size_t k = 0; k < before.size(); ++k) {
      state.velocities_mm_per_s[k] = (state.positions_mm[k] - before[k]) / step_s;
    }
    return complete;
  }

  // Per column, how far it would go if all effects let go that look back.
  std::vector<double> way_to_creep(const std::vector<Vec3>& x) {
    scratch.setZero(3 * energy.num_nodes());
    for (std::size_t k = 0; k < energy.effects().parts().size(); ++k) {
      const Effects::Part& part = energy.effects().parts()[k];
      if (part.acts && !part.memory.empty()) energy.add_effect_gradient(k, x, scratch);
    }
    const Lattice& lattice = energy.lattice();
    std::vector<double> way(lattice.columns.size(), std::numeric_limits<double>::infinity());
    if (!solver.has_factor()) return way;
    solver.factor().solve_roughly(scratch.head(energy.num_unknowns()));
    std::fill(way.begin(), way.end(), 0.0);
    for (int node = 0; node < lattice.num_free_nodes; ++node) {
      double& most = way[lattice.column_of[node]];
      most = std::max(most, scratch.segment<3>(3 * node).norm());
    }
    return way;
  }

  void finish(const Controls& controls, FaceState& state, SettleReport& report) {
    const FaceEnergy::VolumeReport volumes = energy.volumes(state.positions_mm);
    report.inverted_elements = volumes.inverted;
    report.mean_volume_change = volumes.mean_change;
    report.moving_share = region.moving_share();
    state.jaw_rad = controls.jaw_rad;
    previous = std::move(known);
    previous_controls = std::move(known_controls);
    known = state.positions_mm;
    known_controls = controls;
  }

  std::shared_ptr<const Anatomy> anatomy;
  SettleOptions options;
  FaceEnergy energy;
  EquilibriumSolver solver;
  ActiveRegion region;
  std::unique_ptr<ExplicitFace> explicit_face;  // if that is the solver
  std::optional<Choice> choice;                 // if the scene leaves one
  Factor sensitivity_factor;  // apart, so that asking for sensitivities does not change settling
  std::vector<Vec3> known;    // the last equilibrium, and what it is the equilibrium of
  Controls known_controls;
  std::vector<Vec3> previous;  // and the one before; empty = none
  Controls previous_controls;
  std::vector<Vec3> ahead;  // where the tissue is expected some frames from now; empty = unknown
  Eigen::VectorXd scratch;
  double last_step_s = 0.0;  // that the solver has seen; 0 = settled without time
  double smallest_load = 0.0;
  double near_mm = 0.0;  // a frame this near to its end is done; 0: only forces tell
};

Simulator::Simulator(std::shared_ptr<const Anatomy> anatomy,
                     const TissueModel& tissue,
                     const SettleOptions& options)
    : impl_(std::make_unique<Impl>(std::move(anatomy), tissue, options)) {}
Simulator::~Simulator() = default;
Simulator::Simulator(Simulator&&) noexcept = default;
Simulator& Simulator::operator=(Simulator&&) noexcept = default;

const Anatomy& Simulator::anatomy() const { return *impl_->anatomy; }
const Lattice& Simulator::lattice() const { return impl_->energy.lattice(); }

FaceState Simulator::rest() const {
  FaceState state;
  state.positions_mm = impl_->energy.lattice().rest_mm;
  return state;
}

SettleReport Simulator::settle(const Controls& controls, FaceState& state) {
  Impl& impl = *impl_;
  assert(state.positions_mm.size() == impl.known.size());
  impl.check(controls);
  impl.enter_step(0.0);
  if (impl.choice) impl.choose_all(controls);
  const Controls from = impl.controls_of(state, controls);
  const bool from_heap = impl.is_heap(state);
  SettleReport report;
  const auto settle_region = [&] {
    const SettleReport part = impl.settle_moving(from, controls, from_heap, state.positions_mm);
    report = {part.converged,
              report.iterations + part.iterations,
              report.factorisations + part.factorisations,
              part.residual};
  };
  if (impl.options.still_mm == 0.0 || impl.choice) {
    settle_region();
  } else {
    impl.region.choose(
        controls.contraction, controls.jaw_rad, impl.options.still_mm, state, impl.solver);
    settle_region();
    // What was left out must be able to stay where it is.
    while (impl.region.grow(impl.options.still_mm, state, impl.solver)) settle_region();
  }
  if (impl.choice) {
    impl.choice->chooser.accept(state.positions_mm, 0.0, impl.solver);
    impl.choice->chooser.dismiss(state);
  }
  state.velocities_mm_per_s.clear();
  state.history.clear();
  impl.finish(controls, state, report);
  return report;
}

SettleReport Simulator::advance(const Controls& controls, double step_s, FaceState& state) {
  Impl& impl = *impl_;
  require(step_s > 0.0 && step_s <= 1.0,
          "time step: " + std::to_string(step_s) + " s, expected above 0, at most 1");
  if (impl.choice) return impl.advance_by_choice(controls, step_s, state);
  if (!impl.explicit_face && impl.energy.effects().memory().empty()) {
    const SettleReport report = settle(controls, state);
    state.time_s += step_s;
    return report;
  }
  // What swings or creeps is not where its controls are: all tissue takes part.
  impl.region.release(impl.solver);
  if (impl.explicit_face) return impl.advance_explicitly(controls, step_s, state);
  impl.check(controls);
  impl.enter_step(step_s);
  SettleReport report;
  impl.energy.begin_step(state, step_s);
  impl.carry(impl.controls_of(state, controls), controls, state.positions_mm);
  impl.step_to_minimum(step_s, state, report);
  impl.energy.end_step(state);
  state.time_s += step_s;
  impl.finish(controls, state, report);
  return report;
}

const std::vector<Effects::Part>& Simulator::effects() const {
  return impl_->energy.effects().parts();
}

std::vector<EffectUse> Simulator::effect_uses() const {
  if (impl_->choice) return impl_->choice->chooser.uses();
  return std::vector<EffectUse>(effects().size());
}

Sensitivity Simulator::surface_sensitivity(const Controls& controls, const FaceState& state) {
  Impl& impl = *impl_;
  assert(state.positions_mm.size() == impl.known.size());
  impl.check(controls);
  impl.energy.set_controls(controls.contraction, controls.jaw_rad);
  const double shift = impl.solver.factor_at(state.positions_mm, impl.sensitivity_factor);
  // H dx/dc = - d(grad E)/dc
  Eigen::MatrixXd motion = impl.energy.control_forces(state.positions_mm, impl.solver.hessian());
  impl.sensitivity_factor.solve(motion);
  return {motion.topRows(3 * impl.energy.lattice().num_vertices), shift > 0.0};
}

void embed_skin(const Anatomy& anatomy, const FaceState& state, std::vector<Vec3>& skin_mm) {
  const Embedding& embedding = anatomy.skin.embedding;
  const std::vector<Vec3>& rest = anatomy.skin.mesh.positions_mm;
  assert(embedding.begin.size() == rest.size() + 1);
  const std::size_t n = anatomy.surface.positions_mm.size();
  std::vector<Vec3> moved(n);
  for (std::size_t j = 0; j < n; ++j) {
    moved[j] = state.positions_mm[j] - anatomy.surface.positions_mm[j];
  }
  skin_mm.resize(rest.size());
  for (std::size_t v = 0; v < rest.size(); ++v) {
    Vec3 x = rest[v];
    for (int k = embedding.begin[v]; k < embedding.begin[v + 1]; ++k) {
      x += static_cast<double>(embedding.weight[k]) * moved[embedding.index[k]];
    }
    skin_mm[v] = x;
  }
}

}  // namespace zygoma
