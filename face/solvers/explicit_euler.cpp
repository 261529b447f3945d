#include "face/solvers/explicit_euler.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "src/base/check.h"

namespace zygoma {
namespace {

constexpr int kMostRestores = 40;

template <typename Four>
Four load(const float* p) {
  return *reinterpret_cast<const Four*>(p);
}
template <typename Four>
void store(float* p, Four v) {
  *reinterpret_cast<Four*>(p) = v;
}
template <typename Four>
float dot(Four a, Four b) {
  const Four c = a * b;
  return c[0] + c[1] + c[2];
}

// The fourth number of a gradient is nobody's.
template <typename Four>
Four without_fourth(Four v) {
  return v * Four{1.0F, 1.0F, 1.0F, 0.0F};
}

template <typename Entry>
Entry& entry_of(std::vector<Entry>& entries, int node) {
  for (Entry& known : entries) {
    if (known.node == node) return known;
  }
  Entry entry{};
  entry.node = node;
  entries.push_back(entry);
  return entries.back();
}

// Roots of 4 m - 2 gamma dt - K dt^2, and of the two conditions of the literal order.
double stable_step(double mass, double gamma, double stiffness, bool literal_order) {
  constexpr double kAny = std::numeric_limits<double>::infinity();
  if (stiffness <= 0.0) return gamma > 0.0 ? 2.0 * mass / gamma : kAny;
  if (literal_order) {
    return std::min(gamma / stiffness, gamma > 0.0 ? 2.0 * mass / gamma : kAny);
  }
  return (std::sqrt(gamma * gamma + 4.0 * mass * stiffness) - gamma) / stiffness;
}

}  // namespace

ExplicitEuler::ExplicitEuler(const std::vector<Spring>& springs,
                             const std::vector<Vec3>& rest_mm,
                             const ExplicitNodes& nodes,
                             const ExplicitOptions& options)
    : springs_(springs), options_(options), mass_(nodes.mass_kg), damping_(nodes.damping_kg_per_s) {
  const std::size_t n = rest_mm.size();
  require(n > 0 && mass_.size() == n && damping_.size() == n && nodes.fixed.size() == n,
          "explicit solver: mass, damping and fixed need one value per node");
  require(options_.safety > 0.0 && options_.safety <= 1.0,
          "explicit solver: safety " + std::to_string(options_.safety) + ", expected (0, 1]");
  require(options_.watch_every >= 1, "explicit solver: watch_every must be at least 1");
  for (const Vec3& x : rest_mm) centre_mm_ += x / static_cast<double>(n);
  std::vector<Vec3> around_centre = rest_mm;
  for (Vec3& x : around_centre) x -= centre_mm_;
  set_ = SpringSet<float>(springs_, around_centre);
  reset_nodes(around_centre, state_.nodes);
  state_.velocity.assign(n, Four{});
  energy_stiffness_.assign(n, 0.0);
  for (std::size_t k = 0; k < n; ++k) {
    require(std::isfinite(mass_[k]) && mass_[k] > 0.0,
            "explicit solver: mass of node " + std::to_string(k) + " is " +
                std::to_string(mass_[k]) + " kg, expected > 0");
    require(std::isfinite(damping_[k]) && damping_[k] >= 0.0,
            "explicit solver: damping of node " + std::to_string(k) + " is " +
                std::to_string(damping_[k]) + " kg/s, expected >= 0");
    const auto inverse = nodes.fixed[k] ? 0.0F : static_cast<float>(1.0 / mass_[k]);
    const auto rate = nodes.fixed[k] ? 0.0F : static_cast<float>(damping_[k] / mass_[k]);
    inertia_.push_back(Four{inverse, inverse, inverse, rate});
  }
  for (const Spring& spring : springs_) {
    energy_scale_ += spring.law.alpha * spring.rest_mm * spring.rest_mm;
  }
}

ExplicitEuler::Four ExplicitEuler::centred(const Vec3& x) const {
  const Eigen::Vector3f c = (x - centre_mm_).cast<float>();
  return Four{c.x(), c.y(), c.z(), 0.0F};
}

void ExplicitEuler::set_hold(int node, double stiffness, const Vec3& target_mm) {
  Hold& hold = entry_of(holds_, node);
  hold.target = centred(target_mm);
  hold.stiffness = static_cast<float>(stiffness);
}

void ExplicitEuler::set_outer_force(int node, const Vec3& force_mn) {
  const Eigen::Vector3f f = force_mn.cast<float>();
  entry_of(outer_, node).force = Four{f.x(), f.y(), f.z(), 0.0F};
}

void ExplicitEuler::set_energy(Energy energy, std::vector<double> stiffness_per_node) {
  require(stiffness_per_node.size() == mass_.size(),
          "explicit solver: the stiffness of an energy needs one value per node");
  energy_ = std::move(energy);
  energy_stiffness_ = std::move(stiffness_per_node);
}

void ExplicitEuler::place(int node, const Vec3& x_mm) {
  store(&state_.nodes[node].x, centred(x_mm));
}

void ExplicitEuler::set_velocity(int node, const Vec3& v_mm_per_s) {
  const Eigen::Vector3f v = v_mm_per_s.cast<float>();
  state_.velocity[node] = Four{v.x(), v.y(), v.z(), 0.0F};
}

std::vector<Vec3> ExplicitEuler::positions() const {
  std::vector<Vec3> x;
  x.reserve(state_.nodes.size());
  for (const LatticeNode<float>& node : state_.nodes) {
    x.push_back(Vec3(node.x, node.y, node.z) + centre_mm_);
  }
  return x;
}

std::vector<Vec3> ExplicitEuler::velocities() const {
  std::vector<Vec3> v;
  v.reserve(state_.velocity.size());
  for (const Four& four : state_.velocity) v.emplace_back(four[0], four[1], four[2]);
  return v;
}

// K of every node: beta of its springs, or what they can have near their present length.
std::vector<double> ExplicitEuler::node_stiffness(bool as_stretched_now) const {
  constexpr double kNear = 0.05;  // of the rest length
  std::vector<double> stiffness = energy_stiffness_;
  for (const Spring& spring : springs_) {
    double k = spring.law.alpha + spring.law.stiffening;
    if (as_stretched_now && spring.law.stiffening > 0.0) {
      const LatticeNode<float>& a = state_.nodes[spring.i];
      const LatticeNode<float>& b = state_.nodes[spring.j];
      const double length =
          std::sqrt(Vec3(b.x - a.x, b.y - a.y, b.z - a.z).squaredNorm() + spring.softening_mm2);
      const double begins = spring.law.critical_mm - spring.law.band_mm;
      if (length - spring.rest_mm < begins - kNear * spring.rest_mm) k = spring.law.alpha;
    }
    stiffness[spring.i] += 2.0 * k;
    stiffness[spring.j] += 2.0 * k;
  }
  for (const Hold& hold : holds_) stiffness[hold.node] += static_cast<double>(hold.stiffness);
  return stiffness;
}

double ExplicitEuler::bound_s() const {
  const std::vector<double> stiffness = node_stiffness(false);
  double bound = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < stiffness.size(); ++k) {
    if (inertia_[k][0] == 0.0F) continue;
    bound =
        std::min(bound, stable_step(mass_[k], damping_[k], stiffness[k], options_.literal_order));
  }
  return bound;
}

