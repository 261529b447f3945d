// What the levels of the estimation cost and buy: the closed form of the paper, the linear
// response, the response with correctives, and the lattice itself, on performers filmed by nobody
// (exact contours of another face, with noise); and what priors, robust loss, time and the share of
// motion that is not trusted are worth. Writes docs/results/retarget.csv and a plot.
//
//   retarget_bench [CSV [SVG [COMMIT]]]
#include <cmath>
#include <cstdlib>

#include "retarget/estimator.h"
#include "src/io/svg_plot.h"
#include "tests/bench/bench_tools.h"
#include "tests/hard/retarget_scenes.h"

namespace zygoma::bench {
namespace {

using hard::Performance;
using hard::PerformingFace;

struct Row {
  std::string name;
  RetargetOptions options;
  bool in_plot = false;
};

// Every muscle in turn and some together, both sides unlike, a head that moves.
Performance make_performance(PerformingFace& performer, std::uint32_t seed, double noise_px) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  struct Gesture {
    int control;
    double start_s, rise_s, hold_s, level;
  };
  std::vector<Gesture> gestures;
  for (int i = 0; i < performer.response.num_controls(); ++i) {
    for (int k = 0; k < 2; ++k) {
      gestures.push_back({i,
                          0.8 + 6.0 * share(random),
                          0.2 + 0.2 * share(random),
                          0.3 * share(random),
                          0.3 + 0.5 * share(random)});
    }
  }
  const auto script = [gestures](double t, Eigen::VectorXd& u) {
    for (const Gesture& g : gestures) {
      u[g.control] += g.level * hard::rise_and_fall(t, g.start_s, g.rise_s, g.hold_s);
    }
    u *= 0.7;
  };
  const auto camera = [](double t) {
    HeadMotion motion = hard::still_camera(t);
    motion.b = 0.04 * std::sin(t);
    motion.shift += Point2(12.0 * std::sin(0.9 * t), 6.0 * std::cos(1.1 * t));
    return motion;
  };
  Performance performance = hard::perform(performer, 8.0, script, camera, noise_px);
  // One contour goes astray for a while, as contours do.
  for (std::size_t t = 60; t < 75; ++t) {
    for (Point2& p : performance.contours[t].contours[kUpperLipContour].points_px) p.y() -= 7.0;
  }
  return performance;
}

std::vector<Row> rows() {
  std::vector<Row> all;
  const auto add = [&](const std::string& name, bool in_plot, auto&& change) {
    Row row;
    row.name = name;
    row.in_plot = in_plot;
    row.options.neutral_frame = 2;
    change(row.options);
    all.push_back(row);
  };
  add("closed form", true, [](RetargetOptions& o) { o.refine = false; });
  add("linear, live", true, [](RetargetOptions& o) {
    o.level = FaceLevel::kLinear;
    o.causal = true;
  });
  add("linear", true, [](RetargetOptions& o) { o.level = FaceLevel::kLinear; });
  add("corrected, live", true, [](RetargetOptions& o) { o.causal = true; });
  add("corrected", true, [](RetargetOptions&) {});
  add("lattice, live", true, [](RetargetOptions& o) {
    o.level = FaceLevel::kLattice;
    o.causal = true;
  });
  add("lattice", true, [](RetargetOptions& o) { o.level = FaceLevel::kLattice; });
  add("corrected without priors", false, [](RetargetOptions& o) {
    o.refinement.ridge_sigma = 1e6;
    o.refinement.antagonist_sigma = 1e6;
    o.refinement.tie_sigma = 1e6;
  });
  add("corrected without robust loss", false, [](RetargetOptions& o) {
    o.refinement.outlier_sigmas = 1e6;
  });
  add("corrected without time", false, [](RetargetOptions& o) {
    o.refinement.fastest_per_s = 1e9;
    o.refinement.acceleration_per_s2 = 1e9;
  });
  add("corrected, all motion trusted", false, [](RetargetOptions& o) {
    o.refinement.relative_error = 0.0;
  });
  add("corrected without turn of the head", false, [](RetargetOptions& o) {
    o.refinement.head_turn_sigma_rad = 1e-4;
  });
  return all;
}

struct Measured {
  double ms_per_frame = 0.0;
  double rms = 0.0;
  double rms_observed = 0.0;
  double coverage = 0.0;
  int not_converged = 0;
  double settles_per_frame = 0.0;
};

Measured measure(const Row& row,
                 PerformingFace& face,
                 const std::vector<Performance>& performances) {
  Measured result;
  double square = 0.0;
  double square_observed = 0.0;
  double count = 0.0;
  double count_observed = 0.0;
  double covered = 0.0;
  double frames = 0.0;
  std::vector<double> ms;
  for (const Performance& performance : performances) {
    ContractionTrack track;
    RetargetReport report;
    std::vector<double> once;
    for (int repeat = 0; repeat < 3; ++repeat) {
      const double begin = cpu_ms();
      track = retarget(performance.contours,
                       {face.response, face.simulator.get(), nullptr},
                       row.options,
                       report);
      once.push_back((cpu_ms() - begin) / static_cast<double>(performance.truth.size()));
    }
    ms.push_back(median(once));
    result.not_converged += report.frames_not_converged;
    result.settles_per_frame += report.lattice.settles;
    frames += static_cast<double>(performance.truth.size());
    for (std::size_t t = 0; t < performance.truth.size(); ++t) {
      const Contractions& frame = track.frames[t];
      const Eigen::VectorXd error = hard::controls_of(frame) - performance.truth[t];
      square += error.squaredNorm();
      count += static_cast<double>(error.size());
      for (std::size_t i = 0; i < frame.observed.size(); ++i) {
        if (!frame.observed[i]) continue;
        const double e = error[static_cast<Eigen::Index>(i)];
        square_observed += e * e;
        covered += std::abs(e) <= 2.0 * frame.sigma[i] ? 1.0 : 0.0;
        count_observed += 1.0;
      }
    }
  }
  result.ms_per_frame = median(ms);
  result.rms = std::sqrt(square / count);
  result.rms_observed = count_observed > 0.0 ? std::sqrt(square_observed / count_observed) : 0.0;
  result.coverage = count_observed > 0.0 ? covered / count_observed : 0.0;
  result.settles_per_frame /= frames;
  return result;
}

// The paper's estimates of one frame and nothing else, ms.
double closed_form_ms(PerformingFace& face, const Performance& performance) {
  std::vector<ObservedFrame> frames;
  for (const ContourSet& set : performance.contours) {
    frames.push_back({set.frame_index, set.time_s, stack_contours(set)});
  }
  const Neutral neutral = neutral_at(frames, 2);
  const PerformerFrame performer = measure_performer(neutral, face.response);
  std::size_t next = 0;
  double sum = 0.0;
  const double ms = ms_per_call(
      [&] {
        const FrameReading reading =
            read_frame(frames[next++ % frames.size()], neutral, performer, {});
        sum += estimate_controls(reading.displacements, face.response).sum();
      },
      50.0);
  return sum >= 0.0 ? ms : 0.0;
}

}  // namespace
}  // namespace zygoma::bench

