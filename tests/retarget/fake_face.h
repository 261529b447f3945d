// A face for tests: plausible contours and muscles that move them by smooth fields, so that
// the estimation can be tested without the physics.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "retarget/head_motion.h"
#include "retarget/response.h"

namespace zygoma::fake {

inline const std::vector<std::string>& muscle_names() {
  static const std::vector<std::string> names{"zygomaticus_major_L",
                                              "zygomaticus_major_R",
                                              "levator_labii_superioris_alaeque_nasi_L",
                                              "levator_labii_superioris_alaeque_nasi_R",
                                              "occipitofrontalis_inner_L",
                                              "occipitofrontalis_inner_R",
                                              "occipitofrontalis_major_L",
                                              "occipitofrontalis_major_R",
                                              "occipitofrontalis_outer_L",
                                              "occipitofrontalis_outer_R",
                                              "corrugator_supercilii_L",
                                              "corrugator_supercilii_R",
                                              "depressor_anguli_oris_L",
                                              "depressor_anguli_oris_R"};
  return names;
}

struct Pull {
  const char* name;
  Point2 at_mm;  // of the left muscle, x to the image's right, y down
  Point2 by_mm;
  double radius_mm;
};

inline const std::vector<Pull>& pulls() {
  static const std::vector<Pull> all{
      {"zygomaticus_major", {27.0, 76.0}, {7.0, -9.0}, 30.0},
      {"levator_labii_superioris_alaeque_nasi", {16.0, 44.0}, {-1.0, -7.0}, 18.0},
      {"occipitofrontalis_inner", {10.0, -18.0}, {0.0, -10.0}, 20.0},
      {"occipitofrontalis_major", {34.0, -22.0}, {0.0, -10.0}, 20.0},
      {"occipitofrontalis_outer", {54.0, -18.0}, {1.0, -8.0}, 20.0},
      {"corrugator_supercilii", {20.0, -18.0}, {-5.0, 5.0}, 20.0},
      {"depressor_anguli_oris", {27.0, 78.0}, {3.0, 9.0}, 26.0},
  };
  return all;
}

inline Point2 rest_point(int contour, double s) {
  const double side = contour == kBrowRightContour || contour == kFurrowRightContour ? -1.0 : 1.0;
  const double arch = std::sin(3.14159265 * s);
  if (contour == kBrowLeftContour || contour == kBrowRightContour) {
    return {side * (10.0 + 44.0 * s), -16.0 - 6.0 * arch};
  }
  if (contour == kFurrowLeftContour || contour == kFurrowRightContour) {
    return {side * (16.0 + 16.0 * s), 40.0 + 30.0 * s};
  }
  const double x = 2.0 * s - 1.0;
  if (contour == kNoseTipContour) return {16.0 * x, 44.0 + 4.0 * arch};
  if (contour == kUpperLipContour) return {27.0 * x, 76.0 - 8.0 * arch};
  if (contour == kLowerLipContour) return {27.0 * x, 76.0 + 10.0 * arch};
  if (contour == kChinBossContour) return {25.0 * x, 112.0 + 8.0 * arch};
  if (is_eyelid(contour)) {
    return {contour == kEyelidLeftContour ? 18.0 + 28.0 * s : -18.0 - 28.0 * s, -6.0 * arch};
  }
  return {60.0 * x, -70.0 - 16.0 * arch};
}

inline double depth(const Point2& p) {
  const double nose = std::exp(-(p - Point2(0.0, 44.0)).squaredNorm() / 400.0);
  return 20.0 - 0.008 * p.squaredNorm() * 0.7 + 20.0 * nose;
}

inline FaceResponse make_face() {
  FaceResponse face = FaceResponse::zero(muscle_names());
  face.has_contour.fill(true);
  for (int c = 0; c < kNumContours; ++c) {
    for (int k = 0; k < num_nodes(c); ++k) {
      const Point2 p = rest_point(c, static_cast<double>(k) / (num_nodes(c) - 1));
      const int node = node_begin(c) + k;
      face.rest_mm.col(node) = p;
      face.rest_depth_mm[node] = depth(p);
      for (int i = 0; i < face.num_muscles(); ++i) {
        const std::string& name = face.muscles[static_cast<std::size_t>(i)];
        const double side = name.back() == 'L' ? 1.0 : -1.0;
        const auto pull = std::find_if(pulls().begin(), pulls().end(), [&](const Pull& f) {
          return name.compare(0, name.size() - 2, f.name) == 0;
        });
        const Point2 at(side * pull->at_mm.x(), pull->at_mm.y());
        const double share =
            std::exp(-(p - at).squaredNorm() / (pull->radius_mm * pull->radius_mm));
        const bool rigid = c == kNoseTipContour || c == kHairlineContour || is_eyelid(c);
        const Point2 full =
            (rigid ? 0.05 : share) * Point2(side * pull->by_mm.x(), pull->by_mm.y());
        face.linear_mm.col(i).segment<2>(2 * node) = 1.2 * full;
        face.quadratic_mm.col(i).segment<2>(2 * node) = -0.2 * full;
      }
      const double below = std::clamp((p.y() - 74.0) / 30.0, 0.0, 1.0);
      const double lip = c == kUpperLipContour ? 0.0 : below;
      face.linear_mm.rightCols<1>().segment<2>(2 * node) = Point2(0.0, 28.0 * lip);
      face.quadratic_mm.rightCols<1>().segment<2>(2 * node) = Point2(0.0, -3.0 * lip);
    }
  }
  return face;
}

// Another person with the same muscles: stretched shape and motions.
inline FaceResponse make_other_face(double wider, double taller, double lower_chin_mm) {
  FaceResponse face = make_face();
  for (int k = 0; k < kNumNodes; ++k) {
    face.rest_mm(0, k) *= wider;
    face.rest_mm(1, k) *= taller;
    if (k >= node_begin(kChinBossContour) && k <= last_node(kChinBossContour)) {
      face.rest_mm(1, k) += lower_chin_mm;
    }
    for (Eigen::MatrixXd* part : {&face.linear_mm, &face.quadratic_mm}) {
      part->row(2 * k) *= wider;
      part->row(2 * k + 1) *= taller;
    }
  }
  return face;
}

// What a perfect tracker would see.
inline ContourSet observe(const FaceResponse& face,
                          const Eigen::VectorXd& controls,
                          const HeadMotion& px_from_mm,
                          int frame_index,
                          double time_s) {
  ContourSet set;
  set.frame_index = frame_index;
  set.time_s = time_s;
  for (int c = 0; c < kNumContours; ++c) {
    Contour contour;
    contour.name = kFeatureSchema[static_cast<std::size_t>(c)].name;
    contour.confidence = 1.0;
    for (int k = node_begin(c); k < node_begin(c + 1); ++k) {
      contour.points_px.push_back(
          px_from_mm * Point2(face.rest_mm.col(k) + face.displacement(k, controls.data())));
    }
    set.contours.push_back(contour);
  }
  return set;
}

inline HeadMotion camera(double px_per_mm,
                         double roll_rad = 0.0,
                         const Point2& at_px = {320.0, 150.0}) {
  HeadMotion motion;
  motion.a = px_per_mm * std::cos(roll_rad);
  motion.b = px_per_mm * std::sin(roll_rad);
  motion.shift = at_px;
  return motion;
}

}  // namespace zygoma::fake
