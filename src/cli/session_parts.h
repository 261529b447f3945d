// Parts of session.json and of the closing lines that several commands share.
#pragma once

#include <string>
#include <vector>

#include "retarget/retarget.h"
#include "src/cli/command.h"
#include "src/io/session_file.h"
#include "src/pipeline/animate_face.h"
#include "src/pipeline/track_video.h"

namespace zygoma {

// Command, options, contours and library versions.
Session begin_session(const std::string& command, const RunContext& context);

SessionSource source_of(const TrackedVideo& tracked);
SessionStage stage_of(const StageFigures& figures);
SessionStage stage_of(const TrackedVideo& tracked);
SessionStage stage_of(const RetargetReport& report, const StageFigures& figures);
SessionStage stage_of(const AnimationReport& report);

// One line per oddity a user should know of (face not in all frames, file cut short, ...).
std::vector<std::string> remarks(const TrackedVideo& tracked);
std::vector<std::string> remarks(const RetargetReport& report);
std::vector<std::string> remarks(const AnimationReport& report);

}  // namespace zygoma
