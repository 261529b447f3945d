// How close the default head comes to other people's: its shape parameters are fitted, after a
// similarity that puts landmarks on landmarks, to heads that are not part of the project. The
// folder that holds them is ../shared, or named by the environment variable ZYGOMA_SHARED.
//
// Measured is the distance from the face of the model (a mask from forehead to chin, without eyes,
// nostrils and the slit of the mouth) to the nearest point of the other head, in millimetres of the
// model. Gauss and Newton: closest points are held for one step, whose residuals are the distances
// to the planes they lie in.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>
#include <string>

#include "face/generic_head.h"
#include "face/head_mesh.h"
#include "face/head_shape.h"
#include "tests/support/shape_parameters.h"
#include "tests/support/shared_folder.h"

namespace zygoma {
namespace {

// Eyes (outer right, inner right, inner left, outer left), corners of the mouth (right, left), tip
// of the nose, chin.
constexpr int kNumLandmarks = 8;
using Landmarks = std::array<Vec3, kNumLandmarks>;

struct Scan {
  std::string file;
  int num_vertices;  // of the face at the start of the file; 0 = all
  // Vertices of the landmarks, or where they are.
  std::array<int, kNumLandmarks> at_vertex;
  std::vector<Vec3> at;
  double largest_rms_mm;
};

struct OtherHead {
  SurfaceMesh mesh;
  std::vector<std::vector<int>> triangles_of;
  std::vector<bool> on_border;
};

OtherHead read_head(const std::string& path, int num_vertices) {
  OtherHead head;
  std::ifstream file(path);
  std::string line;
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (key == "v") {
      Vec3 p;
      words >> p.x() >> p.y() >> p.z();
      head.mesh.positions_mm.push_back(p);
    } else if (key == "f") {
      std::vector<int> corners;
      for (std::string word; words >> word;) corners.push_back(std::stoi(word) - 1);
      const bool left_out =
          num_vertices > 0 &&
          std::any_of(corners.begin(), corners.end(), [&](int v) { return v >= num_vertices; });
      for (std::size_t k = 2; k < corners.size() && !left_out; ++k) {
        head.mesh.triangles.push_back({corners[0], corners[k - 1], corners[k]});
      }
    }
  }
  head.triangles_of.resize(head.mesh.positions_mm.size());
  std::map<std::pair<int, int>, int> edges;
  for (std::size_t t = 0; t < head.mesh.triangles.size(); ++t) {
    const Triangle& corners = head.mesh.triangles[t];
    for (int k = 0; k < 3; ++k) {
      head.triangles_of[corners[k]].push_back(static_cast<int>(t));
      ++edges[std::minmax(corners[k], corners[(k + 1) % 3])];
    }
  }
  head.on_border.assign(head.mesh.positions_mm.size(), false);
  for (const auto& [edge, count] : edges) {
    if (count == 1) head.on_border[edge.first] = head.on_border[edge.second] = true;
  }
  return head;
}

struct Nearest {
  Vec3 point{0.0, 0.0, 0.0};
  Vec3 normal{0.0, 0.0, 1.0};
  double squared = std::numeric_limits<double>::infinity();
  bool at_border = false;
};

Vec3 nearest_in_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto on_edge = [&](const Vec3& from, const Vec3& to) -> Vec3 {
    const Vec3 along = to - from;
    const double t = std::clamp((p - from).dot(along) / along.squaredNorm(), 0.0, 1.0);
    return from + t * along;
  };
  Eigen::Matrix<double, 3, 2> edges;
  edges << b - a, c - a;
  const Eigen::Vector2d uv = (edges.transpose() * edges).ldlt().solve(edges.transpose() * (p - a));
  if (uv.minCoeff() >= 0.0 && uv.sum() <= 1.0) return a + edges * uv;
  const std::array<Vec3, 3> candidates{on_edge(a, b), on_edge(b, c), on_edge(c, a)};
  return *std::min_element(candidates.begin(), candidates.end(), [&](const Vec3& q, const Vec3& r) {
    return (q - p).squaredNorm() < (r - p).squaredNorm();
  });
}

