// What a picture of the face costs at 640 x 480: CPU time and time on the clock, for coarse and
// fine skin, one and two threads, with and without anti-aliasing. The skin and the jaw move from
// picture to picture, so that nothing is found already done.
//
//   render_bench [RESULT.csv]

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "face/generic_head.h"
#include "src/render/renderer.h"
#include "src/render/views.h"
#include "tests/bench/bench_tools.h"

namespace zygoma {
namespace {

struct Cost {
  double cpu_ms = 0.0;
  double clock_ms = 0.0;
};

Cost cost_of(const std::shared_ptr<const Anatomy>& anatomy, const RenderOptions& options) {
  constexpr int kPictures = 41;
  Renderer renderer(anatomy, options);
  const Camera camera = view_camera(View::kFront, *anatomy, 640, 480);
  std::vector<Vec3> skin_mm = anatomy->skin.mesh.positions_mm;
  cv::Mat bgr;
  std::vector<double> cpu, clock;
  for (int i = 0; i < kPictures; ++i) {
    for (Vec3& p : skin_mm) p.y() *= i % 2 == 0 ? 0.95 : 1.0 / 0.95;
    const double cpu_before = bench::cpu_ms();
    const auto before = std::chrono::steady_clock::now();
    renderer.render(skin_mm, 0.02 * (i % 5), camera, bgr);
    const std::chrono::duration<double, std::milli> took =
        std::chrono::steady_clock::now() - before;
    cpu.push_back(bench::cpu_ms() - cpu_before);
    clock.push_back(took.count());
  }
  return {bench::median(cpu), bench::median(clock)};
}

int run(const std::string& path) {
  bench::Table table(path,
                     "pictures of 640 x 480, median of 41",
                     "surface_vertices,skin_vertices,samples_per_pixel,threads,cpu_ms,clock_ms");
  for (const int vertices : {300, 2000}) {
    const auto anatomy =
        std::make_shared<const Anatomy>(make_generic_head({}, {.num_surface_vertices = vertices}));
    for (const int samples : {1, 2, 4}) {
      for (const int threads : {1, 2}) {
        RenderOptions options;
        options.samples_per_pixel = samples;
        options.num_threads = threads;
        const Cost cost = cost_of(anatomy, options);
        table.line(bench::format("%d,%zu,%d,%d,%.1f,%.1f",
                                 vertices,
                                 anatomy->skin.mesh.positions_mm.size(),
                                 samples,
                                 threads,
                                 cost.cpu_ms,
                                 cost.clock_ms));
      }
    }
  }
  return 0;
}

}  // namespace
}  // namespace zygoma

int main(int argc, char** argv) { return zygoma::run(argc > 1 ? argv[1] : ""); }
