// Renders a face with Embree: smooth normals, albedo texture, key, fill and rim light with soft
// shading, ambient occlusion; deterministic, same bits for 1 and N threads.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "face/anatomy.h"
#include "src/render/camera.h"

namespace zygoma {

struct Lighting {
  Vec3 key_direction{-0.5, 0.6, 0.9};  // towards the light, face frame of the camera's front view
  double key = 1.0;                    // intensities, 1 = default
  double fill = 1.0;
  double rim = 1.0;
  double ambient = 1.0;
  Eigen::Vector3f background_top{0.30F, 0.32F, 0.36F};  // sRGB
  Eigen::Vector3f background_bottom{0.14F, 0.15F, 0.17F};
};

struct RenderOptions {
  int samples_per_pixel = 2;  // at silhouettes and feature edges; 1 = no anti-aliasing
  bool shadows = true;
  int num_threads = 2;
  Lighting lighting;
};

// Colour laid over the skin's own, per vertex of the skin: linear RGB and opacity.
using SkinTint = std::vector<Eigen::Vector4f>;

class Renderer {
 public:
  explicit Renderer(std::shared_ptr<const Anatomy> anatomy, const RenderOptions& options = {});
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  // Draws the skin at `skin_mm` (order of Anatomy::skin) with the mandible's parts at `jaw_rad`
  // into `bgr` (8-bit, camera size; reallocated only when the size differs).
  void render(const std::vector<Vec3>& skin_mm,
              double jaw_rad,
              const Camera& camera,
              cv::Mat& bgr,
              const SkinTint* tint = nullptr);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace zygoma
