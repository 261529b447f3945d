#include "src/pipeline/tradeoff.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "face/simulator.h"
#include "src/io/atomic_file.h"
#include "src/io/svg_plot.h"
#include "src/io/text.h"
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
  varied.settle.still_mm = 0.0;
  varied.head.albedo_size_px = 64;  // nobody looks
  return varied;
}

Film shoot(const Scene& scene, StageObserver& observer, const StopQuestion& stop) {
  Film film;
  film.anatomy = std::make_shared<const Anatomy>(make_generic_head(scene.identity, scene.head));
  std::vector<std::string> muscles;
  for (const Muscle& muscle : film.anatomy->muscles) muscles.push_back(muscle.name);
  const ContractionTrack track = sample_motion(scene.motion, muscles);
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
      row.largest_mm = std::max(row.largest_mm, off);
    }
  }
  row.rms_mm = std::sqrt(sum2 / static_cast<double>(film.skins_mm.size() * here.size()));
}

std::string name_of(const TissueChoice& choice) {
  std::string name =
      (choice.quality.bi_layer ? "bi " : "tri ") + std::to_string(choice.quality.surface_vertices);
  if (choice.solver == Solver::kExplicit) return name + " explicit";
  char residual[16];
  std::snprintf(residual, sizeof residual, " %.0e", choice.quality.relative_residual);
  return name + residual;
}

void find_front(std::vector<TradeoffRow>& rows) {
  std::sort(rows.begin(), rows.end(), [](const TradeoffRow& a, const TradeoffRow& b) {
    return a.frame_ms < b.frame_ms;
  });
  double closest = std::numeric_limits<double>::infinity();
  for (TradeoffRow& row : rows) {
    row.on_front = row.frames_not_converged == 0 && row.rms_mm < closest;
    if (row.on_front) closest = row.rms_mm;
  }
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

std::vector<TissueChoice> tissue_choices() {
  std::vector<TissueChoice> all;
  const auto add = [&](int vertices, bool bi, double residual, Solver solver = Solver::kImplicit) {
    TissueChoice choice{"", {"", vertices, bi, residual, 0.0}, solver};
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
  return all;
}

TissueChoice tissue_reference() {
  return {"reference", face_quality("reference"), Solver::kImplicit};
}

Tradeoff measure_tradeoff(const Scene& scene,
                          const std::vector<TissueChoice>& choices,
                          const TissueChoice& reference_choice,
                          StageObserver& observer,
                          const StopQuestion& stop) {
  Tradeoff result;
  result.reference = reference_choice;
  observer.begin("reference", 0);
  const Reference reference(shoot(with(scene, reference_choice), observer, stop));
  observer.end();
  result.reference_ms = reference.film.simulation.frame_ms();
  result.reference_nodes = reference.film.num_nodes;
  result.stopped = reference.film.simulation.stopped;
  for (const TissueChoice& choice : choices) {
    if (result.stopped) break;
    observer.begin(name_of(choice), static_cast<int>(reference.film.skins_mm.size()));
    const Film film = shoot(with(scene, choice), observer, stop);
    observer.end();
    result.stopped = film.simulation.stopped;
    if (result.stopped) break;
    TradeoffRow row;
    row.choice = choice;
    row.num_nodes = film.num_nodes;
    row.frame_ms = film.simulation.frame_ms();
    row.frames_not_converged = film.simulation.frames_not_converged();
    row.most_inverted_elements = film.simulation.most_inverted_elements();
    compare(reference, film, row);
    result.rows.push_back(row);
  }
  find_front(result.rows);
  return result;
}

void write_tradeoff_csv(const std::string& path, const Tradeoff& tradeoff) {
  std::string text =
      "quality,layers,surface_vertices,nodes,solver,residual,ms_per_frame,rms_mm,largest_mm,"
      "frames_not_converged,inverted_elements,on_front\n";
  const auto cell = [&](double value, int decimals) {
    text += ',';
    append_fixed(text, value, decimals);
  };
  const auto line = [&](const TradeoffRow& row) {
    const FaceQuality& quality = row.choice.quality;
    text += row.choice.name;
    text += quality.bi_layer ? ",2" : ",3";
    cell(quality.surface_vertices, 0);
    cell(row.num_nodes, 0);
    text += row.choice.solver == Solver::kExplicit ? ",explicit" : ",equilibrium";
    cell(quality.relative_residual, 8);
    cell(row.frame_ms, 3);
    cell(row.rms_mm, 4);
    cell(row.largest_mm, 4);
    cell(row.frames_not_converged, 0);
    cell(row.most_inverted_elements, 0);
    text += row.on_front ? ",1\n" : ",0\n";
  };
  for (const TradeoffRow& row : tradeoff.rows) line(row);
  TradeoffRow reference;
  reference.choice = tradeoff.reference;
  reference.num_nodes = tradeoff.reference_nodes;
  reference.frame_ms = tradeoff.reference_ms;
  reference.on_front = true;
  line(reference);
  AtomicFile file(path);
  file.stream() << text;
  file.commit();
}

void write_tradeoff_plot(const std::string& path, const Tradeoff& tradeoff) {
  PlotSeries front{"front", {}, {}, PlotMark::kLine, 4};
  PlotSeries bi{"two layers", {}, {}, PlotMark::kPoints, 0};
  PlotSeries tri{"three layers", {}, {}, PlotMark::kPoints, 1};
  PlotSeries explicit_steps{"explicit steps", {}, {}, PlotMark::kPoints, 5};
  for (const TradeoffRow& row : tradeoff.rows) {
    PlotSeries& series = row.choice.solver == Solver::kExplicit ? explicit_steps
                         : row.choice.quality.bi_layer          ? bi
                                                                : tri;
    series.x.push_back(row.frame_ms);
    series.y.push_back(row.rms_mm);
    if (!row.on_front) continue;
    front.x.push_back(row.frame_ms);
    front.y.push_back(row.rms_mm);
  }
  PlotPanel panel{"What accuracy costs",
                  {"processor time per frame (ms)", true},
                  {"error of the skin, RMS (mm)", true},
                  {front, bi, tri, explicit_steps}};
  write_svg_plot(path, {panel}, 1);
}

}  // namespace zygoma