// In the triangles around the nearest few vertices.
Nearest nearest_on(const OtherHead& head, const Vec3& p) {
  constexpr std::size_t kFew = 4;
  std::array<std::pair<double, int>, kFew> few;
  few.fill({std::numeric_limits<double>::infinity(), -1});
  for (std::size_t v = 0; v < head.mesh.positions_mm.size(); ++v) {
    const double d = (head.mesh.positions_mm[v] - p).squaredNorm();
    if (d >= few.back().first || head.triangles_of[v].empty()) continue;
    few.back() = {d, static_cast<int>(v)};
    std::sort(few.begin(), few.end());
  }
  Nearest best;
  for (const auto& [distance, v] : few) {
    if (v < 0) continue;
    for (const int t : head.triangles_of[v]) {
      const Triangle& corner = head.mesh.triangles[t];
      const Vec3& a = head.mesh.positions_mm[corner[0]];
      const Vec3& b = head.mesh.positions_mm[corner[1]];
      const Vec3& c = head.mesh.positions_mm[corner[2]];
      const Vec3 q = nearest_in_triangle(p, a, b, c);
      if ((q - p).squaredNorm() >= best.squared) continue;
      const Vec3 normal = (b - a).cross(c - a);
      if (normal.squaredNorm() <= 0.0) continue;
      best = {q, normal.normalized(), (q - p).squaredNorm(), head.on_border[few.front().second]};
    }
  }
  return best;
}

struct Similarity {
  double scale = 1.0;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vec3 shift{0.0, 0.0, 0.0};
  Vec3 operator()(const Vec3& p) const { return scale * (rotation * p) + shift; }
};

Similarity other_from_model(const Landmarks& model, const Landmarks& other) {
  Eigen::Matrix<double, 3, kNumLandmarks> from, to;
  for (int i = 0; i < kNumLandmarks; ++i) {
    from.col(i) = model[i];
    to.col(i) = other[i];
  }
  const Eigen::Matrix4d m = Eigen::umeyama(from, to, true);
  Similarity s;
  s.scale = std::cbrt(m.topLeftCorner<3, 3>().determinant());
  s.rotation = m.topLeftCorner<3, 3>() / s.scale;
  s.shift = m.topRightCorner<3, 1>();
  return s;
}

using test_support::shape_parameters;
using test_support::ShapeParameter;

std::vector<DomainPoint> face_mask() {
  const HeadShape shape(Identity{});
  std::vector<DomainPoint> mask;
  for (const DomainPoint& p : mesh_domain(shape, 1500).points) {
    const Vec2 front = shape.front_from_domain(p.at_mm);
    const double x = std::abs(p.at_mm.x());
    if (p.rim != Rim::kNone || x > 66.0 || front.y() > 60.0 || front.y() < -103.0) continue;
    if (std::hypot((front.x() - 31.0) / 19.0, (front.y() - 1.0) / 12.0) < 1.0) continue;
    if (std::hypot((front.x() - 6.6) / 6.0, (front.y() + 45.4) / 4.0) < 1.0) continue;
    if (front.x() < 27.0 && std::abs(front.y() + 69.0) < 2.5) continue;
    mask.push_back(p);
  }
  return mask;
}

Landmarks model_landmarks(const HeadShape& shape) {
  const auto at = [&](double x, double y) {
    DomainPoint point{shape.domain_from_front({std::abs(x), y})};
    if (x < 0.0) point.at_mm.x() = -point.at_mm.x();
    return shape.position(point);
  };
  return {at(-44.6, -1.2),
          at(-17.4, -3.4),
          at(17.4, -3.4),
          at(44.6, -1.2),
          at(-25.4, -70.4),
          at(25.4, -70.4),
          at(0.0, -38.0),
          at(0.0, -100.0)};
}

