// Our muscles against shapes of a face scanned and modelled by others: ../shared/meshes/ict_face
// (USC ICT), or the same below the folder that the environment variable ZYGOMA_SHARED names. Their
// neutral is laid on our head by landmarks; then the way every point of their face goes under an
// expression is compared with the way ours goes there under the matching action unit.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <sstream>

#include "face/facs.h"
#include "face/generic_head.h"
#include "tests/support/shared_folder.h"

namespace zygoma {
namespace {

constexpr int kNumFaceVertices = 9409;  // theirs: the front of the face comes first

std::string mesh_path(const std::string& name) {
  return shared_folder() + "/meshes/ict_face/" + name + ".obj";
}

std::vector<Vec3> read_positions(const std::string& path) {
  std::ifstream file(path);
  std::vector<Vec3> positions;
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("v ")) continue;
    std::istringstream cells(line.substr(2));
    Vec3 p;
    cells >> p.x() >> p.y() >> p.z();
    positions.push_back(p);
  }
  return positions;
}

int nearest(const std::vector<Vec3>& points, const Vec3& to) {
  int best = 0;
  for (std::size_t v = 1; v < points.size(); ++v) {
    if ((points[v] - to).squaredNorm() < (points[best] - to).squaredNorm()) {
      best = static_cast<int>(v);
    }
  }
  return best;
}

// A vertex of theirs (the 68 landmarks of its description) and the place of the same on our head.
struct Landmark {
  int theirs;
  Vec3 ours_mm;
};

// The end of the slit of an eye, as the last vertex of a lid on that side.
Vec3 eye_corner(const Anatomy& head, double side, double outwards) {
  Vec3 best(0.0, 0.0, 0.0);
  double furthest = -std::numeric_limits<double>::infinity();
  for (std::size_t v = 0; v < head.region.size(); ++v) {
    const Vec3& p = head.surface.positions_mm[v];
    const bool lid = head.region[v] == Region::kUpperLid || head.region[v] == Region::kLowerLid;
    if (!lid || side * p.x() < 0.0 || outwards * side * p.x() < furthest) continue;
    furthest = outwards * side * p.x();
    best = p;
  }
  return best;
}

std::vector<Landmark> landmarks(const Anatomy& head) {
  const auto at = [&](const std::string& name, double share) -> Vec3 {
    for (const NamedCurve& curve : head.curves) {
      if (curve.name != name) continue;
      const double last = static_cast<double>(curve.skin_vertices.size() - 1);
      return head.skin.mesh.positions_mm[curve.skin_vertices[std::lround(share * last)]];
    }
    throw std::runtime_error("no curve " + name);
  };
  return {{5708, at("upper_lip", 0.0)},
          {6213, at("upper_lip", 1.0)},
          {0, at("upper_lip", 0.5)},
          {5518, at("lower_lip", 0.5)},
          {1140, at("nose_tip", 0.0)},
          {3360, at("nose_tip", 1.0)},
          {1147, at("nose_tip", 0.5)},
          {966, at("chin_boss", 0.5)},
          {1401, at("brow_right", 0.0)},
          {3615, at("brow_left", 0.0)},
          {1914, at("brow_right", 0.5)},
          {4114, at("brow_left", 0.5)},
          {268, at("brow_right", 1.0)},
          {2509, at("brow_left", 1.0)},
          {1507, eye_corner(head, -1, 1)},
          {3721, eye_corner(head, 1, 1)},
          {1528, eye_corner(head, -1, -1)},
          {3742, eye_corner(head, 1, -1)}};
}

// Their face on ours: a similarity, then the landmarks' residuals spread by inverse distance.
struct Laid {
  Eigen::Matrix4d ours_from_theirs;
  std::vector<Vec3> positions_mm;
};

Laid lay_on(const Anatomy& head, const std::vector<Vec3>& theirs) {
  const std::vector<Landmark> pairs = landmarks(head);
  Eigen::Matrix3Xd from(3, pairs.size());
  Eigen::Matrix3Xd to(3, pairs.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    from.col(k) = theirs[pairs[k].theirs];
    to.col(k) = pairs[k].ours_mm;
  }
  Laid laid{Eigen::umeyama(from, to), {}};
  const Eigen::Affine3d similarity(laid.ours_from_theirs);
  for (int v = 0; v < kNumFaceVertices; ++v) {
    const Vec3 p = similarity * theirs[v];
    Vec3 shift = Vec3::Zero();
    double total = 0.0;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const Vec3 anchor = similarity * Vec3(from.col(k));
      const double w = 1.0 / (1e-6 + std::pow((p - anchor).norm(), 3.0));
      shift += w * (to.col(k) - anchor);
      total += w;
    }
    laid.positions_mm.push_back(p + shift / total);
  }
  return laid;
}

