#include "src/pipeline/tradeoff_tissue.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "face/simulator.h"
#include "src/pipeline/simulate_scene.h"
#include "tracker/feature_schema.h"

namespace zygoma {
namespace {

// Behind the eyes: ears and the back of the head do not count.
constexpr double kFaceDepthMm = 60.0;

// A simulated motion, seen on the skin.
struct Film {
  std::shared_ptr<const Anatomy> anatomy;
  Simulation simulation;
  std::vector<std::vector<Vec3>> skins_mm;  // per frame
  int num_nodes = 0;
};

Scene with(const Scene& scene, const TissueChoice& choice) {
  Scene varied = scene;
  choice.quality.apply(varied.head, varied.tissue, varied.settle);
  varied.settle.solver = choice.solver;
  std::erase_if(varied.tissue.effects,
                [&](const EffectChoice& effect) { return effect.name == choice.without; });
  varied.settle.still_mm = 0.0;
  varied.head.albedo_size_px = 64;  // nobody looks
  return varied;
}

Film shoot(const Scene& scene, StageObserver& observer, const StopQuestion& stop) {
  Film film;
  film.anatomy = std::make_shared<const Anatomy>(make_generic_head(scene.identity, scene.head));
  const ContractionTrack track = sample_motion(scene.motion, film.anatomy->muscle_names());
  const auto take = [&](int frame, const FaceState& state, const MotionRow&) {
    film.num_nodes = static_cast<int>(state.positions_mm.size());
    film.skins_mm.emplace_back();
    embed_skin(*film.anatomy, state, film.skins_mm.back());
    observer.update(frame + 1);
  };
  film.simulation = simulate_scene(scene, film.anatomy, track, take, stop);
  return film;
}

int nearest_point(const std::vector<Vec3>& points, const Vec3& p) {
  const auto nearer = [&](const Vec3& a, const Vec3& b) {
    return (a - p).squaredNorm() < (b - p).squaredNorm();
  };
  return static_cast<int>(std::min_element(points.begin(), points.end(), nearer) - points.begin());
}

// Vertices of a skin that can be found again on another one: where the vertices of the surface lie
// on the face, without lips and lids, whose flaps lie on each other.
std::vector<int> probes_of(const Anatomy& anatomy) {
  std::vector<int> probes;
  for (std::size_t v = 0; v < anatomy.region.size(); ++v) {
    const Vec3& p = anatomy.surface.positions_mm[v];
    if (anatomy.region[v] != Region::kFace || p.z() <= -kFaceDepthMm) continue;
    probes.push_back(nearest_point(anatomy.skin.mesh.positions_mm, p));
  }
  return probes;
}

// For each probe of the reference, where it is on another skin: a vertex, or a place along a curve.
struct Twin {
  int vertex = 0;
  int other = 0;  // mixed with it by `share`
  double share = 0.0;

  Vec3 motion(const std::vector<Vec3>& moved, const std::vector<Vec3>& rest) const {
    const auto of = [&](int v) -> Vec3 { return moved[v] - rest[v]; };
    return (1.0 - share) * of(vertex) + share * of(other);
  }
};

// At a share of the length of a chain of vertices.
Twin along(const std::vector<int>& chain, const std::vector<Vec3>& rest, double share) {
  std::vector<double> length{0.0};
  for (std::size_t k = 1; k < chain.size(); ++k) {
    length.push_back(length.back() + (rest[chain[k]] - rest[chain[k - 1]]).norm());
  }
  const double s = share * length.back();
  std::size_t k = 1;
  while (k + 1 < chain.size() && length[k] < s) ++k;
  const double part = length[k] - length[k - 1];
  return {
      chain[k - 1], chain[k], part > 0.0 ? std::clamp((s - length[k - 1]) / part, 0.0, 1.0) : 0.0};
}

// Of the probes, at these places of the reference's skin, and along the curves of the nine features
// from which contractions are read.
std::vector<Twin> twins_on(const Anatomy& anatomy, const std::vector<Vec3>& probes_mm) {
  constexpr int kPerCurve = 13;
  const std::vector<Vec3>& skin = anatomy.skin.mesh.positions_mm;
  std::vector<Twin> found;
  for (const Vec3& probe : probes_mm) {
    const int nearest = nearest_point(skin, probe);
    found.push_back({nearest, nearest, 0.0});
  }
  for (const NamedCurve& curve : anatomy.curves) {
    const auto is_it = [&](const Feature& feature) { return feature.name == curve.name; };
    if (std::none_of(kContours1992.begin(), kContours1992.end(), is_it)) continue;
    for (int k = 0; k < kPerCurve; ++k) {
      found.push_back(along(curve.skin_vertices, skin, static_cast<double>(k) / (kPerCurve - 1)));
    }
  }
  return found;
}

// What all choices are held against; its probes are looked for once.
struct Reference {
  Film film;
  std::vector<Vec3> probes_mm;
  std::vector<Twin> twins;

