#include "src/io/session_file.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "src/io/atomic_file.h"

namespace zygoma {
namespace {

using json = nlohmann::ordered_json;

// JSON knows no infinity and no NaN; what has no value is null.
json number(double value) { return std::isfinite(value) ? json(value) : json(nullptr); }

json source_json(const SessionSource& source) {
  return {{"file", source.file},
          {"width", source.width_px},
          {"height", source.height_px},
          {"frames", source.num_frames},
          {"rotation", source.rotation_deg},
          {"pixel_aspect", number(source.pixel_aspect)},
          {"time_base", source.time_from_container ? "pts" : "index"},
          {"fps_average", number(source.average_frames_per_s)},
          {"repaired_timestamps", source.repaired_timestamps},
          {"ended_early", source.ended_early}};
}

json stage_json(const SessionStage& stage) {
  json result{{"name", stage.name},
              {"ms_total", number(stage.ms_total)},
              {"ms_per_frame", number(stage.ms_per_frame)}};
  for (const auto& [name, value] : stage.figures) result[name] = number(value);
  return result;
}

json text_map(const std::vector<std::pair<std::string, std::string>>& pairs) {
  json result = json::object();
  for (const auto& [name, value] : pairs) result[name] = value;
  return result;
}

}  // namespace

void write_session(const std::string& path, const Session& session) {
  json stages = json::array();
  for (const SessionStage& stage : session.stages) stages.push_back(stage_json(stage));

  json document{{"schema", "zygoma/1"}, {"tool", {{"name", "zygoma"}, {"version", kVersion}}}};
  document["command"] = session.command;
  document["options"] = text_map(session.options);
  document["source"] = source_json(session.source);
  document["units"] = {{"time", "s"},
                       {"length", "px"},
                       {"angle", "rad"},
                       {"contraction", "0..1"},
                       {"sides", "subject"}};
  document["frame_base"] = 0;
  document["neutral_frame"] =
      session.neutral_frame >= 0 ? json(session.neutral_frame) : json(nullptr);
  document["stopped_early"] = session.stopped_early;
  document["muscles"] = session.muscles;
  document["contours"] = session.contours;
  document["stages"] = std::move(stages);
  document["libraries"] = text_map(session.libraries);

  AtomicFile file(path);
  // File names need not be UTF-8, JSON must be.
  file.stream() << document.dump(2, ' ', false, json::error_handler_t::replace) << '\n';
  file.commit();
}

}  // namespace zygoma
