// The explicit and the equilibrium solver against the soft bodies of Bullet on a lattice that
// Bullet can represent: all springs linear with k = 1, all masses 1, no volume terms.
//
// A spherical cap (radius 0.5, as far across as 1) with jittered triangles carries four node layers
// at depths 0, 0.015, 0.035 and 0.05; the lowest is fixed. Fascia nodes within 0.2 of the middle
// are displaced by 0.05 cos(pi/2 r/0.2) and held there, as a muscle does; all other nodes are free
// and have to find their equilibrium. The reference is the same equilibrium in double, followed in
// ten parts of the displacement and converged to 1e-11.
//
// Measured: CPU time until the largest distance of a node from the reference falls below 1e-2,
// 1e-3 and 1e-4 of the size for good; looking for that moment is not part of the time. Every solver
// runs over a grid of its settings, and its best one at each error, if any, is measured again, all
// of them taking turns; medians.
//
//   bullet_bench [RESULT.csv [LABEL]]
#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <random>
#include <string>

#include "face/energy.h"
#include "face/solvers/equilibrium.h"
#include "face/solvers/explicit_euler.h"
#include "face/solvers/lattice_kernels.h"
#include "tests/bench/bench_tools.h"

namespace zygoma {
namespace {

using bench::format;
using bench::median;

constexpr int kRepeats = 5;
constexpr int kMostSteps = 2000;
constexpr int kPatience = 300;  // steps without coming closer
constexpr double kErrors[] = {1e-2, 1e-3, 1e-4};

struct Problem {
  int num_surface = 0;
  std::vector<Vec3> rest;
  std::vector<Vec3> start;  // rest, with the muscle's nodes displaced
  std::vector<char> fixed;  // bone and the muscle's nodes
  std::vector<Spring> springs;
  std::vector<Triangle> triangles;  // of the surface
  std::vector<Vec3> reference;
};

// Rings of 6 r vertices around the middle, r = 0 ... rings.
std::vector<Triangle> ring_triangles(int rings) {
  const auto at = [](int ring, int k) {
    return ring == 0 ? 0 : 1 + 3 * ring * (ring - 1) + (k + 6 * ring) % (6 * ring);
  };
  std::vector<Triangle> triangles;
  for (int ring = 1; ring <= rings; ++ring) {
    for (int side = 0; side < 6; ++side) {
      for (int k = 0; k < ring; ++k) {
        const int outer = side * ring + k;
        const int inner = side * (ring - 1) + k;
        triangles.push_back({at(ring, outer), at(ring, outer + 1), at(ring - 1, inner)});
        if (k < ring - 1) {
          triangles.push_back({at(ring - 1, inner), at(ring, outer + 1), at(ring - 1, inner + 1)});
        }
      }
    }
  }
  return triangles;
}

Problem make_problem(int rings) {
  constexpr double kRadius = 0.5;
  constexpr double kDepth[] = {0.0, 0.015, 0.035, 0.05};
  constexpr double kMuscleReach = 0.2;
  constexpr double kPull = 0.05;
  Problem problem;
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> jitter(-0.2, 0.2);
  std::vector<std::array<double, 2>> polar{{0.0, 0.0}};  // arc from the middle, angle
  const double step = 0.5 / rings;
  for (int ring = 1; ring <= rings; ++ring) {
    for (int k = 0; k < 6 * ring; ++k) {
      const double arc = step * (ring + (ring < rings ? jitter(engine) : 0.0));
      polar.push_back({arc, 2.0 * std::numbers::pi * (k + jitter(engine)) / (6.0 * ring)});
    }
  }
  const int n = static_cast<int>(polar.size());
  problem.num_surface = n;
  for (const double depth : kDepth) {
    for (const auto& [arc, angle] : polar) {
      const double bend = arc / kRadius;
      problem.rest.push_back((kRadius - depth) * Vec3(std::sin(bend) * std::cos(angle),
                                                      std::sin(bend) * std::sin(angle),
                                                      std::cos(bend)));
    }
  }
  std::map<std::array<int, 2>, int> known;
  const auto connect = [&](int a, int b) {
    if (std::min(a, b) >= 3 * n) return;  // both in the bone
    if (!known.try_emplace({std::min(a, b), std::max(a, b)}, 0).second) return;
    Spring spring{a, b, 0.0, (problem.rest[a] - problem.rest[b]).norm(), {}};
    spring.law.alpha = 1.0;
    problem.springs.push_back(spring);
  };
  std::map<std::array<int, 2>, int> edges;
  problem.triangles = ring_triangles(rings);
  for (const Triangle& t : problem.triangles) {
    for (int e = 0; e < 3; ++e) {
      edges.try_emplace({std::min(t[e], t[(e + 1) % 3]), std::max(t[e], t[(e + 1) % 3])}, 0);
    }
  }
  for (const auto& [edge, unused] : edges) {
    const auto [a, b] = edge;
    for (int layer = 0; layer < 3; ++layer) {
      connect(layer * n + a, layer * n + b);
      connect(layer * n + a, (layer + 1) * n + b);
      if (layer == 0) connect(b, n + a);  // both diagonals in the dermis
    }
  }
  for (int v = 0; v < n; ++v) {
    for (int layer = 0; layer < 3; ++layer) connect(layer * n + v, (layer + 1) * n + v);
  }
  problem.start = problem.rest;
  problem.fixed.assign(problem.rest.size(), 0);
  for (int v = 0; v < n; ++v) {
    problem.fixed[3 * n + v] = 1;
    if (polar[v][0] >= kMuscleReach) continue;
    const int node = 2 * n + v;
    problem.fixed[node] = 1;
    const Vec3 normal = problem.rest[node].normalized();
    Vec3 along = Vec3::UnitX() - normal.x() * normal;
    along.normalize();
    problem.start[node] +=
        kPull * std::cos(0.5 * std::numbers::pi * polar[v][0] / kMuscleReach) * along;
  }
  return problem;
}

// Heavy ball in double, in ten parts of the displacement.
void find_reference(Problem& problem) {
  constexpr double kTolerance = 1e-11;
  const SpringSet<double> springs(problem.springs, problem.rest);
  std::vector<double> stiffness(problem.rest.size(), 0.0);
  for (const Spring& spring : problem.springs) {
    stiffness[spring.i] += 2.0 * spring.law.alpha;
    stiffness[spring.j] += 2.0 * spring.law.alpha;
  }
  std::vector<Vec3> x = problem.rest;
  std::vector<LatticeNode<double>> nodes;
  for (int part = 1; part <= 10; ++part) {
    for (std::size_t k = 0; k < x.size(); ++k) {
      if (problem.fixed[k]) {
        x[k] = problem.rest[k] + 0.1 * part * (problem.start[k] - problem.rest[k]);
      }
    }
    std::vector<Vec3> velocity(x.size(), Vec3::Zero());
    for (double residual = 1.0; residual > kTolerance;) {
      reset_nodes(x, nodes);
      springs.add_gradient(nodes.data());
      residual = 0.0;
      for (std::size_t k = 0; k < x.size(); ++k) {
        if (problem.fixed[k]) continue;
        const Vec3 g(nodes[k].dx, nodes[k].dy, nodes[k].dz);
        residual = std::max(residual, g.norm());
        velocity[k] = 0.95 * velocity[k] - (1.5 / stiffness[k]) * g;
        x[k] += velocity[k];
      }
    }
  }
  problem.reference = x;
}

// Something that can be started anew, stepped, and asked where it is.
class Contender {
 public:
  virtual ~Contender() = default;
  virtual void restart() = 0;
  virtual void step() = 0;
  virtual std::vector<Vec3> positions() const = 0;
};

// Error against CPU time, by the step.
struct Trace {
  std::vector<double> ms, error;

