// contractions.csv: one row per decoded frame, columns by name (docs/formats.md).
#pragma once

#include <string>

#include "face/contractions.h"

namespace zygoma {

void write_contractions_csv(const std::string& path, const ContractionTrack& track);
// Columns are found by name, case-insensitive; unknown ones are ignored. Muscles are the columns
// NAME_L / NAME_R without a known suffix. Missing sigmas are allowed, missing muscles are not a
// matter of this reader. Throws InputError with file, line, column and value.
ContractionTrack read_contractions_csv(const std::string& path);

}  // namespace zygoma
