#include "src/io/svg_plot.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <string_view>

#include "src/io/atomic_file.h"
#include "src/io/text.h"

namespace zygoma {
namespace {

// Pixels.
constexpr double kPlotWidth = 300.0;
constexpr double kPlotHeight = 230.0;
constexpr double kTextSize = 12.0;
constexpr double kCharacter = 0.58 * kTextSize;  // width of a wide letter in common sans fonts
constexpr double kLabelSpacing = 1.25 * kTextSize;
constexpr double kTop = 34.0;          // title
constexpr double kBottom = 46.0;       // tick labels and name of the axis
constexpr double kGap = 14.0;          // between text and what it belongs to, and around everything
constexpr double kSmallestMove = 0.3;  // points closer than this to the last one are not drawn

constexpr std::array<const char*, 6> kPalette{
    "#1f5fa8", "#c0392b", "#1e7d4f", "#7b3fa0", "#555555", "#8a5a14"};

// Characters, not bytes: labels may be UTF-8.
double text_width(std::string_view text) {
  const auto count = std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) >> 6) != 2; });
  return kCharacter * static_cast<double>(count);
}

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '&') {
      result += "&amp;";
    } else if (c == '<') {
      result += "&lt;";
    } else if (c == '>') {
      result += "&gt;";
    } else {
      result += c;
    }
  }
  return result;
}

std::string px(double value) {
  std::string text;
  append_fixed(text, value, 1);
  return text;
}

std::string line(double x1, double y1, double x2, double y2, const std::string& style) {
  return "<path d=\"M" + px(x1) + ' ' + px(y1) + 'L' + px(x2) + ' ' + px(y2) + "\" " + style +
         "/>\n";
}

// `style`: further attributes.
std::string text_at(double x, double y, const std::string& words, const std::string& style) {
  return "<text x=\"" + px(x) + "\" y=\"" + px(y) + "\" " + style + ">" + escaped(words) +
         "</text>\n";
}

struct Scale {
  bool logarithmic = false;
  double low = 0.0;  // of the axis; as logarithms where it is logarithmic
  double high = 1.0;
  std::vector<double> ticks;

  bool shows(double value) const { return std::isfinite(value) && (!logarithmic || value > 0.0); }
  // 0 to 1 along the axis.
  double share(double value) const {
    return ((logarithmic ? std::log10(value) : value) - low) / (high - low);
  }
};