struct Agreement {
  double mean_cosine = 0.0;  // over the points of theirs that move
  double peak_off_mm = 0.0;  // between the points that move most
  double their_peak_mm = 0.0;
  double our_peak_mm = 0.0;
  int num_moving = 0;
};

// Points count as moving from a quarter of the peak on; where ours stand still the cosine is 0.
Agreement compare(const Laid& laid,
                  const std::vector<Vec3>& neutral,
                  const std::vector<Vec3>& shape,
                  const Anatomy& head,
                  const std::vector<Vec3>& skin_mm) {
  constexpr double kMoving = 0.25;
  constexpr double kStill_mm = 0.05;
  const Eigen::Matrix3d linear = laid.ours_from_theirs.topLeftCorner<3, 3>();
  const std::vector<Vec3>& rest_mm = head.skin.mesh.positions_mm;
  std::vector<Vec3> theirs;
  Agreement result;
  int their_peak = 0;
  for (int v = 0; v < kNumFaceVertices; ++v) {
    theirs.push_back(linear * (shape[v] - neutral[v]));
    if (theirs[v].norm() > theirs[their_peak].norm()) their_peak = v;
  }
  int our_peak = 0;
  for (std::size_t v = 0; v < rest_mm.size(); ++v) {
    const double moved = (skin_mm[v] - rest_mm[v]).norm();
    if (moved > (skin_mm[our_peak] - rest_mm[our_peak]).norm()) our_peak = static_cast<int>(v);
  }
  result.their_peak_mm = theirs[their_peak].norm();
  result.our_peak_mm = (skin_mm[our_peak] - rest_mm[our_peak]).norm();
  result.peak_off_mm = (laid.positions_mm[their_peak] - rest_mm[our_peak]).norm();
  for (int v = 0; v < kNumFaceVertices; ++v) {
    if (theirs[v].norm() < kMoving * result.their_peak_mm) continue;
    ++result.num_moving;
    const int ours = nearest(rest_mm, laid.positions_mm[v]);
    const Vec3 moved = skin_mm[ours] - rest_mm[ours];
    if (moved.norm() < kStill_mm) continue;
    result.mean_cosine += moved.normalized().dot(theirs[v].normalized());
  }
  result.mean_cosine /= result.num_moving;
  return result;
}

struct Match {
  const char* shape;  // theirs
  const char* units;  // ours
};

class IctFace : public testing::TestWithParam<Match> {};

TEST_P(IctFace, MovesLikeOurs) {
  const std::string neutral_path = mesh_path("generic_neutral_mesh");
  const std::string shape_path = mesh_path(GetParam().shape);
  if (!std::filesystem::exists(neutral_path) || !std::filesystem::exists(shape_path)) {
    GTEST_SKIP() << shape_path << " is not there; ZYGOMA_SHARED names the folder with meshes/";
  }
  const std::vector<Vec3> neutral = read_positions(neutral_path);
  const std::vector<Vec3> shape = read_positions(shape_path);
  ASSERT_EQ(shape.size(), neutral.size());
  ASSERT_GT(neutral.size(), static_cast<std::size_t>(kNumFaceVertices));

  const auto head = std::make_shared<const Anatomy>(make_generic_head({}, {300, 2, 64}));
  Simulator simulator(head);
  FaceState state = simulator.rest();
  ASSERT_TRUE(simulator.settle(controls_of(pose_of(GetParam().units), *head), state).converged);
  std::vector<Vec3> skin_mm;
  embed_skin(*head, state, skin_mm);
  const Agreement found = compare(lay_on(*head, neutral), neutral, shape, *head, skin_mm);
  EXPECT_GE(found.mean_cosine, 0.75);
  EXPECT_LE(found.peak_off_mm, 15.0);
  EXPECT_GT(found.num_moving, 100);
  std::cout << GetParam().shape << " against " << GetParam().units << ": mean cosine "
            << found.mean_cosine << " over " << found.num_moving << " points, peaks "
            << found.peak_off_mm << " mm apart (theirs " << found.their_peak_mm << " mm, ours "
            << found.our_peak_mm << ")\n";
}

INSTANTIATE_TEST_SUITE_P(Shapes,
                         IctFace,
                         testing::Values(Match{"mouthSmile_L", "L12"},
                                         Match{"mouthSmile_R", "R12"},
                                         Match{"browInnerUp_L", "L1"},
                                         Match{"noseSneer_L", "L9"},
                                         Match{"mouthFrown_L", "L15"},
                                         Match{"jawOpen", "27"}),
                         [](const auto& instance) { return std::string(instance.param.shape); });

}  // namespace
}  // namespace zygoma