  explicit Reference(Film shot) : film(std::move(shot)) {
    for (const int v : probes_of(*film.anatomy)) {
      probes_mm.push_back(film.anatomy->skin.mesh.positions_mm[v]);
    }
    twins = twins_on(*film.anatomy, probes_mm);
  }
};

void compare(const Reference& reference, const Film& film, TradeoffRow& row) {
  const std::vector<Twin> here = twins_on(*film.anatomy, reference.probes_mm);
  const std::vector<Vec3>& rest_there = reference.film.anatomy->skin.mesh.positions_mm;
  const std::vector<Vec3>& rest_here = film.anatomy->skin.mesh.positions_mm;
  double sum2 = 0.0;
  for (std::size_t frame = 0; frame < film.skins_mm.size(); ++frame) {
    for (std::size_t k = 0; k < here.size(); ++k) {
      const Vec3 there = reference.twins[k].motion(reference.film.skins_mm[frame], rest_there);
      const double off = (here[k].motion(film.skins_mm[frame], rest_here) - there).norm();
      sum2 += off * off;
      row.other_error = std::max(row.other_error, off);
    }
  }
  row.error = std::sqrt(sum2 / static_cast<double>(film.skins_mm.size() * here.size()));
}

std::string family_of(const TissueChoice& choice) {
  if (!choice.without.empty()) return "an effect left out";
  if (choice.solver == Solver::kExplicit) return "explicit steps";
  return choice.quality.bi_layer ? "two layers" : "three layers";
}

std::string words_of(const TissueChoice& choice) {
  std::string words = std::to_string(choice.quality.surface_vertices) + " vertices";
  if (choice.solver == Solver::kExplicit) return words + " 2 layers";
  char residual[32];
  std::snprintf(residual, sizeof residual, " to %.0e", choice.quality.relative_residual);
  words += residual;
  if (!choice.without.empty()) words += " without " + choice.without;
  return words;
}

TradeoffRow row_of(const TissueChoice& choice, const Simulation& simulation) {
  TradeoffRow row;
  row.quality = choice.name;
  row.family = family_of(choice);
  row.choice = words_of(choice);
  row.frame_ms = simulation.frame_ms();
  row.failed = simulation.frames_not_converged() /
               std::max(1.0, static_cast<double>(simulation.rows.size()));
  return row;
}

}  // namespace

Motion tradeoff_motion() {
  Motion motion;
  motion.frames_per_s = 30.0;
  const std::map<std::string, double> smile{{"zygomaticus_major_L", 0.8},
                                            {"zygomaticus_major_R", 0.8}};
  std::map<std::string, double> brows{{"occipitofrontalis_inner_L", 0.7},
                                      {"occipitofrontalis_inner_R", 0.7},
                                      {"occipitofrontalis_major_L", 0.6},
                                      {"occipitofrontalis_major_R", 0.6}};
  std::map<std::string, double> both = brows;
  both.insert(smile.begin(), smile.end());
  motion.keys = {
      {0.0, 0.0, {}}, {0.5, 0.0, smile}, {1.0, 0.1, both}, {1.5, 0.5, brows}, {2.0, 0.0, {}}};
  return motion;
}

std::vector<TissueChoice> tissue_choices(const Scene& scene) {
  std::vector<TissueChoice> all;
  const auto add = [&](int vertices, bool bi, double residual, Solver solver = Solver::kImplicit) {
    TissueChoice choice{"", {"", vertices, bi, residual, 0.0}, solver, ""};
    for (const FaceQuality& quality : face_qualities()) {
      if (quality.surface_vertices == vertices && quality.bi_layer == bi &&
          quality.relative_residual == residual && solver == Solver::kImplicit) {
        choice.name = quality.name;
      }
    }
    all.push_back(choice);
  };
  for (const int vertices : {300, 500, 1000, 2000}) {
    for (const bool bi : {true, false}) {
      for (const double residual : {1e-1, 1e-2, 1e-4}) add(vertices, bi, residual);
    }
  }
  add(300, true, 1e-4, Solver::kExplicit);
  for (const EffectChoice& effect : scene.tissue.effects) {
    all.push_back({"", face_quality("standard"), Solver::kImplicit, effect.name});
  }
  return all;
}

TissueChoice tissue_reference() {
  return {"reference", face_quality("reference"), Solver::kImplicit, ""};
}

TradeoffStage measure_tissue(const Scene& scene,
                             const std::vector<TissueChoice>& choices,
                             const TissueChoice& reference_choice,
                             StageObserver& observer,
                             const StopQuestion& stop) {
  TradeoffStage stage{
      "tissue", "mm", "error of the skin, RMS", "largest mm", words_of(reference_choice)};
  observer.begin("tissue: reference", 0);
  const Reference reference(shoot(with(scene, reference_choice), observer, stop));
  observer.end();
  stage.stopped = reference.film.simulation.stopped;
  const int num_frames = static_cast<int>(reference.film.skins_mm.size());
  for (const TissueChoice& choice : choices) {
    if (stage.stopped) break;
    observer.begin("tissue: " + family_of(choice) + ", " + words_of(choice), num_frames);
    const Film film = shoot(with(scene, choice), observer, stop);
    observer.end();
    stage.stopped = film.simulation.stopped;
    if (stage.stopped) break;
    stage.rows.push_back(row_of(choice, film.simulation));
    compare(reference, film, stage.rows.back());
  }
  if (!stage.stopped) {
    stage.rows.push_back(row_of(reference_choice, reference.film.simulation));
    stage.rows.back().is_reference = true;
  }
  find_front(stage);
  return stage;
}

}  // namespace zygoma