// Adds the gradient of everything in the nodes; energy of springs (only if wanted) and of the
// further energy.
double ExplicitEuler::add_forces(bool want_energy) {
  LatticeNode<float>* nodes = state_.nodes.data();
  double energy = 0.0;
  if (want_energy) {
    energy = static_cast<double>(set_.energy_and_gradient(nodes));
  } else {
    set_.add_gradient(nodes);
  }
  for (const Hold& hold : holds_) {
    float* node = &nodes[hold.node].x;
    store(node + 4, load<Four>(node + 4) + hold.stiffness * (load<Four>(node) - hold.target));
  }
  for (const OuterForce& outer : outer_) {
    float* node = &nodes[outer.node].x;
    store(node + 4, load<Four>(node + 4) - outer.force);
  }
  if (!energy_) return energy;
  x_mm_ = positions();
  energy_gradient_.assign(x_mm_.size(), Vec3::Zero());
  energy += energy_(x_mm_, energy_gradient_);
  for (std::size_t k = 0; k < x_mm_.size(); ++k) {
    nodes[k].dx += static_cast<float>(energy_gradient_[k].x());
    nodes[k].dy += static_cast<float>(energy_gradient_[k].y());
    nodes[k].dz += static_cast<float>(energy_gradient_[k].z());
  }
  return energy;
}

// One step with the gradient that stands in the nodes, which is cleared for the next.
void ExplicitEuler::integrate(float dt) {
  const bool literal = options_.literal_order;
  LatticeNode<float>* nodes = state_.nodes.data();
  Four* velocity = state_.velocity.data();
  const Four* inertia = inertia_.data();
  const std::size_t n = state_.nodes.size();
  for (std::size_t k = 0; k < n; ++k) {
    float* node = &nodes[k].x;
    const Four gradient = without_fourth(load<Four>(node + 4));
    const Four old_v = velocity[k];
    const Four v = old_v - (dt * inertia[k][3]) * old_v - (dt * inertia[k]) * gradient;
    store(node, load<Four>(node) + dt * (literal ? old_v : v));
    store(node + 4, Four{});
    velocity[k] = v;
  }
}

