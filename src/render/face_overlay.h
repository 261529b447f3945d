// What the physics knows, laid over the picture of a face:
//
//   lattice   the surface mesh from which the lattice hangs, as lines on the skin
//   muscles   every muscle from its bone end to where it pulls the skin, rings along their
//             course in the skin; the more it contracts, the redder and thicker the
//             line
//   volume    V / V0 - 1 of the tissue below each surface vertex, as false colour
//   strain    the principal strain of largest magnitude in the skin, as false colour: blue where it
//             is pushed together (where furrows form), red where it is stretched
//
// False colours are found per surface vertex and carried to the fine skin by its embedding; a bar
// says what they mean. Use:
//
//   FaceOverlay overlay(parse_overlay("strain"), simulator.anatomy(), simulator.lattice());
//   renderer.render(skin_mm, state.jaw_rad, camera, bgr, overlay.tint(state));
//   overlay.draw(controls, state, camera, bgr);
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "face/simulator.h"
#include "src/render/renderer.h"

namespace zygoma {

enum class Overlay { kNone, kLattice, kMuscles, kVolume, kStrain };

// "none", "lattice", "muscles", "volume", "strain". Throws InputError naming the text and the
// choices.
Overlay parse_overlay(const std::string& text);
const std::vector<std::string>& overlay_names();  // in the order of Overlay

// Relative change of the volume of the tissue below each surface vertex; 0 where there is none.
std::vector<double> volume_change(const Lattice& lattice, const std::vector<Vec3>& positions_mm);

// Principal strain of largest magnitude (stretch - 1) around each surface vertex.
std::vector<double> skin_strain(const SurfaceMesh& rest, const std::vector<Vec3>& positions_mm);

// Where a muscle is drawn: beside a surface vertex, with which it moves. Its skin end, or points
// along a ring.
struct CoursePoint {
  int vertex = 0;
  Vec3 beside_mm{0.0, 0.0, 0.0};
  bool joined = false;  // to the point before
};

class FaceOverlay {
 public:
  // Anatomy and the lattice made from it must outlive the overlay.
  FaceOverlay(Overlay overlay, const Anatomy& anatomy, const Lattice& lattice);

  // For Renderer::render; nullptr if this overlay does not colour the skin. Valid until the next
  // call.
  const SkinTint* tint(const FaceState& state);

  // Lines and the bar over a picture rendered with this camera.
  void draw(const Controls& controls,
            const FaceState& state,
            const Camera& camera,
            cv::Mat& bgr) const;

 private:
  void draw_lattice(const FaceState& state, const Camera& camera, cv::Mat& bgr) const;
  void draw_muscles(const Controls& controls,
                    const FaceState& state,
                    const Camera& camera,
                    cv::Mat& bgr) const;
  void draw_bar(cv::Mat& bgr) const;

  Overlay overlay_;
  const Anatomy& anatomy_;
  const Lattice& lattice_;
  SkinTint tint_;
  std::vector<std::vector<CoursePoint>> course_;  // per muscle
};

}  // namespace zygoma
