#include "src/render/camera.h"

#include <cassert>

namespace zygoma {

Camera make_camera(int width_px,
                   int height_px,
                   const Vec3& target_mm,
                   double height_mm,
                   double distance_mm,
                   double yaw_rad,
                   double pitch_rad) {
  assert(width_px > 0 && height_px > 0 && height_mm > 0.0 && distance_mm > 0.0);
  Camera camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.focal_px = height_px * distance_mm / height_mm;
  // From the front the camera's axes are the face's with y and z turned around.
  Eigen::Matrix3d front;
  front << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  // Moving the camera to the subject's left turns the face the other way in front of it.
  const Eigen::Matrix3d turn =
      (Eigen::AngleAxisd(pitch_rad, Vec3::UnitX()) * Eigen::AngleAxisd(-yaw_rad, Vec3::UnitY()))
          .toRotationMatrix();
  camera.camera_from_face.linear() = front * turn;
  camera.camera_from_face.translation() =
      Vec3(0.0, 0.0, distance_mm) - camera.camera_from_face.linear() * target_mm;
  return camera;
}

}  // namespace zygoma
