#include "face/head_skin.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace zygoma {
namespace {

Embedding compressed(const std::vector<std::map<int, double>>& rows) {
  Embedding embedding;
  embedding.begin.push_back(0);
  for (const auto& row : rows) {
    double sum = 0.0;
    for (const auto& [v, w] : row) sum += w;
    for (const auto& [v, w] : row) {
      embedding.index.push_back(v);
      embedding.weight.push_back(static_cast<float>(w / sum));
    }
    embedding.begin.push_back(static_cast<int>(embedding.index.size()));
  }
  return embedding;
}

// Points of a curve about `step` apart, in the domain.
std::vector<Vec2> resampled(const std::vector<Vec2>& line, double step) {
  std::vector<double> length(line.size(), 0.0);
  for (std::size_t i = 1; i < line.size(); ++i) {
    length[i] = length[i - 1] + (line[i] - line[i - 1]).norm();
  }
  const int steps = std::max(2, static_cast<int>(std::lround(length.back() / step)));
  std::vector<Vec2> result;
  std::size_t i = 1;
  for (int k = 0; k <= steps; ++k) {
    const double want = length.back() * k / steps;
    while (i + 1 < line.size() && length[i] < want) ++i;
    const double t = (want - length[i - 1]) / (length[i] - length[i - 1]);
    result.push_back(line[i - 1] + std::min(1.0, t) * (line[i] - line[i - 1]));
  }
  return result;
}

class CurveLayer {
 public:
  CurveLayer(const HeadShape& shape, DomainMesh& fine)
      : shape_(shape), fine_(fine), used_(fine.points.size(), false) {
    nearest_edge_.assign(fine.points.size(), std::numeric_limits<double>::max());
    for (const Triangle& t : fine.triangles) {
      for (int k = 0; k < 3; ++k) {
        const double d = (fine.points[t[k]].at_mm - fine.points[t[(k + 1) % 3]].at_mm).norm();
        nearest_edge_[t[k]] = std::min(nearest_edge_[t[k]], d);
        nearest_edge_[t[(k + 1) % 3]] = std::min(nearest_edge_[t[(k + 1) % 3]], d);
      }
    }
  }

  // Chain on the subject's left (X >= 0) along a curve in the frontal picture.
  std::vector<int> lay_front(const std::vector<Vec2>& front) {
    FunctionlessLine line;
    for (std::size_t i = 0; i + 1 < front.size(); ++i) {
      for (int k = 0; k < 8; ++k) {
        line.push_back(shape_.domain_from_front(front[i] + (front[i + 1] - front[i]) * (k / 8.0)));
      }
    }
    line.push_back(shape_.domain_from_front(front.back()));
    if (front.front().x() == 0.0) line.front().x() = 0.0;
    return lay(line);
  }

  std::vector<int> lay(const std::vector<Vec2>& line) {
    std::vector<int> chain;
    for (const Vec2& want : resampled(line, 2.2)) {
      const int v = nearest(want, want.x() == 0.0);
      if (v < 0 || std::find(chain.begin(), chain.end(), v) != chain.end()) continue;
      chain.push_back(v);
      pull(v, want);
    }
    return chain;
  }

  // The vertices of the left upper lid's margin from the inner to the outer corner.
  std::vector<int> upper_lid() const {
    std::vector<int> margin;
    for (std::size_t v = 0; v < fine_.points.size(); ++v) {
      const DomainPoint& p = fine_.points[v];
      if (p.rim != Rim::kEye || p.inward > 0.0 || p.at_mm.x() <= 0.0) continue;
      const double above = std::abs(p.at_mm.y() - shape_.eye_rim(p.at_mm.x(), +1));
      const double below = std::abs(p.at_mm.y() - shape_.eye_rim(p.at_mm.x(), -1));
      if (above <= below) margin.push_back(static_cast<int>(v));
    }
    std::sort(margin.begin(), margin.end(), [&](int a, int b) {
      return fine_.points[a].at_mm.x() < fine_.points[b].at_mm.x();
    });
    return margin;
  }

  int mouth_corner() const {
    int best = 0;
    double furthest = 0.0;
    for (std::size_t v = 0; v < fine_.points.size(); ++v) {
      const DomainPoint& p = fine_.points[v];
      if (p.rim != Rim::kMouth || p.inward > 0.0 || p.at_mm.x() <= furthest) continue;
      furthest = p.at_mm.x();
      best = static_cast<int>(v);
    }
    return best;
  }

 private:
  using FunctionlessLine = std::vector<Vec2>;

  int nearest(const Vec2& want, bool on_midline) const {
    int best = -1;
    double smallest = std::numeric_limits<double>::max();
    for (std::size_t v = 0; v < fine_.points.size(); ++v) {
      const DomainPoint& p = fine_.points[v];
      if (p.rim != Rim::kNone || p.at_mm.x() < 0.0) continue;
      if (on_midline != (p.at_mm.x() == 0.0)) continue;
      const double d = (p.at_mm - want).squaredNorm();
      if (d < smallest) {
        smallest = d;
        best = static_cast<int>(v);
      }
    }
    return best;
  }

