#include "src/io/motion_file.h"

#include <algorithm>

#include "src/io/atomic_file.h"
#include "src/io/text.h"

namespace zygoma {
namespace {

void append_cell(std::string& text, double value, int decimals) {
  text += ',';
  append_fixed(text, value, decimals);
}

void append_cell(std::string& text, int value) {
  text += ',';
  append_integer(text, value);
}

void write_whole(const std::string& path, const std::string& text) {
  AtomicFile file(path);
  file.stream() << text;
  file.commit();
}

}  // namespace

void write_motion_csv(const std::string& path, const std::vector<MotionRow>& rows) {
  std::string text =
      "frame,timestamp,converged,iterations,factorisations,residual,inverted_elements,"
      "mean_volume_change,moving_share,solved,substeps,restores,largest_mm,rms_mm,ms\n";
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const MotionRow& row = rows[k];
    append_integer(text, static_cast<long long>(k));
    append_cell(text, row.time_s, 6);
    append_cell(text, row.settle.converged ? 1 : 0);
    append_cell(text, row.settle.iterations);
    append_cell(text, row.settle.factorisations);
    append_cell(text, row.settle.residual, 10);
    append_cell(text, row.settle.inverted_elements);
    append_cell(text, row.settle.mean_volume_change, 6);
    append_cell(text, row.settle.moving_share, 4);
    append_cell(text, row.settle.solved ? 1 : 0);
    append_cell(text, row.settle.substeps);
    append_cell(text, row.settle.restores);
    append_cell(text, row.largest_mm, 4);
    append_cell(text, row.rms_mm, 4);
    append_cell(text, row.ms, 3);
    text += '\n';
  }
  write_whole(path, text);
}

std::string text_of(const std::vector<std::pair<int, int>>& frames) {
  std::string text;
  for (const auto& [first, last] : frames) {
    if (!text.empty()) text += ' ';
    text += std::to_string(first);
    if (last > first) text += "-" + std::to_string(last);
  }
  return text;
}

void write_effect_stories_csv(const std::string& path, const std::vector<EffectStory>& stories) {
  std::string text =
      "effect,in_scene,frames_on,ranges,ms_with,ms_without,largest_mm,rms_mm,could_change_mm,why\n";
  for (const EffectStory& story : stories) {
    text += story.effect;
    append_cell(text, story.in_scene ? 1 : 0);
    append_cell(text, story.num_frames);
    text += "," + text_of(story.frames);
    append_cell(text, story.ms_with, 3);
    append_cell(text, story.ms_without, 3);
    append_cell(text, story.largest_mm, 4);
    append_cell(text, story.rms_mm, 4);
    append_cell(text, story.could_change_mm, 4);
    std::string why = story.why;
    std::replace(why.begin(), why.end(), ',', ';');  // a cell has no commas
    text += "," + why + "\n";
  }
  write_whole(path, text);
}

void write_effects_csv(const std::string& path, const std::vector<EffectRow>& rows) {
  std::string text =
      "effect,in_scene,ms_with,ms_without,not_converged_with,not_converged_without,"
      "largest_mm,rms_mm\n";
  for (const EffectRow& row : rows) {
    text += row.effect;
    append_cell(text, row.in_scene ? 1 : 0);
    append_cell(text, row.ms_with, 3);
    append_cell(text, row.ms_without, 3);
    append_cell(text, row.not_converged_with);
    append_cell(text, row.not_converged_without);
    append_cell(text, row.largest_mm, 4);
    append_cell(text, row.rms_mm, 4);
    text += '\n';
  }
  write_whole(path, text);
}

}  // namespace zygoma