Landmarks other_landmarks(const Scan& scan, const OtherHead& head) {
  Landmarks landmarks;
  for (int i = 0; i < kNumLandmarks; ++i) {
    if (scan.at.empty()) {
      landmarks[i] = head.mesh.positions_mm[scan.at_vertex[i]];
      continue;
    }
    landmarks[i] = nearest_on(head, scan.at[i]).point;
  }
  return landmarks;
}

std::vector<Vec3> positions(const std::vector<DomainPoint>& mask, const Identity& identity) {
  const HeadShape shape(identity);
  std::vector<Vec3> at;
  at.reserve(mask.size());
  for (const DomainPoint& p : mask) at.push_back(shape.position(p));
  return at;
}

struct Fit {
  Identity identity;
  Similarity similarity;
  double rms_mm = 0.0;
  std::size_t measured = 0;
};

double rms_mm(const OtherHead& head, const std::vector<Vec3>& at, Fit& fit) {
  double sum = 0.0;
  fit.measured = 0;
  for (const Vec3& p : at) {
    const Nearest near = nearest_on(head, fit.similarity(p));
    if (near.at_border) continue;  // beyond what was scanned
    sum += near.squared / (fit.similarity.scale * fit.similarity.scale);
    ++fit.measured;
  }
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, fit.measured)));
}

// One step: similarity (scale, rotation, shift) and shape together.
void improve(const OtherHead& head, const std::vector<DomainPoint>& mask, Fit& fit) {
  const int num_shape = static_cast<int>(shape_parameters().size());
  const int n = 7 + num_shape;
  const std::vector<Vec3> at = positions(mask, fit.identity);
  std::vector<std::vector<Vec3>> moved;
  constexpr double kStep = 0.01;
  for (const ShapeParameter& p : shape_parameters()) {
    Identity other = fit.identity;
    const double sign = other.*p.value + kStep > p.high ? -1.0 : 1.0;
    other.*p.value += sign * kStep;
    moved.push_back(positions(mask, other));
    for (std::size_t i = 0; i < at.size(); ++i) {
      moved.back()[i] = at[i] + sign / kStep * (moved.back()[i] - at[i]) - at[i];
    }
  }
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
  const Similarity& s = fit.similarity;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const Vec3 q = s(at[i]);
    const Nearest near = nearest_on(head, q);
    if (near.at_border) continue;
    Eigen::VectorXd row(n);
    row[0] = near.normal.dot(q - s.shift) / s.scale;
    row.segment<3>(1) = (q - s.shift).cross(near.normal) / s.scale;
    row.segment<3>(4) = near.normal;
    for (int k = 0; k < num_shape; ++k) {
      row[7 + k] = near.normal.dot(s.rotation * moved[k][i]);
    }
    const double residual = near.normal.dot(q - near.point) / s.scale;
    const double weight = 1.0 / (1.0 + std::pow(residual / 6.0, 2.0));
    normal += weight * row * row.transpose();
    right -= weight * residual * row;
  }
  // Shape stays near the ordinary where the surface does not say.
  for (int k = 0; k < num_shape; ++k) {
    const ShapeParameter& p = shape_parameters()[k];
    const double loose = 1.0 / std::pow(0.25 * (p.high - p.low), 2.0);
    const Identity usual;
    normal(7 + k, 7 + k) += loose;
    right[7 + k] -= loose * (fit.identity.*p.value - usual.*p.value);
  }
  normal.diagonal().array() += 1e-9 * normal.trace();
  const Eigen::VectorXd step = normal.ldlt().solve(right);
  fit.similarity.scale *= std::exp(step[0]);
  const Vec3 turn = step.segment<3>(1);
  if (turn.norm() > 0.0) {
    fit.similarity.rotation =
        Eigen::AngleAxisd(turn.norm(), turn.normalized()) * fit.similarity.rotation;
  }
  fit.similarity.shift += s.scale * step.segment<3>(4);
  for (int k = 0; k < num_shape; ++k) {
    const ShapeParameter& p = shape_parameters()[k];
    double& value = fit.identity.*p.value;
    value = std::clamp(value + step[7 + k], p.low, p.high);
  }
}

