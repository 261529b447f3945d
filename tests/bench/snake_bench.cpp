// Our snake against scikit-image's active_contour, contour by contour, at equal or better accuracy.
//
//   snake_bench [--csv RESULT.csv]          needs python3-skimage (Debian); a peer, nothing else
//
// Cases: the two examples of scikit-image's own documentation (the astronaut's face, a closed
// contour on edges; a line of text, an open one on darkness), and contours of a synthetic
// performer's frame of 640x480, started 2.5 px off the truth. Both start in the same place on the
// same picture with the same Gaussian. scikit-image's options are those of its documentation, for
// the performer the best of several by the truth. Accuracy: for its own examples what it maximises
// itself, the mean strength of the edge (the darkness) under the contour; for the performer the
// mean distance to the truth. Two times are ours: relaxing alone, and with the landscape of the
// picture, which one frame's contours share. Repeats alternate; medians of processor time, one
// thread.
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "src/pipeline/stage_figures.h"
#include "src/synthetic/performer.h"
#include "tests/bench/bench_tools.h"
#include "tests/support/lines.h"
#include "tracker/potential_field.h"
#include "tracker/snake.h"

namespace zygoma {
namespace {

namespace fs = std::filesystem;
using Line = std::vector<Point2>;

constexpr int kRepeats = 5;
constexpr double kStartOff_px = 2.5;

// Dark lines attract: P = I of the smoothed picture.
class DarkLandscape : public ImageLandscape {
 public:
  DarkLandscape(const cv::Mat& grey, double sigma, double weight) : weight_(weight / 255.0) {
    grey.convertTo(smooth_, CV_32F);
    cv::GaussianBlur(smooth_, smooth_, {}, sigma);
    cv::Sobel(smooth_, gradient_x_, CV_32F, 1, 0, 3, 0.125);
    cv::Sobel(smooth_, gradient_y_, CV_32F, 0, 1, 3, 0.125);
  }
  double potential(size_t, const Point2& x) const override { return weight_ * at(smooth_, x); }
  Point2 gradient(size_t, const Point2& x) const override {
    return weight_ * Point2(at(gradient_x_, x), at(gradient_y_, x));
  }

 private:
  static double at(const cv::Mat& image, const Point2& x) {
    const double px = std::clamp(x.x(), 0.0, image.cols - 1.001);
    const double py = std::clamp(x.y(), 0.0, image.rows - 1.001);
    const int column = static_cast<int>(px), row = static_cast<int>(py);
    const double s = px - column, t = py - row;
    const auto* above = image.ptr<float>(row) + column;
    const auto* below = image.ptr<float>(row + 1) + column;
    return (1 - t) * ((1 - s) * above[0] + s * above[1]) + t * ((1 - s) * below[0] + s * below[1]);
  }

  double weight_;
  cv::Mat smooth_, gradient_x_, gradient_y_;
};

class EdgeLandscape : public ImageLandscape {
 public:
  // The normal points up the wanted edge; zero: either way.
  EdgeLandscape(const PotentialField& field, const Point2& normal)
      : field_(field), normal_(normal), is_signed_(normal.norm() > 0.0) {}
  double potential(size_t, const Point2& x) const override {
    return is_signed_ ? field_.potential(x, normal_) : field_.potential(x);
  }
  Point2 gradient(size_t, const Point2& x) const override {
    return is_signed_ ? field_.gradient(x, normal_) : field_.gradient(x);
  }