template <typename Values>
Scale scale_of(const PlotAxis& axis, const std::vector<PlotSeries>& series, const Values& values) {
  Scale scale;
  scale.logarithmic = axis.logarithmic;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const PlotSeries& one : series) {
    for (const double value : values(one)) {
      if (!scale.shows(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  if (low > high) low = high = 1.0;
  constexpr int kTicks = 5;
  scale.ticks =
      scale.logarithmic ? logarithmic_ticks(low, high, kTicks) : round_ticks(low, high, kTicks);
  scale.low = scale.logarithmic ? std::log10(scale.ticks.front()) : scale.ticks.front();
  scale.high = scale.logarithmic ? std::log10(scale.ticks.back()) : scale.ticks.back();
  return scale;
}

// As short as all ticks of an axis allow.
std::string tick_text(const Scale& scale, double value) {
  std::string text;
  const double size = std::abs(value);
  if (size != 0.0 && (size >= 1e5 || (scale.logarithmic && size < 1e-3))) {
    const double power = std::floor(std::log10(size) + 1e-9);
    append_fixed(text, value / std::pow(10.0, power), 0);
    text += 'e';
    append_integer(text, static_cast<long long>(power));
    return text;
  }
  const double step = scale.logarithmic ? value : scale.ticks[1] - scale.ticks[0];
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
  append_fixed(text, value, decimals);
  return text;
}

// Moves places apart to a spacing, within bounds and in the order they have, as little as possible.
void spread(std::vector<double>& places, double low, double high, double spacing) {
  std::vector<std::size_t> order(places.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::stable_sort(
      order.begin(), order.end(), [&](auto a, auto b) { return places[a] < places[b]; });
  // Neighbours push each other half the way; the ends hold.
  constexpr int kRounds = 200;
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t k = 0; k + 1 < order.size(); ++k) {
      double& above = places[order[k]];
      double& below = places[order[k + 1]];
      const double push = 0.5 * (spacing - (below - above));
      if (push <= 0.0) continue;
      above -= push;
      below += push;
    }
    for (double& place : places) place = std::clamp(place, low, high);
  }
}

class PanelDrawing {
 public:
  explicit PanelDrawing(const PlotPanel& panel)
      : panel_(panel),
        x_(scale_of(panel.x, panel.series, [](const PlotSeries& s) { return s.x; })),
        y_(scale_of(panel.y, panel.series, [](const PlotSeries& s) { return s.y; })) {
    double widest = 0.0;
    for (const double tick : y_.ticks) widest = std::max(widest, text_width(tick_text(y_, tick)));
    left_ = kGap + kLabelSpacing + widest + 10.0;
    for (const PlotSeries& series : panel.series) {
      right_ = std::max(right_, kGap + 12.0 + text_width(series.label));
    }
  }

  double width() const { return left_ + kPlotWidth + right_; }
  static double height() { return kTop + kPlotHeight + kBottom; }

  std::string draw(double x, double y) {
    origin_x_ = x + left_;
    origin_y_ = y + kTop;
    svg_.clear();
    names_.clear();
    name_texts_.clear();
    draw_axes();
    for (const PlotSeries& series : panel_.series) draw_series(series);
    svg_ += name_texts_;
    draw_labels();
    return svg_;
  }

 private:
  double at_x(double value) const { return origin_x_ + kPlotWidth * x_.share(value); }
  double at_y(double value) const { return origin_y_ + kPlotHeight * (1.0 - y_.share(value)); }
  static std::string colour(const PlotSeries& series) {
    return kPalette[series.colour % kPalette.size()];
  }

  void draw_axes() {
    const double bottom = origin_y_ + kPlotHeight;
    const double right = origin_x_ + kPlotWidth;
    const std::string grid = R"(stroke="#e4e4e4")";
    const std::string axis = R"(stroke="#333")";
    for (const double tick : x_.ticks) {
      svg_ += line(at_x(tick), origin_y_, at_x(tick), bottom, grid);
      svg_ += text_at(at_x(tick), bottom + 17.0, tick_text(x_, tick), R"(text-anchor="middle")");
    }
    for (const double tick : y_.ticks) {
      svg_ += line(origin_x_, at_y(tick), right, at_y(tick), grid);
      svg_ +=
          text_at(origin_x_ - 7.0, at_y(tick) + 4.0, tick_text(y_, tick), R"(text-anchor="end")");
    }
    if (!y_.logarithmic && y_.low < 0.0 && y_.high > 0.0) {
      svg_ += line(origin_x_, at_y(0.0), right, at_y(0.0), R"(stroke="#999")");
    }
    svg_ += line(origin_x_, origin_y_, origin_x_, bottom, axis);
    svg_ += line(origin_x_, bottom, right, bottom, axis);
    svg_ += text_at(
        0.5 * (origin_x_ + right), bottom + 37.0, panel_.x.label, R"(text-anchor="middle")");
    const double name_x = origin_x_ - left_ + kGap + 0.8 * kTextSize;
    const double name_y = 0.5 * (origin_y_ + bottom);
    svg_ += text_at(
        name_x,
        name_y,
        panel_.y.label,
        R"(text-anchor="middle" transform="rotate(-90 )" + px(name_x) + ' ' + px(name_y) + ")\"");
    svg_ += text_at(origin_x_, origin_y_ - 13.0, panel_.title, R"(font-weight="bold")");
  }

  bool shows(const PlotSeries& series, std::size_t k) const {
    return x_.shows(series.x[k]) && y_.shows(series.y[k]);
  }

  void draw_point(const PlotSeries& series, std::size_t k) {
    const bool named = k < series.names.size() && !series.names[k].empty();
    svg_ += "<circle cx=\"" + px(at_x(series.x[k])) + "\" cy=\"" + px(at_y(series.y[k])) +
            "\" r=\"" + (named ? "4.4" : "2.6") + "\" fill=\"" + colour(series) + "\"/>\n";
    if (named) name_point(at_x(series.x[k]), at_y(series.y[k]), series.names[k]);
  }

  // Below the point, further down where another name is already; above it where that leaves the
  // plot.
  void name_point(double x, double y, const std::string& name) {
    const double half = 0.5 * text_width(name);
    const double lowest = origin_y_ + kPlotHeight - 4.0;
    NamePlace place{std::clamp(x, origin_x_ + half, origin_x_ + kPlotWidth - half),
                    std::min(y + 19.0, lowest),
                    half};
    const auto hits = [&](const NamePlace& other) {
      return std::abs(place.x - other.x) < place.half + other.half + 4.0 &&
             std::abs(place.y - other.y) < kLabelSpacing;
    };
    while (std::any_of(names_.begin(), names_.end(), hits)) place.y += kLabelSpacing;
    if (place.y > lowest) {
      place.y = y - 11.0;
      while (std::any_of(names_.begin(), names_.end(), hits)) place.y -= kLabelSpacing;
    }
    names_.push_back(place);
    // On a white rim, as it may lie on lines and other points.
    name_texts_ +=
        text_at(place.x,
                place.y,
                name,
                R"(font-weight="bold" text-anchor="middle" paint-order="stroke" stroke="#fff" )"
                R"(stroke-width="3")");
  }

  void draw_series(const PlotSeries& series) {
    assert(series.x.size() == series.y.size());
    if (series.mark == PlotMark::kPoints) {
      for (std::size_t k = 0; k < series.x.size(); ++k) {
        if (!shows(series, k)) continue;
        draw_point(series, k);
      }
      return;
    }
    std::string path;
    bool open = false;
    double last_x = 0.0;
    double last_y = 0.0;
    for (std::size_t k = 0; k < series.x.size(); ++k) {
      if (!shows(series, k)) {
        open = false;
        continue;
      }
      const double x = at_x(series.x[k]);
      const double y = at_y(series.y[k]);
      const bool ends = k + 1 == series.x.size() || !shows(series, k + 1);
      if (open && !ends && std::hypot(x - last_x, y - last_y) < kSmallestMove) continue;
      path += (open ? 'L' : 'M') + px(x) + ' ' + px(y);
      open = true;
      last_x = x;
      last_y = y;
    }
    if (path.empty()) return;
    if (series.mark == PlotMark::kBand) {
      svg_ += "<path d=\"" + path + "Z\" fill=\"" + colour(series) + "\" fill-opacity=\"0.18\"/>\n";
      return;
    }
    svg_ += "<path d=\"" + path +
            "\" fill=\"none\" stroke-linejoin=\"round\" stroke-width=\"1.8\"" +
            (series.mark == PlotMark::kDashes ? " stroke-dasharray=\"6 4\"" : "") + " stroke=\"" +
            colour(series) + "\"/>\n";
  }

  // Beside the right edge, at the height of the rightmost point of its series.
  void draw_labels() {
    std::vector<const PlotSeries*> labelled;
    std::vector<std::array<double, 2>> ends;
    std::vector<double> places;
    for (const PlotSeries& series : panel_.series) {
      if (series.label.empty()) continue;
      std::array<double, 2> end{-1.0, 0.0};
      for (std::size_t k = 0; k < series.x.size(); ++k) {
        if (shows(series, k) && at_x(series.x[k]) > end[0]) {
          end = {at_x(series.x[k]), at_y(series.y[k])};
        }
      }
      if (end[0] < 0.0) continue;
      labelled.push_back(&series);
      ends.push_back(end);
      places.push_back(end[1]);
    }
    spread(places, origin_y_, origin_y_ + kPlotHeight, kLabelSpacing);
    const double x = origin_x_ + kPlotWidth + 12.0;
    for (std::size_t k = 0; k < labelled.size(); ++k) {
      const std::string ink = colour(*labelled[k]);
      svg_ += line(ends[k][0] + 2.0,
                   ends[k][1],
                   x - 2.0,
                   places[k],
                   "stroke=\"" + ink + "\" stroke-width=\"0.7\" stroke-opacity=\"0.6\"");
      svg_ += text_at(x, places[k] + 4.0, labelled[k]->label, "fill=\"" + ink + "\"");
    }
  }

  struct NamePlace {
    double x, y, half;  // middle, baseline, half the width
  };

  const PlotPanel& panel_;
  std::vector<NamePlace> names_;
  std::string name_texts_;
  Scale x_;
  Scale y_;
  double left_ = 0.0;
  double right_ = kGap;
  double origin_x_ = 0.0;
  double origin_y_ = 0.0;
  std::string svg_;
};

}  // namespace

std::vector<double> round_ticks(double low, double high, int about) {
  if (!(high > low)) {  // one value, or none: show its surroundings
    const double around = low == 0.0 ? 1.0 : 0.5 * std::abs(low);
    low -= around;
    high += around;
  }
  const double wanted = (high - low) / about;
  const double power = std::pow(10.0, std::floor(std::log10(wanted)));
  double step = 10.0 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * power >= 0.75 * wanted) step = factor * power;
  }
  constexpr double kRounding = 1e-3;  // of a step: less than a pixel beyond the last tick
  const double first = std::floor(low / step + kRounding);
  const double last = std::ceil(high / step - kRounding);
  std::vector<double> ticks;
  for (double k = first; k <= last; k += 1.0) ticks.push_back(k * step);
  return ticks;
}

