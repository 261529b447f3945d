// Line and scatter plots as SVG, small enough to read: panels side by side, axes with round ticks,
// every series named beside its end in its own colour instead of in a legend. White panels with
// dark text, so that a page may be light or dark. The same data are the same bytes.
#pragma once

#include <string>
#include <vector>

namespace zygoma {

// A band is the area that its points go around.
enum class PlotMark { kLine, kDashes, kPoints, kBand };

// What is not finite, or not above 0 on a logarithmic axis, is left out and interrupts the line.
struct PlotSeries {
  std::string label;  // empty: none
  std::vector<double> x;
  std::vector<double> y;
  PlotMark mark = PlotMark::kLine;
  int colour = 0;  // of the palette: 0 blue, 1 red, 2 green, 3 purple, 4 grey, 5 brown
  // Of points, written below them, where a front of small values leaves room; empty: none. A point
  // with a name is drawn larger.
  std::vector<std::string> names{};
};

struct PlotAxis {
  std::string label;  // with its unit: "time (s)"
  bool logarithmic = false;
};

struct PlotPanel {
  std::string title;
  PlotAxis x;
  PlotAxis y;
  std::vector<PlotSeries> series;
};

// Marks on an axis that shows low to high: multiples of 1, 2 or 5 times a power of ten, about
// `about` of them and at least two, the outermost at the ends (to a thousandth of a step) or
// beyond. On a logarithmic axis (low > 0) powers of ten, with 2 and 5 between them where there is
// room.
std::vector<double> round_ticks(double low, double high, int about);
std::vector<double> logarithmic_ticks(double low, double high, int about);

// `columns` panels in a row.
std::string svg_plot(const std::vector<PlotPanel>& panels, int columns = 2);

// Throws InputError naming the file when it cannot be written.
void write_svg_plot(const std::string& path, const std::vector<PlotPanel>& panels, int columns = 2);

}  // namespace zygoma