ExplicitEuler::Energies ExplicitEuler::energies(double spring_energy) const {
  Energies e{0.0, spring_energy, 0.0};
  for (const Hold& hold : holds_) {
    const Four off = load<Four>(&state_.nodes[hold.node].x) - hold.target;
    e.potential += 0.5 * static_cast<double>(hold.stiffness * dot(off, off));
  }
  for (const OuterForce& outer : outer_) {
    const Four moved = load<Four>(&state_.nodes[outer.node].x) - outer.from;
    e.outer_work += static_cast<double>(dot(outer.force, moved));
  }
  for (std::size_t k = 0; k < state_.velocity.size(); ++k) {
    if (inertia_[k][0] == 0.0F) continue;
    e.kinetic += 0.5 * mass_[k] * static_cast<double>(dot(state_.velocity[k], state_.velocity[k]));
  }
  return e;
}

// A stable step close to the bound lets the energy ripple five-fold, hence the generous factor.
bool ExplicitEuler::Energies::sane(const Energies& start, double least) const {
  constexpr double kFactor = 20.0;
  const double now = kinetic + potential;
  const double accounted = start.kinetic + start.potential + std::abs(outer_work);
  return std::isfinite(now) && std::isfinite(outer_work) && now <= kFactor * accounted + least;
}

ExplicitReport ExplicitEuler::advance(double time_s) {
  require(std::isfinite(time_s) && time_s >= 0.0,
          "explicit solver: time " + std::to_string(time_s) + " s, expected >= 0");
  ExplicitReport report;
  report.bound_s = bound_s();
  double limit = options_.dt_s > 0.0 ? options_.dt_s : options_.safety * report.bound_s;
  require(limit > 0.0, "explicit solver: x by the old v is never stable without damping");
  require(limit <= report.bound_s || options_.force_dt,
          "explicit solver: dt " + std::to_string(limit) + " s is beyond the stable bound of " +
              std::to_string(report.bound_s) + " s");
  if (dt_limit_s_ > 0.0) limit = std::min(limit, dt_limit_s_);

  for (OuterForce& outer : outer_) outer.from = load<Four>(&state_.nodes[outer.node].x);
  const double least = 1e-9 * energy_scale_;
  State good;
  double good_left = time_s;
  int good_steps = 0;
  Energies start;
  double left = time_s;
  bool first = true;
  for (int since_watch = 0;;) {
    const bool watch = since_watch == 0 || left <= 0.0;
    const double spring_energy = add_forces(watch);
    if (watch) {
      const Energies now = energies(spring_energy);
      if (first) {
        start = now;
        require(std::isfinite(now.kinetic + now.potential),
                "explicit solver: positions or forces are not finite at the start");
        first = false;
      }
      if (now.sane(start, least)) {
        report.energy = now.kinetic + now.potential;
        if (left <= 0.0) break;
        good = state_;
        good_left = left;
        good_steps = report.substeps;
      } else {
        state_ = good;
        left = good_left;
        report.substeps = good_steps;
        ++report.restores;
        report.gave_up = report.restores >= kMostRestores;
        if (report.gave_up) break;
        limit *= 0.5;
        dt_limit_s_ = limit;
      }
      since_watch = options_.watch_every;
    }
    const double steps = std::max(1.0, std::ceil(left / limit * (1.0 - 1e-12)));
    report.dt_s = left / steps;
    integrate(static_cast<float>(report.dt_s));
    left = steps > 1.0 ? left - report.dt_s : 0.0;
    ++report.substeps;
    --since_watch;
  }
  report.residual_mn = residual_mn();
  for (const Four& v : state_.velocity) {
    report.largest_speed_mm_per_s =
        std::max(report.largest_speed_mm_per_s, std::sqrt(static_cast<double>(dot(v, v))));
  }
  clear_gradient();
  return report;
}

// A step of one unit of time with masses for which it is just stable, damped for the slowest mode:
// the frequency along the motion is estimated from how the forces changed over the last step.
struct ExplicitEuler::Relaxation {
  std::vector<Four> mass, inverse_mass;  // 0 if fixed
  std::vector<Four> last_force;
  float damping = 0.0F;
  double stiffness_along = 0.0;  // v . change of gradient
  double mass_along = 0.0;       // v . M v
  double residual_mn = 0.0;      // where the step began
};