std::vector<double> logarithmic_ticks(double low, double high, int about) {
  constexpr double kRounding = 1e-9;
  const int first = static_cast<int>(std::floor(std::log10(low) + kRounding));
  const int last = std::max(first + 1, static_cast<int>(std::ceil(std::log10(high) - kRounding)));
  const int every = std::max(1, (last - first) / about);  // decades between two ticks
  std::vector<double> ticks;
  for (int decade = first; decade < last + every; decade += every) {
    const double power = std::pow(10.0, decade);
    ticks.push_back(power);
    if (2 * (last - first) > about || decade == last) continue;
    for (const double factor : {2.0, 5.0}) ticks.push_back(factor * power);
  }
  // Nothing beyond the first tick outside of the data.
  while (ticks.size() > 2 && ticks[ticks.size() - 2] >= high * (1.0 - kRounding)) ticks.pop_back();
  while (ticks.size() > 2 && ticks[1] <= low * (1.0 + kRounding)) ticks.erase(ticks.begin());
  return ticks;
}

std::string svg_plot(const std::vector<PlotPanel>& panels, int columns) {
  assert(!panels.empty() && columns >= 1);
  std::vector<PanelDrawing> drawings(panels.begin(), panels.end());
  // Panels below each other have the same width.
  const std::size_t num_columns = std::min(panels.size(), static_cast<std::size_t>(columns));
  std::vector<double> width(num_columns, 0.0);
  for (std::size_t k = 0; k < panels.size(); ++k) {
    width[k % num_columns] = std::max(width[k % num_columns], drawings[k].width());
  }
  double total = kGap;
  for (const double one : width) total += one;
  const std::size_t num_rows = (panels.size() + num_columns - 1) / num_columns;
  const double height = static_cast<double>(num_rows) * PanelDrawing::height() + kGap;

  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + px(total) +
                    "\" height=\"" + px(height) + "\" viewBox=\"0 0 " + px(total) + ' ' +
                    px(height) +
                    "\" font-family=\"Helvetica, Arial, 'DejaVu Sans', sans-serif\" font-size=\"" +
                    px(kTextSize) + "\" fill=\"#222\">\n";
  svg += R"(<rect width="100%" height="100%" rx="6" fill="#fff"/>)"
         "\n";
  double y = 0.5 * kGap;
  for (std::size_t row = 0; row < num_rows; ++row, y += PanelDrawing::height()) {
    double x = 0.0;
    for (std::size_t c = 0; c < num_columns && row * num_columns + c < panels.size(); ++c) {
      svg += drawings[row * num_columns + c].draw(x, y);
      x += width[c];
    }
  }
  return svg + "</svg>\n";
}

void write_svg_plot(const std::string& path, const std::vector<PlotPanel>& panels, int columns) {
  AtomicFile file(path);
  file.stream() << svg_plot(panels, columns);
  file.commit();
}

}  // namespace zygoma