  // Onto the curve, but never so far that a triangle could turn over.
  void pull(int v, const Vec2& want) {
    if (used_[v]) return;
    used_[v] = true;
    Vec2 step = want - fine_.points[v].at_mm;
    const double longest = 0.3 * nearest_edge_[v];
    if (step.norm() > longest) step *= longest / step.norm();
    const int other = fine_.mirror[v];
    if (other == v) step.x() = 0.0;
    fine_.points[v].at_mm += step;
    fine_.points[other].at_mm = fine_.points[v].at_mm;
    if (other != v) fine_.points[other].at_mm.x() = -fine_.points[v].at_mm.x();
  }

  const HeadShape& shape_;
  DomainMesh& fine_;
  std::vector<bool> used_;
  std::vector<double> nearest_edge_;
};

std::vector<int> other_side(const DomainMesh& fine, const std::vector<int>& chain) {
  std::vector<int> result;
  for (const int v : chain) result.push_back(fine.mirror[v]);
  return result;
}

// From the subject's right end to the left one, of a chain from the midline outwards.
std::vector<int> right_to_left(const DomainMesh& fine, const std::vector<int>& left) {
  std::vector<int> chain = other_side(fine, left);
  std::reverse(chain.begin(), chain.end());
  chain.insert(chain.end(), left.begin() + 1, left.end());
  return chain;
}

using Row = std::map<int, double>;

// Lids have a plate of cartilage along their margin, which no element resolves: skin next to the
// margin, outside and towards the eyeball, goes with it, and what brow or cheek pull away is
// stretched further out.
void stiffen_lids(const DomainMesh& fine, std::vector<Row>& rows) {
  constexpr double kPlate_mm = 1.6;
  constexpr double kFree_mm = 4.5;
  std::vector<int> rim;
  for (std::size_t v = 0; v < fine.points.size(); ++v) {
    const DomainPoint& p = fine.points[v];
    if (p.rim == Rim::kEye && p.inward == 0.0) rim.push_back(static_cast<int>(v));
  }
  for (std::size_t v = 0; v < fine.points.size(); ++v) {
    const DomainPoint& p = fine.points[v];
    const bool margin_side = p.rim == Rim::kEye && p.inward > 0.0;
    const bool near = std::abs(p.at_mm.y()) < 20.0 && std::abs(p.at_mm.x()) < 60.0;
    if (!margin_side && (p.rim != Rim::kNone || !near)) continue;
    double nearest = kFree_mm;
    int margin = -1;
    for (const int r : rim) {
      const double d = (fine.points[r].at_mm - p.at_mm).norm();
      if (d >= nearest) continue;
      nearest = d;
      margin = r;
    }
    if (margin < 0) continue;
    const double own = smooth_step(kPlate_mm, kFree_mm, nearest);
    for (auto& [u, w] : rows[v]) w *= own;
    for (const auto& [u, w] : rows[margin]) rows[v][u] += (1.0 - own) * w;
  }
}

}  // namespace

FineSkin refine(const HeadShape& shape, const DomainMesh& surface, int levels) {
  FineSkin skin;
  skin.domain = surface;
  std::vector<std::map<int, double>> rows(surface.points.size());
  for (std::size_t v = 0; v < rows.size(); ++v) rows[v][static_cast<int>(v)] = 1.0;
  std::vector<Stencil> stencils;
  for (int level = 0; level < levels; ++level) {
    skin.domain = subdivide(shape, skin.domain, stencils);
    std::vector<std::map<int, double>> finer(stencils.size());
    for (std::size_t v = 0; v < stencils.size(); ++v) {
      for (const StencilEntry& entry : stencils[v]) {
        for (const auto& [u, w] : rows[entry.vertex]) finer[v][u] += entry.weight * w;
      }
    }
    rows = std::move(finer);
  }
  stiffen_lids(skin.domain, rows);
  skin.embedding = compressed(rows);
  return skin;
}

std::vector<NamedCurve> lay_curves(const HeadShape& shape, DomainMesh& fine) {
  CurveLayer layer(shape, fine);
  const std::vector<int> brow = layer.lay_front(brow_upper_edge());
  const std::vector<int> furrow = layer.lay_front(furrow_line());
  const std::vector<int> nose = layer.lay_front(nose_base_line());
  std::vector<int> upper = layer.lay_front(upper_lip_border());
  std::vector<int> lower = layer.lay_front(lower_lip_border());
  const int corner = layer.mouth_corner();
  const double corner_x = fine.points[corner].at_mm.x();
  for (std::vector<int>* lip : {&upper, &lower}) {
    while (fine.points[lip->back()].at_mm.x() > corner_x - 0.8) lip->pop_back();
    lip->push_back(corner);
  }
  const std::vector<int> chin = layer.lay_front(chin_border());
  const std::vector<int> lid = layer.upper_lid();
  std::vector<Vec2> line;
  for (int i = 0; i <= 50; ++i) line.push_back({i, shape.hairline(i)});
  const std::vector<int> hair = layer.lay(line);
  return {{"brow_left", brow},
          {"brow_right", other_side(fine, brow)},
          {"furrow_left", furrow},
          {"furrow_right", other_side(fine, furrow)},
          {"nose_tip", right_to_left(fine, nose)},
          {"upper_lip", right_to_left(fine, upper)},
          {"lower_lip", right_to_left(fine, lower)},
          {"chin_boss", right_to_left(fine, chin)},
          {"hairline", right_to_left(fine, hair)},
          {"eyelid_left", lid},
          {"eyelid_right", other_side(fine, lid)}};
}

}  // namespace zygoma