void ExplicitEuler::relax_step(Relaxation& r) {
  const float keep = (2.0F - r.damping) / (2.0F + r.damping);
  const float push = 2.0F / (2.0F + r.damping);
  Four stiffness{}, mass{};
  float largest = 0.0F;
  for (std::size_t k = 0; k < state_.nodes.size(); ++k) {
    float* node = &state_.nodes[k].x;
    const Four f = -load<Four>(node + 4);
    const Four v = state_.velocity[k];
    const Four im = r.inverse_mass[k];
    stiffness += v * (r.last_force[k] - f);
    mass += r.mass[k] * v * v;
    const float norm2 = dot(f, f);
    if (!(norm2 <= largest) && im[0] != 0.0F) largest = norm2;  // also what is not a number
    r.last_force[k] = f;
    const Four new_v = keep * v + push * (im * f);
    state_.velocity[k] = new_v;
    store(node, load<Four>(node) + new_v);
    store(node + 4, Four{});
  }
  r.stiffness_along = static_cast<double>(stiffness[0] + stiffness[1] + stiffness[2]);
  r.mass_along = static_cast<double>(mass[0] + mass[1] + mass[2]);
  r.residual_mn = std::sqrt(static_cast<double>(largest));
}

void ExplicitEuler::renew_masses(double heavier, Relaxation& r) const {
  const std::vector<double> stiffness = node_stiffness(true);
  r.mass.assign(stiffness.size(), Four{});
  r.inverse_mass.assign(stiffness.size(), Four{});
  for (std::size_t k = 0; k < stiffness.size(); ++k) {
    if (inertia_[k][0] == 0.0F || stiffness[k] <= 0.0) continue;
    const double safe = 4.0 * options_.safety * options_.safety;
    const auto mass = static_cast<float>(heavier * stiffness[k] / safe);
    r.mass[k] = Four{mass, mass, mass, 0.0F};
    r.inverse_mass[k] = Four{1.0F / mass, 1.0F / mass, 1.0F / mass, 0.0F};
  }
}

void ExplicitEuler::clear_gradient() {
  for (LatticeNode<float>& node : state_.nodes) store(&node.dx, Four{});
}

double ExplicitEuler::residual_mn() const {
  float largest = 0.0F;
  for (std::size_t k = 0; k < state_.nodes.size(); ++k) {
    if (inertia_[k][0] == 0.0F) continue;
    const Four f = load<Four>(&state_.nodes[k].dx);
    const float norm2 = dot(f, f);
    if (!(norm2 <= largest)) largest = norm2;  // also what is not a number
  }
  return std::sqrt(static_cast<double>(largest));
}

RelaxReport ExplicitEuler::relax(double tolerance_mn, int max_steps) {
  constexpr int kRenewMasses = 100;  // steps between two looks at how stretched the springs are
  constexpr double kExplosion = 1e3;
  RelaxReport report;
  Relaxation r;
  r.last_force.resize(state_.nodes.size());
  std::fill(state_.velocity.begin(), state_.velocity.end(), Four{});
  State good = state_;
  double good_residual = std::numeric_limits<double>::infinity();
  double heavier = 1.0;
  while (report.steps < max_steps) {
    if (report.steps % kRenewMasses == 0) {
      renew_masses(heavier, r);
      if (report.steps > 0 && r.residual_mn < good_residual) {
        good = state_;
        good_residual = r.residual_mn;
      }
    }
    add_forces(false);
    relax_step(r);
    ++report.steps;
    if (report.steps == 1) {
      require(std::isfinite(r.residual_mn),
              "explicit solver: positions or forces are not finite at the start");
      good_residual = r.residual_mn;
    }
    // Written so that it catches what is not a number, too.
    if (!(r.residual_mn <= kExplosion * good_residual)) {
      state_ = good;
      if (++report.restores >= kMostRestores) break;
      heavier *= 4.0;  // as halving dt
      r.damping = 0.0F;
      renew_masses(heavier, r);
      continue;
    }
    if (r.mass_along > 0.0 && r.stiffness_along > 0.0) {
      const double frequency = std::sqrt(r.stiffness_along / r.mass_along);
      r.damping = static_cast<float>(std::min(2.0 * frequency, 1.9));
    }
    if (r.residual_mn > tolerance_mn) continue;
    // So it was before the step; is it still?
    add_forces(false);
    const bool settled = residual_mn() <= tolerance_mn;
    clear_gradient();
    if (settled) break;
  }
  add_forces(false);
  report.residual_mn = residual_mn();
  if (!std::isfinite(report.residual_mn)) {
    state_ = good;
    report.residual_mn = good_residual;
  }
  report.converged = report.residual_mn <= tolerance_mn;
  clear_gradient();
  std::fill(state_.velocity.begin(), state_.velocity.end(), Four{});
  return report;
}

}  // namespace zygoma
