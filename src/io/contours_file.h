// contours.csv (long form, one row per node: frame,timestamp,contour,node,x,y,confidence,locked)
// and the JSON of contours given by hand (--init).
#pragma once

#include <string>
#include <vector>

#include "tracker/contour_set.h"

namespace zygoma {

// A lost contour is one row with empty node, x and y and confidence 0.
void write_contours_csv(const std::string& path, const std::vector<ContourSet>& contours);
std::vector<ContourSet> read_contours_csv(const std::string& path);

// {"frame": 0, "contours": {"brow_left": [[x, y], ...], ...}}; names from the schema, at least two
// finite points each, any number of points (they are resampled by the reader's caller).
ContourSet read_initial_contours(const std::string& path);

}  // namespace zygoma
