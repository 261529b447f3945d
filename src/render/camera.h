// Pinhole camera and head pose, shared by the renderer and by the synthetic performer that projects
// the true contours with it.
#pragma once

#include <Eigen/Geometry>

#include "face/geometry.h"

namespace zygoma {

// Camera frame: x right, y down, z away from the camera.
struct Camera {
  int width_px = 640;
  int height_px = 360;
  double focal_px = 1200.0;
  Eigen::Isometry3d camera_from_face = Eigen::Isometry3d::Identity();

  Vec2 project(const Vec3& face_mm) const {
    const Vec3 c = camera_from_face * face_mm;
    return {focal_px * c.x() / c.z() + 0.5 * (width_px - 1),
            focal_px * c.y() / c.z() + 0.5 * (height_px - 1)};
  }
};

// Camera that looks at `target_mm` of the face from the front, turned by yaw (positive: the camera
// sees more of the subject's left side) and pitch, at a distance, such that `height_mm` at the
// target fill the picture's height.
Camera make_camera(int width_px,
                   int height_px,
                   const Vec3& target_mm,
                   double height_mm,
                   double distance_mm = 900.0,
                   double yaw_rad = 0.0,
                   double pitch_rad = 0.0);

}  // namespace zygoma
