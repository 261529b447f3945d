#include "face/furrows.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace zygoma {

Furrows::Furrows(const Skin& skin) : site_of_(skin.mesh.positions_mm.size(), -1) {
  if (skin.furrow_sites.empty()) return;
  const std::vector<Vec3>& at = skin.mesh.positions_mm;
  const std::vector<std::vector<int>> around = neighbors_by(skin.mesh.triangles, at.size());
  for (std::size_t v = 0; v < at.size(); ++v) {
    const FurrowSite& furrow = skin.furrow_sites[v];
    if (furrow.spacing_mm <= 0.0F) continue;
    // The smallest weights whose sum over the edges at rest gives the direction: least squares for
    // F a. The edges span a plane, hence the little that is added.
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const int u : around[v]) sum += (at[u] - at[v]) * (at[u] - at[v]).transpose();
    sum.diagonal().array() += 1e-6 * sum.trace();
    const Vec3 solved = sum.ldlt().solve(furrow.across.cast<double>());
    Site site{static_cast<int>(v), static_cast<int>(terms_.size()), 0, furrow.spacing_mm};
    Vec3 at_rest = Vec3::Zero();
    for (const int u : around[v]) {
      const double weight = solved.dot(at[u] - at[v]);
      at_rest += weight * (at[u] - at[v]);
      terms_.push_back({u, static_cast<float>(weight)});
    }
    site.last = static_cast<int>(terms_.size());
    // What of the direction lies out of the plane of the edges does not count as stretch.
    const auto scale = static_cast<float>(1.0 / std::max(1e-3, at_rest.norm()));
    for (int k = site.first; k < site.last; ++k) terms_[k].weight *= scale;
    site_of_[v] = static_cast<int>(sites_.size());
    sites_.push_back(site);
  }
}

void Furrows::amplitudes(const std::vector<Vec3>& skin_mm, std::vector<float>& amplitude_mm) const {
  constexpr float kBeforeBuckling = 0.03F;
  constexpr int kRounds = 3;
  std::vector<float> strain(sites_.size());
  for (std::size_t i = 0; i < sites_.size(); ++i) {
    const Site& site = sites_[i];
    Eigen::Vector3f stretched = Eigen::Vector3f::Zero();
    for (int k = site.first; k < site.last; ++k) {
      const Vec3 edge = skin_mm[terms_[k].neighbour] - skin_mm[site.vertex];
      stretched += terms_[k].weight * edge.cast<float>();
    }
    strain[i] = 1.0F - stretched.norm();
  }
  // A fold takes its length from both sides of its line.
  std::vector<float> mean(sites_.size());
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t i = 0; i < sites_.size(); ++i) {
      float sum = strain[i];
      float count = 1.0F;
      for (int k = sites_[i].first; k < sites_[i].last; ++k) {
        const int j = site_of_[terms_[k].neighbour];
        if (j < 0) continue;
        sum += strain[j];
        count += 1.0F;
      }
      mean[i] = sum / count;
    }
    strain.swap(mean);
  }
  amplitude_mm.assign(site_of_.size(), 0.0F);
  for (std::size_t i = 0; i < sites_.size(); ++i) {
    const float excess = std::max(0.0F, strain[i] - kBeforeBuckling);
    amplitude_mm[sites_[i].vertex] = sites_[i].spacing_mm / 3.14159265F * std::sqrt(excess);
  }
}

}  // namespace zygoma
