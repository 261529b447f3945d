// The snake (paper, equations 5-8): a chain of nodes joined by springs and stiffened against
// bending that slides down an image potential.
//
//   gamma dx_i/dt = T_i - beta_i + f_i
//   T_i    = a_i e_i u_i - a_{i-1} e_{i-1} u_{i-1},   e_i = |x_{i+1} - x_i| - l_i
//   beta_i = b_{i+1} k_{i+1} - 2 b_i k_i + b_{i-1} k_{i-1},   k_i = x_{i+1} - 2 x_i + x_{i-1}
//   f_i    = -p grad P(x_i) + w_i (t_i - x_i)
//   dl_i/dt = v e_i, kept within a share of the length the chain was given
//
// The signs are those under which the internal force is minus the gradient of
//   E = 1/2 sum a_i e_i^2 + 1/2 sum b_i |k_i|^2
// (as printed, equations 5, 6 and 8 push a stretched spring's ends apart and climb out of ravines).
//
// With F(x) the whole force, both ways to step move the nodes by a multiple of it, so both come to
// rest in the same places:
//
//   implicit        (gamma/dt + K + W) d = F(x). K, of the springs' linear part and the bending,
//                   is pentadiagonal, symmetric and positive semi-definite; solved by a banded
//                   L D L^T. Without an image the energy never rises, whatever dt; anchors (W) of
//                   any strength are stable. Only the image force is explicit, tamed by a cap.
//   explicit, 1992  d = dt/gamma F(x), Euler's step. Stable for
//                     dt < 2 gamma / (4 a + 16 b + w + p L)
//                   (the largest eigenvalue of K of a closed chain with alternating nodes; w the
//                   strongest anchor, L the curvature of P under the nodes), so dt is split into
//                   equal parts within nine tenths of that.
//
// Ends are free (natural: no moment, no force), fixed, or joined to a closed chain, whose matrix is
// cyclic: the last two nodes are taken out as a border and the rest stays a band.
#pragma once

#include <string_view>
#include <vector>

#include "tracker/contour_set.h"
#include "tracker/cyclic_band.h"

namespace zygoma {

enum class SnakeStepping { kImplicit, kExplicit };
enum class SnakeEnds { kFree, kFixed, kClosed };

struct SnakeOptions {
  double tension = 0.02;        // a, >= 0; large: bunches to its rest lengths, ignores the image
  double rigidity = 0.05;       // b, >= 0; large: straight lines only
  double image_weight = 1.0;    // p, >= 0, of a potential normalised to about one
  double damping = 1.0;         // gamma, > 0; only its ratio to the others matters
  double step = 2.0;            // dt, > 0; large: the image force overshoots narrow ravines
  double viscosity = 0.0;       // v, [0, 1/dt]; how fast springs forget their length
  double min_length = 0.6;      // of the initial rest length; (0, 1]
  double max_length = 1.6;      // >= 1
  double step_cap_px = 1.0;     // of one node in one step; larger jumps over ravines
  double tolerance_px = 0.005;  // largest node move that still counts as moving
  int max_iterations = 60;      // of one relax()
  SnakeStepping stepping = SnakeStepping::kImplicit;
  SnakeEnds ends = SnakeEnds::kFree;
  // Explicit: take `step` whole; refused (InputError) where it is beyond the bound without an
  // image.
  bool whole_step = false;
};

// Largest stable step of the explicit mode, 2 gamma / (4 a + 16 b + w + p L).
double explicit_step_bound(const SnakeOptions& options,
                           double strongest_anchor = 0.0,
                           double image_curvature = 0.0);

enum class SnakeStop { kConverged, kOscillating, kIterationLimit, kNotFinite };
std::string_view to_string(SnakeStop stop);

struct SnakeReport {
  SnakeStop stop = SnakeStop::kIterationLimit;
  int iterations = 0;
  double last_move_px = 0.0;
};

// What the nodes feel of the picture: P and its gradient at node `i` in place x.
class ImageLandscape {
 public:
  virtual ~ImageLandscape() = default;
  virtual double potential(size_t node, const Point2& x) const = 0;
  virtual Point2 gradient(size_t node, const Point2& x) const = 0;
};

// A spring of rest length zero from a node to a place.
struct SoftAnchor {
  Point2 target = Point2::Zero();
  double weight = 0.0;  // zero: free
};

class Snake {
 public:
  // The rest lengths are those of the nodes given: at least three, five of a closed chain.
  Snake(std::vector<Point2> nodes, const SnakeOptions& options);

  const std::vector<Point2>& nodes() const { return nodes_; }
  // Moves the chain by hand; rest lengths stay.
  void set_nodes(std::vector<Point2> nodes);
  const std::vector<double>& rest_lengths() const { return rest_lengths_; }
  // One anchor per node, or none.
  void set_anchors(std::vector<SoftAnchor> anchors);

  double internal_energy() const;
  std::vector<Point2> internal_force() const;  // T_i - beta_i

  // One step of the equations above; the largest move of a node. `image` may be null.
  double advance(const ImageLandscape* image);
  // Steps until nothing moves. Never leaves non-finite nodes behind: it stops at the last good
  // ones.
  SnakeReport relax(const ImageLandscape* image);

 private:
  size_t num_springs() const { return rest_lengths_.size(); }
  size_t num_bends() const { return 2 * num_springs() - nodes_.size(); }  // bend i: i, i+1, i+2
  size_t next(size_t node) const { return node + 1 < nodes_.size() ? node + 1 : 0; }
  void factor();
  double strongest_anchor() const;
  double image_curvature(const ImageLandscape& image) const;
  int num_parts(const ImageLandscape* image) const;
  double advance_part(const ImageLandscape* image, int num_parts);
  std::vector<Point2> whole_force(const ImageLandscape* image) const;

  SnakeOptions options_;
  std::vector<Point2> nodes_;
  std::vector<double> rest_lengths_;
  std::vector<double> initial_lengths_;
  std::vector<SoftAnchor> anchors_;
  CyclicBand matrix_;  // gamma/dt + K + W of the implicit step
};

// The polyline's points at equal steps of its arc length, ends kept.
std::vector<Point2> resample(const std::vector<Point2>& line, int num_points);

}  // namespace zygoma
