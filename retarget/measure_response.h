// Asks the face model itself how its contours respond: the one place where the estimation meets the
// physics. One exact sensitivity at rest; per group of muscles that hardly share skin, and for the
// jaw, two settles (their saturation) and one sensitivity at half strength (the correctives of
// their pairs with all others).
#pragma once

#include "face/simulator.h"
#include "retarget/response.h"
#include "src/base/stop.h"

namespace zygoma {

struct ResponseOptions {
  double viewing_distance_mm = 900.0;  // of the performer's camera, [200, 1e6]; too small a value
                                       // exaggerates what moves near the camera
  double overlap = 0.15;  // [0, 1]; full contractions of muscles that share less than this of
                          // their motion are settled together. 0: one settle per muscle (slow);
                          // 1: all at once (their saturations mix)

  void check() const;
};

// Asks the face itself: one sensitivity at rest, a handful of settles. Throws InputError when the
// anatomy has none of the schema's curves. When `stop` says so no further settle is begun; what
// comes back then lacks the rest and is of no use.
FaceResponse measure_response(Simulator& face,
                              const ResponseOptions& options = {},
                              const StopQuestion& stop = {});

}  // namespace zygoma
