#include "src/pipeline/tradeoff.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <map>

#include "src/io/atomic_file.h"
#include "src/io/svg_plot.h"
#include "src/io/text.h"

namespace zygoma {
namespace {

constexpr double kMostFailed = 0.05;

PlotPanel panel_of(const TradeoffStage& stage) {
  constexpr int kGrey = 4;
  PlotSeries front{"", {}, {}, PlotMark::kLine, kGrey};
  std::map<std::string, PlotSeries> families;  // by name: the same colours whatever is quicker
  for (const TradeoffRow& row : stage.rows) families[row.family].label = row.family;
  int colour = 0;
  for (auto& [name, series] : families) {
    series.mark = PlotMark::kPoints;
    series.colour = colour++;
    if (colour == kGrey) ++colour;
  }
  std::string against = stage.against;
  for (const TradeoffRow& row : stage.rows) {
    if (row.is_reference) {
      against += ", ";
      append_fixed(against, row.frame_ms, 0);
      against += " ms";
    }
    if (row.on_front) {
      front.x.push_back(row.frame_ms);
      front.y.push_back(row.error);
    }
    PlotSeries& family = families[row.family];
    family.x.push_back(row.frame_ms);
    family.y.push_back(row.error);
    family.names.push_back(row.quality.starts_with("between") ? "" : row.quality);
  }
  PlotPanel panel{stage.name + ", against " + against,
                  {"processor time per frame (ms)", true},
                  {stage.error_name + " (" + stage.error_unit + ")", true},
                  {front}};
  for (const auto& [name, series] : families) panel.series.push_back(series);
  return panel;
}

}  // namespace

void find_front(TradeoffStage& stage) {
  std::stable_sort(stage.rows.begin(), stage.rows.end(), [](const auto& a, const auto& b) {
    return a.frame_ms < b.frame_ms;
  });
  double closest = std::numeric_limits<double>::infinity();
  for (TradeoffRow& row : stage.rows) {
    row.on_front = row.failed <= kMostFailed && row.error < closest;
    if (row.on_front) closest = row.error;
  }
}

void write_tradeoff_csv(const std::string& path, const std::vector<TradeoffStage>& stages) {
  std::string text =
      "stage,quality,family,choice,ms_per_frame,error,unit,other_error,other,failed,is_reference,"
      "on_front\n";
  const auto cell = [&](double value, int decimals) {
    text += ',';
    append_fixed(text, value, decimals);
  };
  for (const TradeoffStage& stage : stages) {
    for (const TradeoffRow& row : stage.rows) {
      text += stage.name + ',' + row.quality + ',' + row.family + ',' + row.choice;
      cell(row.frame_ms, 4);
      cell(row.error, 4);
      text += ',' + stage.error_unit;
      cell(row.other_error, 4);
      text += ',' + stage.other_name;
      cell(row.failed, 4);
      text += row.is_reference ? ",1" : ",0";
      text += row.on_front ? ",1\n" : ",0\n";
    }
  }
  AtomicFile file(path);
  file.stream() << text;
  file.commit();
}

void write_tradeoff_plot(const std::string& path, const std::vector<TradeoffStage>& stages) {
  std::vector<PlotPanel> panels;
  for (const TradeoffStage& stage : stages) {
    if (!stage.rows.empty()) panels.push_back(panel_of(stage));
  }
  if (!panels.empty()) write_svg_plot(path, panels, 2);
}

std::string front_table(const TradeoffStage& stage) {
  std::string table = stage.name + ", against " + stage.against + " (front only)\n";
  char line[200];
  std::snprintf(line,
                sizeof line,
                "  %-10s %-46s %9s %12s  %s\n",
                "quality",
                "choice",
                "ms/frame",
                ("error, " + stage.error_unit).c_str(),
                stage.other_name.c_str());
  table += line;
  for (const TradeoffRow& row : stage.rows) {
    if (!row.on_front && !row.is_reference) continue;
    std::snprintf(line,
                  sizeof line,
                  "  %-10s %-46s %9.2f %12.4f  %.3f\n",
                  row.is_reference ? "reference" : row.quality.c_str(),
                  (row.family + ", " + row.choice).c_str(),
                  row.frame_ms,
                  row.error,
                  row.other_error);
    table += line;
  }
  return table;
}

}  // namespace zygoma