int main(int argc, char** argv) {
  using namespace zygoma;
  using namespace zygoma::bench;
  const std::string csv = argc > 1 ? argv[1] : "";
  const std::string svg = argc > 2 ? argv[2] : "";
  const std::string commit = argc > 3 ? argv[3] : "?";
  PerformingFace face;
  PerformingFace performer(hard::other_identity());
  std::vector<Performance> performances;
  for (std::uint32_t seed = 31; seed < 34; ++seed) {
    performances.push_back(make_performance(performer, seed, 0.3));
  }
  Table table(
      csv,
      "retarget_bench; three performances of another face, 8 s, 0.3 px of noise, one contour "
      "astray for 15 frames; processor time per frame with everything from contours to "
      "contractions, medians of 3; one frame of closed form alone " +
          format("%.4f", closed_form_ms(face, performances.front())) + " ms; commit " + commit +
          "; 2 virtual cores of an Intel Xeon (AVX-512), 23 GiB, Debian 12",
      "estimate,ms_per_frame,rms,rms_observed,coverage_2_sigma,settles_per_frame,"
      "frames_not_converged");
  PlotPanel panel{"what a level costs and buys",
                  {"processor time per frame (ms)", true},
                  {"error, rms over all controls", false},
                  {}};
  int colour = 0;
  for (const Row& row : rows()) {
    const Measured m = measure(row, face, performances);
    table.line(format("%s,%.4f,%.4f,%.4f,%.3f,%.2f,%d",
                      row.name.c_str(),
                      m.ms_per_frame,
                      m.rms,
                      m.rms_observed,
                      m.coverage,
                      m.settles_per_frame,
                      m.not_converged));
    if (!row.in_plot) continue;
    panel.series.push_back({row.name, {m.ms_per_frame}, {m.rms}, PlotMark::kPoints, colour++ % 6});
  }
  if (!svg.empty()) write_svg_plot(svg, {panel}, 1);
  return 0;
}
