// From where a face is looked at: named cameras that frame the whole head, whatever its proportions
// and the picture's.
#pragma once

#include <string>
#include <vector>

#include "face/anatomy.h"
#include "src/render/camera.h"

namespace zygoma {

enum class View { kFront, kThreeQuarter, kProfile, kTurntable };

// "front", "three-quarter", "profile", "turntable". Throws InputError naming the text and the
// choices.
View parse_view(const std::string& text);
const std::vector<std::string>& view_names();  // in the order of View
const std::string& view_name(View view);

// Camera of a view: the head at rest from its neck to its crown, with air around. Of the
// sides the subject's left one is seen. `turn`: of the turntable, in whole turns, 0 = front; 0.25
// is the profile.
Camera view_camera(
    View view, const Anatomy& anatomy, int width_px, int height_px, double turn = 0.0);

}  // namespace zygoma
