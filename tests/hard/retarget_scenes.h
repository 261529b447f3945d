// A performer whose contractions are known and whose contours are exact: the curves of a lattice
// face in equilibrium, through a camera, with noise where asked for. The face that estimates may be
// the same or another.
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <vector>

#include "face/generic_head.h"
#include "face/quality.h"
#include "retarget/curve_probe.h"
#include "retarget/measure_response.h"
#include "retarget/retarget.h"

namespace zygoma::hard {

// A lattice face of few nodes with its response.
struct PerformingFace {
  std::shared_ptr<const Anatomy> anatomy;
  std::unique_ptr<Simulator> simulator;
  FaceResponse response;

  explicit PerformingFace(const Identity& identity = {}, double relative_residual = 1e-4) {
    HeadOptions head;
    TissueModel tissue;
    SettleOptions settle;
    face_quality("draft").apply(head, tissue, settle);
    head.albedo_size_px = 64;  // nobody looks at it
    settle.relative_residual = relative_residual;
    anatomy = std::make_shared<const Anatomy>(make_generic_head(identity, head));
    simulator = std::make_unique<Simulator>(anatomy, tissue, settle);
    response = measure_response(*simulator);
  }

  int control(const std::string& name) const {
    const auto at = std::find(response.muscles.begin(), response.muscles.end(), name);
    return static_cast<int>(at - response.muscles.begin());  // the jaw for any other name
  }
};

// The face that estimates: made once for all tests.
inline PerformingFace& usual_face() {
  static PerformingFace face;
  return face;
}

inline Identity other_identity() {
  Identity identity;
  identity.face_width = 1.05;
  identity.face_height = 0.97;
  identity.jaw_width = 1.06;
  identity.nose_length = 1.06;
  identity.lip_fullness = 1.1;
  identity.brow_height_mm = 1.5;
  identity.chin_length = 1.05;
  return identity;
}

inline constexpr double kRate_hz = 25.0;

struct Performance {
  std::vector<ContourSet> contours;
  std::vector<Eigen::VectorXd> truth;
};

using Script = std::function<void(double, Eigen::VectorXd&)>;
using CameraPath = std::function<HeadMotion(double)>;

inline HeadMotion still_camera(double) {
  HeadMotion camera;
  camera.a = 1.2;  // px per mm
  camera.shift = {320.0, 160.0};
  return camera;
}

// Smooth step of a movement that begins and ends at rest.
inline double rise_and_fall(double t, double start_s, double rise_s, double hold_s) {
  const auto step = [](double x) {
    x = std::clamp(x, 0.0, 1.0);
    return x * x * x * (10.0 - 15.0 * x + 6.0 * x * x);
  };
  return step((t - start_s) / rise_s) - step((t - start_s - rise_s - hold_s) / rise_s);
}

inline ContourSet contours_of(const NodeStack& mm,
                              const std::array<bool, kNumContours>& has,
                              const HeadMotion& camera,
                              int frame) {
  ContourSet set;
  set.frame_index = frame;
  set.time_s = frame / kRate_hz;
  for (int c = 0; c < kNumContours; ++c) {
    const auto index = static_cast<std::size_t>(c);
    Contour contour;
    contour.name = kFeatureSchema[index].name;
    for (int k = first_node(c); k <= last_node(c) && has[index]; ++k) {
      contour.points_px.push_back(camera * Point2(mm.col(k)));
    }
    contour.confidence = contour.points_px.empty() ? 0.0 : 1.0;
    set.contours.push_back(contour);
  }
  return set;
}

inline Performance perform(PerformingFace& face,
                           double duration_s,
                           const Script& script,
                           const CameraPath& camera = still_camera,
                           double noise_px = 0.0) {
  const CurveProbe probe(*face.anatomy, face.response.viewing_distance_mm);
  FaceState state = face.simulator->rest();
  std::mt19937 random(11);
  std::normal_distribution<double> normal(0.0, noise_px > 0.0 ? noise_px : 1.0);
  Performance performance;
  for (int t = 0; t < static_cast<int>(duration_s * kRate_hz); ++t) {
    Eigen::VectorXd controls = Eigen::VectorXd::Zero(face.response.num_controls());
    script(t / kRate_hz, controls);
    controls = controls.cwiseMax(0.0).cwiseMin(1.0);
    Controls told;
    told.contraction.assign(face.anatomy->muscles.size(), 0.0);
    for (int i = 0; i < face.response.num_muscles(); ++i) {
      const std::string& name = face.response.muscles[static_cast<std::size_t>(i)];
      told.contraction[static_cast<std::size_t>(face.anatomy->muscle_index(name))] = controls[i];
    }
    told.jaw_rad = controls[face.response.num_muscles()] * face.anatomy->jaw.full_rad;
    face.simulator->settle(told, state);
    ContourSet set =
        contours_of(probe.image(state), face.response.has_contour, camera(t / kRate_hz), t);
    for (Contour& contour : set.contours) {
      for (Point2& p : contour.points_px) {
        if (noise_px > 0.0) p += Point2(normal(random), normal(random));
      }
    }
    performance.contours.push_back(set);
    performance.truth.push_back(controls);
  }
  return performance;
}

inline Eigen::VectorXd controls_of(const Contractions& frame) {
  Eigen::VectorXd u(static_cast<Eigen::Index>(frame.value.size()) + 1);
  for (std::size_t i = 0; i < frame.value.size(); ++i) {
    u[static_cast<Eigen::Index>(i)] = frame.value[i];
  }
  u[u.size() - 1] = frame.jaw;
  return u;
}

inline double rms_error(const Performance& performance, const ContractionTrack& track) {
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t t = 0; t < performance.truth.size(); ++t) {
    const Eigen::VectorXd error = controls_of(track.frames[t]) - performance.truth[t];
    sum += error.squaredNorm();
    count += static_cast<double>(error.size());
  }
  return std::sqrt(sum / count);
}

// Over all muscles and frames of [begin, end).
inline double largest_value(const ContractionTrack& track, std::size_t begin, std::size_t end) {
  double largest = 0.0;
  for (std::size_t t = begin; t < end; ++t) {
    largest = std::max(largest, controls_of(track.frames[t]).maxCoeff());
  }
  return largest;
}

}  // namespace zygoma::hard