  // Time after which the error stays below; negative if never.
  double ms_to(double limit) const {
    if (error.empty() || error.back() > limit) return -1.0;
    std::size_t k = error.size();
    while (k > 0 && error[k - 1] <= limit) --k;
    return ms[k];
  }
};

double error_of(const std::vector<Vec3>& x, const Problem& problem) {
  double most = 0.0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double off = (x[k] - problem.reference[k]).norm();
    if (!(off <= most)) most = off;
  }
  return most;
}

double now_ms() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

Trace follow(Contender& contender, const Problem& problem, double budget_ms) {
  Trace trace;
  contender.restart();
  double ms = 0.0;
  double least = 1e9;
  int least_at = 0;
  for (int step = 0; step < kMostSteps && ms < budget_ms; ++step) {
    const double begin = now_ms();
    contender.step();
    ms += now_ms() - begin;
    trace.ms.push_back(ms);
    trace.error.push_back(error_of(contender.positions(), problem));
    if (!(trace.error.back() < 1e3)) break;
    if (trace.error.back() < 0.99 * least) {
      least = trace.error.back();
      least_at = step;
    }
    if (step - least_at > kPatience) break;
    // Well below the last error of interest, for a while.
    const std::size_t done = trace.error.size();
    if (done > 20 && *std::max_element(trace.error.end() - 20, trace.error.end()) <
                         0.3 * kErrors[std::size(kErrors) - 1]) {
      break;
    }
  }
  return trace;
}

// Runs of growing length, each from the start: the solver tunes itself on the way, so a run cannot
// be looked into without changing it.
Trace follow_relaxation(const Problem& problem, double safety) {
  ExplicitOptions options;
  options.safety = safety;
  const std::size_t n = problem.rest.size();
  ExplicitEuler solver(problem.springs,
                       problem.rest,
                       {std::vector<double>(n, 1.0), std::vector<double>(n, 0.0), problem.fixed},
                       options);
  Trace trace;
  for (int iterations = 2; iterations < 600; iterations += std::max(1, iterations / 30)) {
    for (std::size_t k = 0; k < n; ++k) solver.place(static_cast<int>(k), problem.start[k]);
    const double begin = now_ms();
    solver.relax(0.0, iterations);
    trace.ms.push_back(now_ms() - begin);
    trace.error.push_back(error_of(solver.positions(), problem));
  }
  return trace;
}

// The same nodes and springs as a face without muscles, its free nodes first.
struct AsFace {
  Anatomy anatomy;
  Lattice lattice;
  std::vector<int> node_of;  // of the problem's nodes
};

AsFace as_face(const Problem& problem) {
  AsFace face;
  const int n = problem.num_surface;
  const std::size_t num_nodes = problem.rest.size();
  face.node_of.resize(num_nodes);
  face.anatomy.surface = {{problem.rest.begin(), problem.rest.begin() + n}, problem.triangles};
  face.anatomy.tissue_depth_mm.assign(n, 0.05);
  face.anatomy.mandible_weight.assign(n, 0.0);
  face.anatomy.region.assign(n, Region::kFace);
  Lattice& lattice = face.lattice;
  lattice.num_vertices = n;
  lattice.columns.resize(n);
  lattice.neighbors.resize(n);
  lattice.mass_kg.assign(num_nodes, 1.0);
  for (const int fixed : {0, 1}) {
    for (std::size_t k = 0; k < num_nodes; ++k) {
      if (problem.fixed[k] != fixed) continue;
      const int column = static_cast<int>(k) % n;
      face.node_of[k] = static_cast<int>(lattice.rest_mm.size());
      lattice.rest_mm.push_back(problem.rest[k]);
      lattice.column_of.push_back(column);
      if (fixed == 0) lattice.columns[column].nodes.push_back(face.node_of[k]);
    }
    if (fixed == 0) lattice.num_free_nodes = static_cast<int>(lattice.rest_mm.size());
  }
  for (int c = 0; c < n; ++c) {
    lattice.columns[c].vertex = {c, c, c};
    lattice.columns[c].on_bone = false;
  }
  for (Spring spring : problem.springs) {
    spring.i = face.node_of[spring.i];
    spring.j = face.node_of[spring.j];
    if (std::min(spring.i, spring.j) >= lattice.num_free_nodes) continue;
    lattice.springs.push_back(spring);
    if (std::max(spring.i, spring.j) < n) {
      lattice.neighbors[spring.i].push_back(spring.j);
      lattice.neighbors[spring.j].push_back(spring.i);
    }
  }
  return face;
}

// As above: runs of growing length. Finding the order of elimination is set-up, as Bullet's bodies
// are; every factor counts.
Trace follow_equilibrium(const Problem& problem) {
  const AsFace face = as_face(problem);
  const FaceEnergy energy(face.anatomy, face.lattice, {}, {});
  EquilibriumSolver solver(energy);
  Trace trace;
  for (int iterations = 1; iterations < 60; ++iterations) {
    std::vector<Vec3> x(problem.start.size());
    for (std::size_t k = 0; k < x.size(); ++k) x[face.node_of[k]] = problem.start[k];
    solver.forget();
    const double begin = now_ms();
    solver.solve(x, {1e-12, 1e-9, iterations});
    trace.ms.push_back(now_ms() - begin);
    std::vector<Vec3> y(x.size());
    for (std::size_t k = 0; k < y.size(); ++k) y[k] = x[face.node_of[k]];
    trace.error.push_back(error_of(y, problem));
  }
  return trace;
}

btVector3 to_bullet(const Vec3& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

// Else the next step would take them from wherever the nodes are by then.
void keep_rest_lengths(btSoftBody& body) {
  body.updateConstants();
  body.m_bUpdateRtCst = false;
}

// A soft body with the problem's nodes and links, rest lengths taken at rest.
std::unique_ptr<btSoftBody> make_body(const Problem& problem, btSoftBodyWorldInfo& info) {
  std::vector<btVector3> x;
  for (const Vec3& p : problem.rest) x.push_back(to_bullet(p));
  const std::vector<btScalar> mass(x.size(), btScalar(1));
  auto body =
      std::make_unique<btSoftBody>(&info, static_cast<int>(x.size()), x.data(), mass.data());
  for (const Spring& spring : problem.springs) body->appendLink(spring.i, spring.j, nullptr, false);
  body->m_cfg.collisions = 0;
  body->m_cfg.kDF = 0;
  body->setSelfCollision(false);
  body->setActivationState(DISABLE_DEACTIVATION);
  body->m_sleepingThreshold = 0;
  for (std::size_t k = 0; k < problem.fixed.size(); ++k) {
    if (problem.fixed[k]) body->setMass(static_cast<int>(k), 0);
  }
  keep_rest_lengths(*body);
  return body;
}

void restart_body(const Problem& problem, btSoftBody& body) {
  for (int k = 0; k < body.m_nodes.size(); ++k) {
    btSoftBody::Node& node = body.m_nodes[k];
    node.m_x = node.m_q = to_bullet(problem.start[k]);
    node.m_v = node.m_vn = node.m_f = btVector3(0, 0, 0);
  }
}

std::vector<Vec3> body_positions(const btSoftBody& body) {
  std::vector<Vec3> x;
  for (int k = 0; k < body.m_nodes.size(); ++k) {
    const btVector3& p = body.m_nodes[k].m_x;
    x.emplace_back(p.x(), p.y(), p.z());
  }
  return x;
}

struct BulletBase {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
};

// Positions are solved link by link; the stiffness of a link is a share in [0, 1].
class BulletClassic : public Contender {
 public:
  BulletClassic(const Problem& problem, int iterations, double link_share, double damping)
      : problem_(problem),
        world_(&base_.dispatcher, &base_.broadphase, &solver_, &base_.configuration) {
    world_.setGravity(btVector3(0, 0, 0));
    world_.getWorldInfo().m_gravity = btVector3(0, 0, 0);
    body_ = make_body(problem, world_.getWorldInfo());
    body_->m_materials[0]->m_kLST = static_cast<btScalar>(link_share);
    body_->m_cfg.piterations = iterations;
    body_->m_cfg.kDP = static_cast<btScalar>(damping);
    keep_rest_lengths(*body_);
    world_.addSoftBody(body_.get());
  }
  ~BulletClassic() override { world_.removeSoftBody(body_.get()); }
  void restart() override { restart_body(problem_, *body_); }
  void step() override { world_.stepSimulation(btScalar(1.0 / 60.0), 0); }
  std::vector<Vec3> positions() const override { return body_positions(*body_); }

 private:
  const Problem& problem_;
  BulletBase base_;
  btSequentialImpulseConstraintSolver solver_;
  btSoftRigidDynamicsWorld world_;
  std::unique_ptr<btSoftBody> body_;
};

// Springs with a stiffness, integrated explicitly or implicitly with conjugate gradients.
class BulletDeformable : public Contender {
 public:
  BulletDeformable(const Problem& problem, bool implicit, double dt, double damping)
      : problem_(problem),
        dt_(static_cast<btScalar>(dt)),
        force_(1, static_cast<btScalar>(damping)) {
    constraint_solver_.setDeformableSolver(&solver_);
    world_ = std::make_unique<btDeformableMultiBodyDynamicsWorld>(
        &base_.dispatcher, &base_.broadphase, &constraint_solver_, &base_.configuration, &solver_);
    world_->setGravity(btVector3(0, 0, 0));
    world_->getWorldInfo().m_gravity = btVector3(0, 0, 0);
    world_->setImplicit(implicit);
    world_->setLineSearch(false);
    world_->setUseProjection(true);  // else held nodes are Lagrange multipliers, and nothing moves
    body_ = make_body(problem, world_->getWorldInfo());
    body_->m_cfg.kDP = 0;
    world_->addSoftBody(body_.get());
    world_->addForce(body_.get(), &force_);
  }
  ~BulletDeformable() override {
    world_->removeForce(body_.get(), &force_);
    world_->removeSoftBody(body_.get());
  }
  void restart() override { restart_body(problem_, *body_); }
  void step() override { world_->stepSimulation(dt_, 1, dt_); }
  std::vector<Vec3> positions() const override { return body_positions(*body_); }

 private:
  const Problem& problem_;
  btScalar dt_;
  BulletBase base_;
  btDeformableBodySolver solver_;
  btDeformableMultiBodyConstraintSolver constraint_solver_;
  std::unique_ptr<btDeformableMultiBodyDynamicsWorld> world_;
  std::unique_ptr<btSoftBody> body_;
  btDeformableMassSpringForce force_;
};

struct Setting {
  std::string solver;
  std::string name;
  std::function<Trace(double budget_ms)> run;
};

std::vector<Setting> bullet_settings(const Problem& problem) {
  std::vector<Setting> settings;
  for (const int iterations : {1, 10}) {
    for (const double share : {0.1, 0.3, 1.0}) {
      for (const double damping : {0.1, 0.3}) {
        settings.push_back({"bullet classic",
                            format("piterations %d kLST %g kDP %g", iterations, share, damping),
                            [=, &problem](double budget) {
                              BulletClassic contender(problem, iterations, share, damping);
                              return follow(contender, problem, budget);
                            }});
      }
    }
  }
  for (const bool implicit : {true, false}) {
    for (const double dt : implicit ? std::vector<double>{1.0, 2.0, 4.0, 8.0, 16.0}
                                    : std::vector<double>{0.4, 0.8, 1.6}) {
      for (const double damping : {0.1, 1.0, 3.0, 10.0}) {
        settings.push_back({implicit ? "bullet implicit" : "bullet explicit",
                            format("dt %g damping %g", dt, damping),
                            [=, &problem](double budget) {
                              BulletDeformable contender(problem, implicit, dt, damping);
                              return follow(contender, problem, budget);
                            }});
      }
    }
  }
  return settings;
}

std::vector<Setting> our_settings(const Problem& problem) {
  std::vector<Setting> settings;
  for (const double safety : {0.7, 0.9, 1.0}) {
    settings.push_back({"zygoma explicit", format("safety %g", safety), [=, &problem](double) {
                          return follow_relaxation(problem, safety);
                        }});
  }
  settings.push_back({"zygoma equilibrium", "Newton and L-BFGS", [&problem](double) {
                        return follow_equilibrium(problem);
                      }});
  return settings;
}

void compare(const Problem& problem, double budget_ms, bench::Table& table) {
  std::vector<Setting> settings = our_settings(problem);
  for (Setting& setting : bullet_settings(problem)) settings.push_back(std::move(setting));
  // The best setting of each solver at each error, and the least error it came to at all.
  struct Best {
    int setting = -1;
    double ms = 0.0;
  };
  std::map<std::string, std::array<Best, std::size(kErrors)>> best;
  std::map<std::string, double> least;
  for (std::size_t s = 0; s < settings.size(); ++s) {
    auto& of_solver = best[settings[s].solver];
    // A setting far slower than the best so far need not be followed to its end.
    const Best& finest = of_solver[std::size(kErrors) - 1];
    const Trace trace =
        settings[s].run(finest.setting < 0 ? budget_ms : std::min(budget_ms, 3.0 * finest.ms));
    for (std::size_t e = 0; e < std::size(kErrors); ++e) {
      const double ms = trace.ms_to(kErrors[e]);
      if (ms < 0.0) continue;
      if (of_solver[e].setting < 0 || ms < of_solver[e].ms)
        of_solver[e] = {static_cast<int>(s), ms};
    }
    const double last = trace.error.back();
    auto [at, fresh] = least.try_emplace(settings[s].solver, last);
    if (!fresh) at->second = std::min(at->second, last);
  }
  for (std::size_t e = 0; e < std::size(kErrors); ++e) {
    std::map<std::string, std::vector<double>> ms;
    for (int repeat = 0; repeat < kRepeats; ++repeat) {
      for (auto& [solver, of_solver] : best) {
        if (of_solver[e].setting < 0) continue;
        const double t = settings[of_solver[e].setting].run(budget_ms).ms_to(kErrors[e]);
        if (t >= 0.0) ms[solver].push_back(t);
      }
    }
    double ours = 0.0;  // the better of the two
    for (const char* solver : {"zygoma explicit", "zygoma equilibrium"}) {
      if (ms[solver].empty()) continue;
      const double t = median(ms[solver]);
      ours = ours > 0.0 ? std::min(ours, t) : t;
    }
    for (const auto& [solver, of_solver] : best) {
      const std::string head = format(
          "%d,%zu,%g,%s", problem.num_surface, problem.springs.size(), kErrors[e], solver.c_str());
      if (of_solver[e].setting < 0 || ms[solver].empty()) {
        table.line(head + format(",,never,,%.1e", least[solver]));
        continue;
      }
      const double t = median(ms[solver]);
      table.line(head + format(",%s,%.3f,%.1f,%.1e",
                               settings[of_solver[e].setting].name.c_str(),
                               t,
                               ours > 0.0 ? t / ours : 0.0,
                               least[solver]));
    }
  }
}

int run(const std::string& csv, const std::string& label) {
  bench::Table table(csv,
                     "bullet_bench; Bullet " + std::to_string(BT_BULLET_VERSION) +
                         "; best of all settings, medians of " + std::to_string(kRepeats) +
                         " alternating repeats, CPU time, one thread; " + label,
                     "surface_nodes,springs,error,solver,setting,ms,times_zygoma,least_error");
  for (const int rings : {12, 25}) {
    Problem problem = make_problem(rings);
    find_reference(problem);
    compare(problem, rings == 12 ? 1500.0 : 4000.0, table);
  }
  return 0;
}

}  // namespace
}  // namespace zygoma

int main(int argc, char** argv) {
  return zygoma::run(argc > 1 ? argv[1] : "", argc > 2 ? argv[2] : "");
}
