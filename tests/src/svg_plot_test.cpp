#include "src/io/svg_plot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <regex>

#include "tests/src/scratch_folder.h"

namespace zygoma {
namespace {

using Ticks = std::vector<double>;

void expect_ticks(const Ticks& ticks, const Ticks& expected) {
  ASSERT_EQ(ticks.size(), expected.size());
  for (std::size_t k = 0; k < ticks.size(); ++k) {
    EXPECT_NEAR(ticks[k], expected[k], 1e-12 * std::abs(expected[k])) << k;
  }
}

TEST(SvgPlotTest, TicksAreRoundAndReachBeyondTheEnds) {
  expect_ticks(round_ticks(0.0, 1.0, 5), {0.0, 0.2, 0.4, 0.6, 0.8, 1.0});
  expect_ticks(round_ticks(0.03, 0.41, 4), {0.0, 0.1, 0.2, 0.3, 0.4, 0.5});
  expect_ticks(round_ticks(-7.0, 12.0, 4), {-10.0, -5.0, 0.0, 5.0, 10.0, 15.0});
  for (const auto& [low, high] : std::vector<std::array<double, 2>>{
           {0.0, 1e-9}, {1e6, 3e6}, {-0.013, 0.017}, {5.0, 5.0}, {0.0, 0.0}, {0.99, 1.01}}) {
    const Ticks ticks = round_ticks(low, high, 5);
    const double little = 1e-3 * (ticks[1] - ticks[0]);
    EXPECT_LE(ticks.front(), low + little);
    EXPECT_GE(ticks.back(), high - little);
    EXPECT_GE(ticks.size(), 3U);
    EXPECT_LE(ticks.size(), 10U);
  }
}

TEST(SvgPlotTest, LogarithmicTicksArePowersOfTen) {
  expect_ticks(logarithmic_ticks(2e-6, 0.5, 6), {1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0});
  expect_ticks(logarithmic_ticks(1.5, 40.0, 5), {1.0, 2.0, 5.0, 10.0, 20.0, 50.0});
  const Ticks one = logarithmic_ticks(3.0, 3.0, 5);
  EXPECT_LE(one.front(), 3.0);
  EXPECT_GE(one.back(), 3.0);
}

std::vector<PlotPanel> example() {
  PlotSeries line{"a < b & c", {0.0, 1.0, 2.0, 3.0}, {1.0, NAN, 4.0, 5.0}};
  PlotSeries points{"points", {1.0, 2.0, 3.0}, {0.5, 0.0, 5.0}, PlotMark::kPoints, 1};
  PlotSeries dashes{"dashes", {0.0, 3.0}, {5.0, 5.0}, PlotMark::kDashes, 2};
  return {{"first", {"time (s)"}, {"stress (kPa)"}, {line, points, dashes}},
          {"second", {"cost (ms)", true}, {"error (mm)", true}, {points}}};
}

int count(const std::string& text, const std::string& part) {
  int found = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

TEST(SvgPlotTest, DrawsWhatCanBeDrawn) {
  const std::string svg = svg_plot(example());
  EXPECT_EQ(svg, svg_plot(example()));
  EXPECT_TRUE(svg.starts_with("<svg "));
  EXPECT_TRUE(svg.ends_with("</svg>\n"));
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
  EXPECT_NE(svg.find("a &lt; b &amp; c"), std::string::npos);
  EXPECT_NE(svg.find(">stress (kPa)<"), std::string::npos);
  // Three points in the first panel; in the second the one at 0 has no logarithm.
  EXPECT_EQ(count(svg, "<circle"), 5);
  // The line is interrupted where it has no value.
  const std::regex interrupted("<path d=\"M[0-9. ]+M[0-9. ]+L[0-9. ]+\" fill=\"none\"");
  EXPECT_TRUE(std::regex_search(svg, interrupted));
  EXPECT_EQ(count(svg, "stroke-dasharray"), 1);
}

TEST(SvgPlotTest, NamesOfNeighboursKeepApart) {
  PlotSeries points{"", {1.0, 1.01, 3.0}, {2.0, 2.0, 5.0}, PlotMark::kPoints, 0};
  points.names = {"draft", "standard", ""};
  const std::string svg = svg_plot({{"", {"x"}, {"y"}, {points}}});
  EXPECT_EQ(count(svg, "r=\"4.4\""), 2);  // named points are larger
  const std::regex name("<text x=\"[0-9.]+\" y=\"([0-9.]+)\"[^>]*>(draft|standard)<");
  std::vector<double> heights;
  for (std::sregex_iterator at(svg.begin(), svg.end(), name), end; at != end; ++at) {
    heights.push_back(std::stod((*at)[1]));
  }
  ASSERT_EQ(heights.size(), 2U);
  EXPECT_GE(std::abs(heights[0] - heights[1]), 12.0);
}

TEST(SvgPlotTest, LabelsOfOnePanelKeepApart) {
  PlotPanel panel{"", {""}, {""}, {}};
  for (int k = 0; k < 8; ++k) {
    panel.series.push_back({"label", {0.0, 1.0}, {0.0, 1.0 - 1e-3 * k}, PlotMark::kLine, k});
  }
  const std::string svg = svg_plot({panel});
  const std::regex place("<text x=\"[0-9.]+\" y=\"([0-9.]+)\" fill=\"#[0-9a-f]+\">label<");
  std::vector<double> places;
  for (std::sregex_iterator at(svg.begin(), svg.end(), place), end; at != end; ++at) {
    places.push_back(std::stod((*at)[1]));
  }
  ASSERT_EQ(places.size(), 8U);
  std::sort(places.begin(), places.end());
  for (std::size_t k = 1; k < places.size(); ++k) EXPECT_GE(places[k] - places[k - 1], 13.0);
}

TEST(SvgPlotTest, NothingToShowIsAnEmptyPlot) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::string svg = svg_plot({{"empty", {"x"}, {"y"}, {{"none", {nan}, {nan}}}}});
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find(">none<"), std::string::npos);
}

TEST(SvgPlotTest, WritesTheFile) {
  const ScratchFolder folder;
  write_svg_plot(folder / "plot.svg", example());
  EXPECT_EQ(bytes_of(folder / "plot.svg"), svg_plot(example()));
}

}  // namespace
}  // namespace zygoma
