#include "src/cli/session_parts.h"

#include "src/io/library_versions.h"
#include "tracker/feature_schema.h"

namespace zygoma {
namespace {

std::string plural(int count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

}  // namespace

Session begin_session(const std::string& command, const RunContext& context) {
  Session session;
  session.command = command;
  session.options = context.options;
  for (const Feature& feature : kFeatureSchema) session.contours.emplace_back(feature.name);
  session.libraries = library_versions();
  return session;
}

SessionSource source_of(const TrackedVideo& tracked) {
  SessionSource source;
  source.file = tracked.info.path;
  source.width_px = tracked.info.width_px;
  source.height_px = tracked.info.height_px;
  source.num_frames = static_cast<int>(tracked.contours.size());
  source.rotation_deg = tracked.info.rotation_deg;
  source.pixel_aspect = tracked.info.pixel_aspect;
  source.time_from_container = tracked.time_from_container;
  source.average_frames_per_s = tracked.info.average_frames_per_s;
  source.repaired_timestamps = tracked.repaired_timestamps;
  source.ended_early = tracked.ended_early;
  return source;
}

SessionStage stage_of(const StageFigures& figures) {
  return {figures.name, figures.total_ms, figures.frame_ms(), {}};
}

SessionStage stage_of(const TrackedVideo& tracked) {
  SessionStage stage = stage_of(tracked.figures);
  stage.figures.emplace_back("frames_with_face", tracked.frames_with_face);
  stage.figures.emplace_back("contours_corrected", tracked.contours_corrected);
  return stage;
}

SessionStage stage_of(const RetargetReport& report, const StageFigures& figures) {
  SessionStage stage = stage_of(figures);
  stage.figures.emplace_back("frames_estimated", report.frames_estimated);
  stage.figures.emplace_back("frames_not_converged", report.frames_not_converged);
  stage.figures.emplace_back("response_not_converged", report.response_not_converged);
  stage.figures.emplace_back("median_residual_px", report.median_residual_px);
  stage.figures.emplace_back("face_unit_px", report.face_unit_px);
  stage.figures.emplace_back("millimetre_per_px", report.millimetre_per_px);
  return stage;
}

SessionStage stage_of(const AnimationReport& report) {
  SessionStage stage = stage_of(report.figures);
  stage.figures.emplace_back("settle_ms_per_frame", report.settle_figures.frame_ms());
  stage.figures.emplace_back("render_ms_per_frame", report.render_figures.frame_ms());
  stage.figures.emplace_back("frames_not_converged", report.frames_not_converged);
  stage.figures.emplace_back("most_inverted_elements", report.most_inverted_elements);
  stage.figures.emplace_back("largest_mean_volume_change", report.largest_volume_change);
  return stage;
}

std::vector<std::string> remarks(const TrackedVideo& tracked) {
  std::vector<std::string> lines;
  const int num_frames = static_cast<int>(tracked.contours.size());
  if (tracked.frames_with_face < num_frames) {
    lines.push_back("no face in " + plural(num_frames - tracked.frames_with_face, "frame") +
                    " of " + std::to_string(num_frames));
  }
  if (tracked.ended_early) {
    lines.push_back(tracked.info.path + ": ends after " + plural(num_frames, "frame") +
                    ", the file claims about " + std::to_string(tracked.info.about_num_frames) +
                    "; the rest cannot be decoded");
  }
  if (!tracked.time_from_container) {
    lines.push_back(tracked.info.path + ": has no time stamps; times are frame / rate");
  }
  return lines;
}

std::vector<std::string> remarks(const RetargetReport& report) {
  std::vector<std::string> lines;
  if (report.frames_not_converged > 0) {
    lines.push_back("the refinement did not converge in " +
                    plural(report.frames_not_converged, "frame"));
  }
  if (report.response_not_converged > 0) {
    lines.push_back("the face did not settle fully " +
                    plural(report.response_not_converged, "time") +
                    " while its response was measured");
  }
  return lines;
}

std::vector<std::string> remarks(const AnimationReport& report) {
  std::vector<std::string> lines;
  if (report.frames_not_converged > 0) {
    lines.push_back("the face did not settle fully in " +
                    plural(report.frames_not_converged, "frame"));
  }
  if (report.most_inverted_elements > 0) {
    lines.push_back("up to " + plural(report.most_inverted_elements, "tissue element") +
                    " turned inside out in a frame");
  }
  return lines;
}

}  // namespace zygoma