Fit fit_to(const Scan& scan, const OtherHead& head) {
  static const std::vector<DomainPoint> mask = face_mask();
  Fit fit;
  fit.similarity =
      other_from_model(model_landmarks(HeadShape(fit.identity)), other_landmarks(scan, head));
  for (int round = 0; round < 12; ++round) improve(head, mask, fit);
  fit.rms_mm = rms_mm(head, positions(mask, fit.identity), fit);
  EXPECT_GT(fit.measured, mask.size() * 8 / 10);
  return fit;
}

const std::vector<Scan>& scans() {
  static const std::vector<Scan> all{{"ict_face/generic_neutral_mesh.obj",
                                      9409,
                                      {1507, 1518, 3756, 3721, 5708, 6200, 1140, 966},
                                      {},
                                      1.0},
                                     {"lee_perry_smith/LeePerrySmith.obj",
                                      0,
                                      {},
                                      {{-1.06, 1.685, 1.3},
                                       {-0.43, 1.72, 1.4},
                                       {0.19, 1.70, 1.4},
                                       {0.83, 1.63, 1.3},
                                       {-0.50, 0.41, 1.6},
                                       {0.36, 0.445, 1.6},
                                       {-0.10, 1.09, 2.2},
                                       {-0.17, -0.61, 1.7}},
                                      2.0},
                                     {"makehuman/base.obj",
                                      13380,
                                      {},
                                      {{-0.5, 7.3, 1.1},
                                       {-0.2, 7.3, 1.2},
                                       {0.2, 7.3, 1.2},
                                       {0.5, 7.3, 1.1},
                                       {-0.25, 6.6, 1.3},
                                       {0.25, 6.6, 1.3},
                                       {0.0, 6.95, 1.7},
                                       {0.0, 6.25, 1.4}},
                                      3.5},
                                     {"mediapipe_canonical/canonical_face_model.obj",
                                      0,
                                      {33, 133, 362, 263, 61, 291, 1, 152},
                                      {},
                                      1.5},
                                     {"stereo_scan/james.obj",
                                      0,
                                      {},
                                      {{-60.1, 10.2, 1.2},
                                       {-31.7, 11.4, 3.5},
                                       {5.1, 8.0, 0.5},
                                       {34.4, 8.9, -10.5},
                                       {-39.0, -62.2, 1.7},
                                       {13.4, -62.8, -2.7},
                                       {-8.7, -30.7, 38.3},
                                       {-15.9, -114.4, -13.6}},
                                      2.0}};
  return all;
}

void PrintTo(const Scan& scan, std::ostream* out) { *out << scan.file; }

class HeadFit : public testing::TestWithParam<Scan> {};

TEST_P(HeadFit, ComesWithinMillimetresOfThisHead) {
  const std::string path = shared_folder() + "/meshes/" + GetParam().file;
  if (!std::filesystem::exists(path)) {
    GTEST_SKIP() << GetParam().file << " is not there; ZYGOMA_SHARED names the folder";
  }
  const OtherHead head = read_head(path, GetParam().num_vertices);
  const Fit fit = fit_to(GetParam(), head);
  RecordProperty("rms_mm", std::to_string(fit.rms_mm));
  std::printf("%s: %.2f mm over %zu points;", GetParam().file.c_str(), fit.rms_mm, fit.measured);
  for (const ShapeParameter& p : shape_parameters()) std::printf(" %.3g", fit.identity.*p.value);
  std::printf("\n");
  EXPECT_LT(fit.rms_mm, GetParam().largest_rms_mm);
  EXPECT_NO_THROW(fit.identity.check());
}

INSTANTIATE_TEST_SUITE_P(Scans, HeadFit, testing::ValuesIn(scans()), [](const auto& scan) {
  const std::string& file = scan.param.file;
  return file.substr(0, file.find('/'));
});

}  // namespace
}  // namespace zygoma
