// session.json: what was run on what, and how it went. Everything needed to repeat a run and to
// read its other files (docs/formats.md).
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace zygoma {

inline constexpr const char* kVersion = "0.1.0";  // as in CMakeLists.txt

struct SessionSource {
  std::string file;
  int width_px = 0;  // as shown, rotation applied
  int height_px = 0;
  int num_frames = 0;  // decoded, not claimed
  int rotation_deg = 0;
  double pixel_aspect = 1.0;
  bool time_from_container = true;  // false: index / rate
  double average_frames_per_s = 0.0;
  std::vector<int> repaired_timestamps;
  bool ended_early = false;
};

struct SessionStage {
  std::string name;
  double ms_total = 0.0;
  double ms_per_frame = 0.0;
  std::vector<std::pair<std::string, double>> figures;  // whatever the stage has to say
};

struct Session {
  std::string command;
  std::vector<std::pair<std::string, std::string>> options;  // RunContext::options
  SessionSource source;
  int neutral_frame = -1;  // -1: none
  bool stopped_early = false;
  std::vector<std::string> muscles;
  std::vector<std::string> contours;
  std::vector<SessionStage> stages;
  std::vector<std::pair<std::string, std::string>> libraries;  // name, version
};

// Throws InputError naming the file when it cannot be written.
void write_session(const std::string& path, const Session& session);

}  // namespace zygoma
