#include "face/furrows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "face/generic_head.h"
#include "face/simulator.h"

namespace zygoma {
namespace {

const std::shared_ptr<const Anatomy>& head() {
  static const auto anatomy = std::make_shared<const Anatomy>(
      make_generic_head({}, {.num_surface_vertices = 700, .albedo_size_px = 64}));
  return anatomy;
}

bool on_forehead(const Vec3& p) { return p.y() > 36.0 && p.y() < 58.0 && std::abs(p.x()) < 30.0; }

TEST(Furrows, AreNotThereAtRestNorWhereSkinIsStretched) {
  const Furrows furrows(head()->skin);
  ASSERT_FALSE(furrows.empty());
  std::vector<Vec3> skin = head()->skin.mesh.positions_mm;
  std::vector<float> amplitude;
  furrows.amplitudes(skin, amplitude);
  ASSERT_EQ(amplitude.size(), skin.size());
  EXPECT_EQ(*std::max_element(amplitude.begin(), amplitude.end()), 0.0F);
  for (Vec3& p : skin) p *= 1.2;
  furrows.amplitudes(skin, amplitude);
  EXPECT_EQ(*std::max_element(amplitude.begin(), amplitude.end()), 0.0F);
}

TEST(Furrows, AreAsDeepAsTheLengthTheyTakeUp) {
  const Furrows furrows(head()->skin);
  const std::vector<Vec3>& rest = head()->skin.mesh.positions_mm;
  std::vector<Vec3> skin = rest;
  for (Vec3& p : skin) p *= 0.8;  // strain 0.2 in every direction
  std::vector<float> amplitude;
  furrows.amplitudes(skin, amplitude);
  int sites = 0;
  for (std::size_t v = 0; v < skin.size(); ++v) {
    const FurrowSite& site = head()->skin.furrow_sites[v];
    const double expected = site.spacing_mm / M_PI * std::sqrt(0.2 - 0.03);
    EXPECT_NEAR(amplitude[v], expected, 1e-3) << rest[v].transpose();
    sites += site.spacing_mm > 0.0F ? 1 : 0;
  }
  EXPECT_GT(sites, 500);
}

TEST(Furrows, FormAcrossThePushNotAlongIt) {
  const Furrows furrows(head()->skin);
  const std::vector<Vec3>& rest = head()->skin.mesh.positions_mm;
  std::vector<Vec3> from_below = rest;
  std::vector<Vec3> from_aside = rest;
  for (Vec3& p : from_below) p.y() *= 0.8;
  for (Vec3& p : from_aside) p.x() *= 0.8;
  std::vector<float> below, aside;
  furrows.amplitudes(from_below, below);
  furrows.amplitudes(from_aside, aside);
  for (std::size_t v = 0; v < rest.size(); ++v) {
    if (!on_forehead(rest[v]) || head()->skin.furrow_sites[v].spacing_mm <= 0.0F) continue;
    EXPECT_GT(below[v], 0.5F) << rest[v].transpose();
    EXPECT_LT(aside[v], 0.4F * below[v]) << rest[v].transpose();
  }
}

TEST(Furrows, TheForeheadFoldsWhenItsMuscleRaisesTheBrows) {
  Simulator simulator(head());
  const Furrows furrows(head()->skin);
  Controls controls{std::vector<double>(head()->muscles.size(), 0.0), 0.0};
  for (std::size_t m = 0; m < head()->muscles.size(); ++m) {
    if (head()->muscles[m].name.starts_with("occipitofrontalis")) controls.contraction[m] = 0.9;
  }
  FaceState state = simulator.rest();
  ASSERT_TRUE(simulator.settle(controls, state).converged);
  std::vector<Vec3> skin;
  embed_skin(*head(), state, skin);
  std::vector<float> amplitude;
  furrows.amplitudes(skin, amplitude);
  double sum = 0.0;
  int count = 0;
  for (std::size_t v = 0; v < skin.size(); ++v) {
    const Vec3& p = head()->skin.mesh.positions_mm[v];
    if (!on_forehead(p) || head()->skin.furrow_sites[v].spacing_mm <= 0.0F) continue;
    sum += static_cast<double>(amplitude[v]);
    ++count;
  }
  EXPECT_GT(sum / count, 0.5) << "mm, mean over the forehead";
}

}  // namespace
}  // namespace zygoma
