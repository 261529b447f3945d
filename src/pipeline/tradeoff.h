// What accuracy costs in time, stage by stage: the same work is done with many choices, and each is
// held against a reference that is none of them.
//
//   tissue    a motion settled with more or fewer layers and nodes, other tolerances and solvers,
//             effects; the error is that of the skin people see, against the finest lattice
//   tracker   a clip followed with other landscapes, snakes, predictions and second looks; against
//             the true contours, or without them a tracker that does everything
//   retarget  its contours estimated with the closed form or at three levels of the face model,
//             live or in windows; against the true contractions, or without them the lattice in
//             long windows, solved to the end
//
// Time is processor time of the thread that works: what others do meanwhile hardly counts.
#pragma once

#include <string>
#include <vector>

#include "src/base/stop.h"
#include "src/pipeline/stage_observer.h"

namespace zygoma {

struct TradeoffRow {
  std::string quality;  // the level of --quality that this choice is, or empty
  std::string family;   // what it has in common with others: their colour in the plot
  std::string choice;   // what is set, in words
  double frame_ms = 0.0;
  double error = 0.0;        // against the reference, as the stage says
  double other_error = 0.0;  // as the stage says
  double failed = 0.0;       // share of frames not converged, or of contours lost
  bool is_reference = false;
  bool on_front = false;  // nothing else is both quicker and closer
};

struct TradeoffStage {
  std::string name;
  std::string error_unit;  // "mm"
  std::string error_name;  // "error of the skin, RMS"
  std::string other_name;  // with its unit
  std::string against;     // what the errors are against
  std::vector<TradeoffRow> rows{};
  bool stopped = false;  // with what is done so far
};

// Sorts the rows by time and marks those that no other beats in both; not those that failed in more
// than a frame of twenty.
void find_front(TradeoffStage& stage);

// One table of all stages; a panel for each.
void write_tradeoff_csv(const std::string& path, const std::vector<TradeoffStage>& stages);
void write_tradeoff_plot(const std::string& path, const std::vector<TradeoffStage>& stages);

// The front of a stage in plain text.
std::string front_table(const TradeoffStage& stage);

}  // namespace zygoma
