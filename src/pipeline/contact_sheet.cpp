#include "src/pipeline/contact_sheet.h"

#include <opencv2/imgproc.hpp>

#include "src/render/camera.h"

namespace zygoma {
namespace {

constexpr int kMargin_px = 6;
constexpr double kTileHeight_mm = 215.0;  // hairline to throat

void write_line(cv::Mat& sheet,
                const std::string& text,
                cv::Point at,
                int width_px,
                double size,
                const cv::Scalar& colour) {
  constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
  int baseline = 0;
  const int needed_px = cv::getTextSize(text, kFont, size, 1, &baseline).width;
  const double fitting = needed_px > width_px ? size * width_px / needed_px : size;
  cv::putText(sheet, text, at, kFont, fitting, colour, 1, cv::LINE_AA);
}

}  // namespace

cv::Mat contact_sheet(const Scene& scene,
                      const std::shared_ptr<const Anatomy>& anatomy,
                      const std::vector<SheetEntry>& entries,
                      const SheetOptions& options,
                      SheetReport& report,
                      StageObserver& observer,
                      const StopQuestion& stop) {
  const int tile_height = options.tile_height_px;
  const int tile_width = tile_height * 4 / 5;
  const int label = tile_height / 7;
  const int num_rows =
      (static_cast<int>(entries.size()) + options.num_columns - 1) / options.num_columns;
  cv::Mat sheet(num_rows * (tile_height + label + kMargin_px) + kMargin_px,
                options.num_columns * (tile_width + kMargin_px) + kMargin_px,
                CV_8UC3,
                cv::Scalar(38, 35, 32));
  Simulator simulator = make_simulator(scene, anatomy);
  Renderer renderer(anatomy, options.render);
  const Camera camera = make_camera(tile_width, tile_height, {0.0, -28.0, 0.0}, kTileHeight_mm);
  std::vector<Vec3> skin_mm;
  cv::Mat tile;
  observer.begin("sheet", static_cast<int>(entries.size()));
  for (int i = 0; i < static_cast<int>(entries.size()); ++i) {
    if (stop && stop()) break;
    const SheetEntry& entry = entries[i];
    const Controls controls = controls_of(entry.pose, *anatomy);
    FaceState state = simulator.rest();
    const SettleReport settled = simulator.settle(controls, state);
    if (!settled.converged) report.not_converged.push_back(entry.title);
    if (settled.inverted_elements > 0) report.inverted.push_back(entry.title);
    embed_skin(*anatomy, state, skin_mm);
    renderer.render(skin_mm, controls.jaw_rad, camera, tile);
    const cv::Point corner(
        kMargin_px + i % options.num_columns * (tile_width + kMargin_px),
        kMargin_px + i / options.num_columns * (tile_height + label + kMargin_px));
    tile.copyTo(sheet(cv::Rect(corner, tile.size())));
    const double size = tile_height / 500.0;
    const cv::Point text = corner + cv::Point(2, tile_height + label * 2 / 5);
    write_line(sheet, entry.title, text, tile_width - 4, size, {235, 232, 228});
    write_line(sheet,
               entry.caption,
               text + cv::Point(0, label * 2 / 5),
               tile_width - 4,
               0.85 * size,
               {165, 162, 158});
    observer.update(i + 1);
  }
  observer.end();
  return sheet;
}

}  // namespace zygoma