 private:
  const PotentialField& field_;
  Point2 normal_;
  bool is_signed_;
};

struct Case {
  std::string name;
  std::string picture;  // file in the folder
  cv::Mat grey;
  double sigma = 1.0;
  bool dark = false;
  Point2 normal = Point2::Zero();  // that ours knows the edge has
  cv::Rect region;                 // of the landscape
  Line start;                      // of both
  double rest_share = 1.0;  // rest lengths of ours over those of its start: less pulls it together
  int num_nodes = 0;
  std::vector<SnakeOptions> options;  // the best of them counts, as of the peer's
  std::vector<std::string> peer_options;
  Line truth;  // empty: judged by what is under the contour
};

struct Run {
  std::vector<double> relax_ms, field_ms, peer_ms;
  Line ours, theirs;
};

// Lower is better: px to the truth, or minus the edge or plus the brightness under the contour.
double error_of(const Case& c, const Line& line) {
  double sum = 0.0;
  const Line points = resample(line, 400);
  if (!c.truth.empty()) {
    for (const Point2& p : points) sum += distance_to_line(p, c.truth) / 400.0;
    return sum;
  }
  if (c.dark) {
    const DarkLandscape landscape(c.grey, c.sigma, 1.0);
    for (const Point2& p : points) sum += landscape.potential(0, p) / 400.0;
    return sum;
  }
  const PotentialField field(c.grey, {0, 0, c.grey.cols, c.grey.rows}, {c.sigma});
  for (const Point2& p : points) sum += field.potential(p) / 400.0;
  return sum;
}

// Where snakes can be closed; elsewhere the chain stays open.
template <typename Options>
void close_chain(Options& options) {
  if constexpr (requires { options.ends; }) options.ends = decltype(options.ends)::kClosed;
}

std::vector<Case> documented_cases(const std::string& folder) {
  Case face;
  face.name = "astronaut";
  face.picture = "astronaut.png";
  face.sigma = 3.0;
  for (int i = 0; i < 400; ++i) {
    const double s = 2.0 * 3.14159265358979 * i / 399.0;
    face.start.emplace_back(220.0 + 100.0 * std::cos(s), 100.0 + 100.0 * std::sin(s));
  }
  face.num_nodes = 40;
  face.rest_share = 0.4;
  SnakeOptions stiff{.tension = 0.03, .rigidity = 0.03, .image_weight = 3.0, .step = 8.0};
  stiff.max_iterations = 300;
  stiff.tolerance_px = 0.02;
  close_chain(stiff);
  face.options = {stiff};
  face.region = {100, 0, 240, 220};
  face.peer_options = {"dict(alpha=0.015, beta=10, gamma=0.001)"};

  Case text;
  text.name = "text";
  text.picture = "text.png";
  text.sigma = 1.0;
  text.dark = true;
  for (int i = 0; i < 100; ++i) {
    text.start.emplace_back(5.0 + 419.0 * i / 99.0, 136.0 - 86.0 * i / 99.0);
  }
  text.num_nodes = 50;
  SnakeOptions stiffer{.tension = 0.1, .rigidity = 0.5, .image_weight = 3.0, .step = 8.0};
  stiffer.max_iterations = 300;
  stiffer.tolerance_px = 0.02;
  text.options = {stiffer};
  text.peer_options = {
      "dict(boundary_condition='fixed', alpha=0.1, beta=1.0, w_line=-5, w_edge=0, gamma=0.1)"};
  std::vector<Case> cases{face, text};
  for (Case& c : cases) {
    c.grey = cv::imread(folder + "/" + c.picture, cv::IMREAD_GRAYSCALE);
    if (c.region.empty()) c.region = {0, 0, c.grey.cols, c.grey.rows};
  }
  return cases;
}

std::vector<Case> performer_cases(const std::string& folder) {
  PerformerOptions options;
  options.schedule = "neutral";
  options.width_px = 640;
  options.height_px = 480;
  options.duration_s = 0.1;
  Performer performer(options);
  Frame frame;
  Contractions contractions;
  ContourSet truth;
  performer.next(frame, contractions, truth);
  cv::Mat grey;
  cv::cvtColor(frame.image, grey, cv::COLOR_BGR2GRAY);
  cv::imwrite(folder + "/performer.png", grey);
  std::vector<Case> cases;
  for (const char* name : {"brow_left", "brow_right", "upper_lip", "lower_lip"}) {
    Case c;
    c.name = name;
    c.picture = "performer.png";
    c.grey = grey;
    c.sigma = 1.5;
    c.truth = truth.visible(name)->points_px;
    c.num_nodes = static_cast<int>(c.truth.size());
    for (const Point2& p : c.truth) c.start.push_back(p - Point2(0.0, kStartOff_px));
    const cv::Rect2d box = cv::boundingRect([&] {
      std::vector<cv::Point2f> points;
      for (const Point2& p : c.start) {
        points.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
      }
      return points;
    }());
    c.region =
        cv::Rect(cv::Point(static_cast<int>(box.x) - 12, static_cast<int>(box.y) - 12),
                 cv::Point(static_cast<int>(box.br().x) + 12, static_cast<int>(box.br().y) + 12));
    c.options = {{.tension = 0.1, .rigidity = 0.02, .step = 8.0},
                 {.tension = 0.02, .rigidity = 0.005, .image_weight = 3.0, .step = 8.0}};
    c.normal = {0.0, c.name == "lower_lip" ? 1.0 : -1.0};
    for (const char* more : {"", "alpha=0.01, beta=1, ", "alpha=0.1, beta=0.1, "}) {
      c.peer_options.push_back(std::string("dict(") + more + "boundary_condition='free')");
    }
    cases.push_back(c);
  }
  return cases;
}

// The chain of one run, closed again if it is closed; its time in ms.
Line relaxed(const Case& c,
             const SnakeOptions& options,
             const ImageLandscape& landscape,
             double& ms) {
  const bool closed = c.name == "astronaut";
  const Line nodes = resample(c.start, c.num_nodes + (closed ? 1 : 0));
  const Line chain(nodes.begin(), nodes.begin() + c.num_nodes);
  Line at_rest = chain;
  for (Point2& p : at_rest) p *= c.rest_share;
  Line line;
  ms = bench::ms_per_call([&] {
    Snake snake(at_rest, options);
    snake.set_nodes(chain);
    if (c.dark) {
      // As in its example, the ends stay.
      std::vector<SoftAnchor> ends(chain.size());
      ends.front() = {chain.front(), 1e3};
      ends.back() = {chain.back(), 1e3};
      snake.set_anchors(ends);
    }
    snake.relax(&landscape);
    line = snake.nodes();
  });
  if (closed) line.push_back(line.front());
  return line;
}

void relax_ours(const Case& c, Run& run) {
  constexpr double kDarkWeight = 5.0;  // as the example's
  const PotentialOptions edges{c.sigma};
  run.field_ms.push_back(bench::ms_per_call([&] {
    if (c.dark) {
      DarkLandscape(c.grey, c.sigma, kDarkWeight);
    } else {
      PotentialField(c.grey, c.region, edges);
    }
  }));
  const DarkLandscape dark(c.grey, c.sigma, kDarkWeight);
  const PotentialField field(c.grey, c.region, edges);
  const EdgeLandscape edge(field, c.normal);
  double best = 1e18;
  double best_ms = 0.0;
  for (const SnakeOptions& options : c.options) {
    double ms = 0.0;
    const ImageLandscape& landscape = c.dark ? static_cast<const ImageLandscape&>(dark)
                                             : static_cast<const ImageLandscape&>(edge);
    const Line line = relaxed(c, options, landscape, ms);
    const double error = error_of(c, line);
    if (error >= best) continue;
    best = error;
    best_ms = ms;
    run.ours = line;
  }
  run.relax_ms.push_back(best_ms);
}

void write_case(const std::string& folder, const Case& c, size_t which) {
  std::ofstream file(folder + "/" + c.name + "." + std::to_string(which) + ".case");
  file << c.picture << '\n' << c.sigma << '\n' << c.peer_options[which] << '\n';
  for (const Point2& p : c.start) file << p.y() << ' ' << p.x() << '\n';
}

std::string peer_command(const std::string& folder, const char* what) {
  return "OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 /usr/bin/python3 '" ZYGOMA_SOURCE_DIR
         "/tests/bench/snake_peer.py' '" +
         folder + "' " + what;
}

void run_peer(const std::string& folder,
              const std::vector<Case>& cases,
              std::map<std::string, Run>& runs) {
  FILE* pipe = popen(peer_command(folder, "run").c_str(), "r");
  std::string output;
  char block[4096];
  while (pipe != nullptr && std::fgets(block, sizeof block, pipe) != nullptr) output += block;
  if (pipe != nullptr) pclose(pipe);
  std::map<std::string, std::pair<double, Line>> best;  // by accuracy
  std::istringstream lines(output);
  for (std::string text; std::getline(lines, text);) {
    std::istringstream words(text);
    std::string name, point;
    double ms = 0.0;
    words >> name >> ms;
    Line line;
    while (words >> point) {
      double row = 0.0, column = 0.0;
      std::sscanf(point.c_str(), "%lf,%lf", &row, &column);
      line.emplace_back(column, row);
    }
    name = name.substr(0, name.find('.'));
    for (const Case& c : cases) {
      if (c.name != name) continue;
      const bool better =
          !best.contains(name) || error_of(c, line) < error_of(c, best[name].second);
      if (better) best[name] = {ms, line};
    }
  }
  for (const auto& [name, found] : best) {
    runs[name].peer_ms.push_back(found.first);
    runs[name].theirs = found.second;
  }
}

int run_bench(const std::string& csv) {
  const std::string folder =
      (fs::temp_directory_path() / ("zygoma_snake_bench_" + std::to_string(getpid()))).string();
  fs::create_directories(folder);
  cv::setNumThreads(1);
  if (std::system(peer_command(folder, "write").c_str()) != 0) {
    std::fprintf(stderr, "snake_bench: scikit-image is missing (apt install python3-skimage)\n");
    return 2;
  }
  std::vector<Case> cases = documented_cases(folder);
  for (const Case& c : performer_cases(folder)) cases.push_back(c);
  for (const Case& c : cases) {
    for (size_t i = 0; i < c.peer_options.size(); ++i) write_case(folder, c, i);
  }
  std::map<std::string, Run> runs;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    for (const Case& c : cases) relax_ours(c, runs[c.name]);
    run_peer(folder, cases, runs);
  }
  bench::Table table(csv,
                     "snake_bench; scikit-image's active_contour against our snake; medians of " +
                         std::to_string(kRepeats) + ", alternating, processor time of one thread",
                     "case,measure,skimage_nodes,our_nodes,skimage,ours,skimage_ms,relax_ms,"
                     "landscape_ms,times_faster_relaxing,times_faster_in_all");
  for (const Case& c : cases) {
    const Run& run = runs[c.name];
    if (run.peer_ms.empty()) continue;
    const double theirs = bench::median(run.peer_ms);
    const double relax = bench::median(run.relax_ms);
    const double field = bench::median(run.field_ms);
    const char* measure = !c.truth.empty() ? "px to the truth"
                          : c.dark         ? "brightness under it"
                                           : "minus edge under it";
    table.line(bench::format("%s,%s,%zu,%d,%.3f,%.3f,%.2f,%.4f,%.4f,%.0f,%.0f",
                             c.name.c_str(),
                             measure,
                             c.start.size(),
                             c.num_nodes,
                             error_of(c, run.theirs),
                             error_of(c, run.ours),
                             theirs,
                             relax,
                             field,
                             theirs / relax,
                             theirs / (relax + field)));
  }
  fs::remove_all(folder);
  return 0;
}

}  // namespace
}  // namespace zygoma

int main(int argc, char** argv) {
  try {
    return zygoma::run_bench(argc > 2 && std::strcmp(argv[1], "--csv") == 0 ? argv[2] : "");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "snake_bench: %s\n", error.what());
    return 2;
  }
}
