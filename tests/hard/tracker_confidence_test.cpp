// What the confidence of a contour promises, fitted on performers and verified on others.
//
//   ZYGOMA_FIT_CONFIDENCE=1 build/release/tests/hard_tests --gtest_filter='Confidence.*'
//
// fits the maps anew and writes tracker/confidence_table.h and tests/hard/node_offsets.h; build
// again and run the tests.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <opencv2/imgproc.hpp>
#include <set>
#include <sstream>

#include "tests/hard/node_offsets.h"
#include "tests/hard/record.h"
#include "tests/hard/tracker_clips.h"
#include "tracker/confidence.h"
#include "tracker/face_chart.h"
#include "tracker/feature_schema.h"
#include "tracker/robust.h"

namespace zygoma::hard {
namespace {

struct Sample {
  std::string contour;
  unsigned person = 0;
  ConfidenceTerms terms{};
  double confidence = 0.0;
  std::vector<Point2> offset;  // of its nodes from the true ones, chart px
  double far = 0.0;            // from the truth, eye distances
};

// Both sides of a feature share a map.
std::string kind_of(const std::string& contour) {
  for (const char* side : {"_left", "_right"}) {
    const size_t at = contour.rfind(side);
    if (at != std::string::npos) return contour.substr(0, at);
  }
  return contour;
}

// Where the nodes of contours stand against those of the face model, chart px, of the subject's
// left side: a feature is not quite the line that stands for it, nor as long.
std::map<std::string, std::vector<Point2>>& offsets() {
  static std::map<std::string, std::vector<Point2>> all = [] {
    std::map<std::string, std::vector<Point2>> written;
    for (const NodeOffset& node : kNodeOffsets) {
      written[std::string(node.kind)].emplace_back(node.x_px, node.y_px);
    }
    return written;
  }();
  return all;
}

Point2 usual_offset(const std::string& contour, size_t node) {
  const auto found = offsets().find(kind_of(contour));
  if (found == offsets().end() || node >= found->second.size()) return Point2::Zero();
  const Point2& left = found->second[node];
  return {contour.ends_with("_right") ? -left.x() : left.x(), left.y()};
}

void add_samples(unsigned person,
                 const Clip& clip,
                 const std::vector<Frame>& frames,
                 std::vector<Sample>& samples) {
  Tracker tracker;
  for (size_t i = 0; i < frames.size(); ++i) {
    const ContourSet set = tracker.track(frames[i]);
    if (tracker.head() == nullptr) continue;
    const Similarity chart_from_image = tracker.head()->inverse();
    for (size_t f = 0; f < set.contours.size(); ++f) {
      const Contour& contour = set.contours[f];
      const Contour* truth = clip.truth[i].visible(contour.name);
      if (contour.lost() || truth == nullptr) continue;
      Sample sample{contour.name, person, tracker.report().terms[f], contour.confidence, {}, 0.0};
      std::vector<Point2> here, there;
      for (size_t n = 0; n < contour.points_px.size(); ++n) {
        here.push_back(chart_from_image.apply(contour.points_px[n]));
        there.push_back(chart_from_image.apply(truth->points_px[n]));
        sample.offset.push_back(here[n] - there[n]);
        here[n] -= usual_offset(contour.name, n);
      }
      sample.far = distance_px(here, there) / kChartEyeDistance;
      samples.push_back(sample);
    }
  }
}

Point2 mouth_of(const ContourSet& truth) {
  return 0.5 * (middle_of(*truth.visible("upper_lip")) + middle_of(*truth.visible("lower_lip")));
}

cv::Mat shrunk(const cv::Mat& picture, double scale) {
  cv::Mat small, out;
  cv::resize(picture, small, cv::Size(), scale, scale, cv::INTER_AREA);
  cv::resize(small, out, picture.size(), 0, 0, cv::INTER_LINEAR);
  return out;
}

cv::Size box(const Clip& clip, double width, double height) {
  return {static_cast<int>(width * clip.chart_px), static_cast<int>(height * clip.chart_px)};
}

// Every `keep`-th frame shown until the next one.
PictureChange slow(const Clip& clip, size_t keep) {
  return [&clip, keep](size_t i, const cv::Mat&) { return clip.frames[i - i % keep].image; };
}

std::vector<PictureChange> disturbances(const Clip& clip, bool held_out) {
  const auto hand = [&clip](size_t first, size_t end, bool over_nose, double w, double h) {
    return [&clip, first, end, over_nose, w, h](size_t i, const cv::Mat& p) {
      if (i < first || i >= end) return p;
      const Point2 at =
          over_nose ? middle_of(*clip.truth[i].visible("nose_tip")) : mouth_of(clip.truth[i]);
      return with_hand(p, at, box(clip, w, h));
    };
  };
  const auto noise = [](double sigma) {
    return [sigma](size_t i, const cv::Mat& p) { return noisy(p, sigma, i); };
  };
  const auto same = [](size_t, const cv::Mat& p) { return p; };
  if (held_out) {
    return {same,
            noise(10.0),
            [](size_t, const cv::Mat& p) { return jpeg(p, 20); },
            [](size_t i, const cv::Mat& p) { return i % 25 < 8 ? motion_blurred(p, 7) : p; },
            [](size_t i, const cv::Mat& p) { return exposed(p, 1.0 - 0.008 * double(i)); },
            hand(20, 35, false, 60.0, 70.0),
            [](size_t, const cv::Mat& p) { return shrunk(p, 0.45); }};
  }
  return {same,
          noise(6.0),
          noise(16.0),
          [](size_t, const cv::Mat& p) { return blurred(p, 2.0); },
          [](size_t i, const cv::Mat& p) { return i % 30 < 15 ? p : blurred(p, 4.0); },
          [](size_t, const cv::Mat& p) { return jpeg(p, 35); },
          [](size_t i, const cv::Mat& p) { return i >= 20 && i < 45 ? jpeg(p, 10) : p; },
          hand(25, 45, false, 80.0, 50.0),
          hand(30, 42, true, 150.0, 210.0),
          [](size_t i, const cv::Mat& p) { return noisy(exposed(p, 0.4), 5.0, i); },
          [](size_t i, const cv::Mat& p) { return i >= 20 && i < 40 ? exposed(p, 1.7) : p; },
          slow(clip, 3),
          [](size_t, const cv::Mat& p) { return shrunk(p, 0.3); }};
}

const Clip& person(unsigned seed) { return performer(seed, "mixed", 5.0, 12.0); }

std::vector<Sample> samples_of(unsigned first, unsigned count, bool held_out) {
  std::vector<Sample> samples;
  for (unsigned seed = first; seed < first + count; ++seed) {
    const Clip& clip = person(seed);
    const std::vector<PictureChange> all = disturbances(clip, held_out);
    // Persons differ more than what happens to their pictures: many of them, each undisturbed and
    // in a few of the ways.
    for (size_t k = 0; k < all.size(); ++k) {
      if (!held_out && k > 0 && (k + seed) % 3 != 0) continue;
      add_samples(seed, clip, changed(clip.frames, all[k]), samples);
    }
  }
  return samples;
}

using Parameters = std::array<double, kNumConfidenceTerms + 1>;  // weights, then the bias

struct Row {
  Parameters x{};
  double share = 0.0;   // of frames within the trusted distance
  double weight = 0.0;  // against the others; they add up to about one
};

Row row_of_terms(const ConfidenceTerms& terms, double share, double weight) {
  Row row;
  for (size_t k = 0; k < kNumConfidenceTerms; ++k) {
    row.x[k] = std::log(std::clamp(terms[k], kLeastTerm, 1.0));
  }
  row.x.back() = 1.0;
  row.share = share;
  row.weight = weight;
  return row;
}

// Performers are cleaner than people. So there are a few frames more in which a contour failed:
// some where nothing spoke against it, some where one term alone was at its worst.
std::vector<Row> rows_of(const std::vector<const Sample*>& samples) {
  constexpr double kFailsAnyway = 0.01, kFailsOfOneTerm = 0.003;
  std::vector<Row> rows;
  for (const Sample* s : samples) {
    rows.push_back(row_of_terms(s->terms,
                                s->far < kTrustedDistance ? 1.0 : 0.0,
                                1.0 / static_cast<double>(samples.size())));
  }
  rows.push_back(row_of_terms(kBestTerms, 0.0, kFailsAnyway));
  for (size_t k = 0; k < kNumConfidenceTerms; ++k) {
    ConfidenceTerms terms = kBestTerms;
    terms[k] = kLeastTerm;
    rows.push_back(row_of_terms(terms, 0.0, kFailsOfOneTerm));
  }
  return rows;
}

constexpr double kLeastWeight = 0.3;
constexpr double kFurrowMustShow = 0.5;  // least weight of a furrow's presence

// Least log loss with a little ridge and a least weight of every term, by accelerated projected
// gradient.
ConfidenceMap fit(const std::vector<Row>& rows, double least_presence) {
  constexpr double kRidge = 1e-3;
  constexpr int kIterations = 3000;
  double steepest = kRidge;
  for (const Row& row : rows) {
    for (const double v : row.x) steepest += 0.25 * row.weight * v * v;
  }
  Parameters p{}, ahead{};
  for (int k = 1; k <= kIterations; ++k) {
    Parameters slope{};
    for (const Row& row : rows) {
      double z = 0.0;
      for (size_t j = 0; j < p.size(); ++j) z += ahead[j] * row.x[j];
      const double miss = row.weight * (1.0 / (1.0 + std::exp(-z)) - row.share);
      for (size_t j = 0; j < p.size(); ++j) slope[j] += miss * row.x[j];
    }
    Parameters next{};
    for (size_t j = 0; j < p.size(); ++j) {
      const bool weight = j < kNumConfidenceTerms;
      next[j] = ahead[j] - (slope[j] + (weight ? kRidge * ahead[j] : 0.0)) / steepest;
      if (weight) next[j] = std::max(j == kPresence ? least_presence : kLeastWeight, next[j]);
    }
    for (size_t j = 0; j < p.size(); ++j) {
      ahead[j] = next[j] + (k - 1.0) / (k + 2.0) * (next[j] - p[j]);
    }
    p = next;
  }
  ConfidenceMap map;
  std::copy_n(p.begin(), std::size_t{kNumConfidenceTerms}, map.weight.begin());
  map.bias = p.back();
  return map;
}

void fit_offsets(unsigned first, unsigned count) {
  std::vector<Sample> samples;
  for (unsigned seed = first; seed < first + count; ++seed) {
    add_samples(seed, person(seed), person(seed).frames, samples);
  }
  using Spread = std::array<std::vector<double>, 2>;
  std::map<std::string, std::vector<Spread>> seen;
  for (const Sample& s : samples) {
    std::vector<Spread>& nodes = seen[kind_of(s.contour)];
    nodes.resize(s.offset.size());
    const double side = s.contour.ends_with("_right") ? -1.0 : 1.0;
    for (size_t n = 0; n < nodes.size(); ++n) {
      nodes[n][0].push_back(side * s.offset[n].x());
      nodes[n][1].push_back(s.offset[n].y());
    }
  }
  std::string rows;
  size_t num_rows = 0;
  for (const auto& [kind, nodes] : seen) {
    std::vector<Point2>& usual = offsets()[kind];
    usual.clear();
    for (const Spread& xy : nodes) {
      Spread sorted = xy;
      usual.emplace_back(median(sorted[0]), median(sorted[1]));
      char line[120];
      std::snprintf(line,
                    sizeof line,
                    "    {\"%s\", %.2f, %.2f},\n",
                    kind.c_str(),
                    usual.back().x(),
                    usual.back().y());
      rows += line;
      ++num_rows;
    }
  }
  std::ofstream out(std::string(ZYGOMA_SOURCE_DIR) + "/tests/hard/node_offsets.h");
  out << R"(// Written by the fit of tests/hard/tracker_confidence_test.cpp: where the nodes of the tracker's
// contours stand against those of the face model, chart px, of the subject's left side.
#pragma once

#include <array>
#include <string_view>

namespace zygoma::hard {

struct NodeOffset {
  std::string_view kind;  // the name of the contour, less its side
  double x_px;
  double y_px;
};

)"
      << "inline constexpr std::array<NodeOffset, " << num_rows << "> kNodeOffsets{{\n"
      << rows << "}};\n\n}  // namespace zygoma::hard\n";
}

void write_table(const std::vector<Sample>& samples) {
  std::map<std::string, std::vector<const Sample*>> kinds;
  std::vector<const Sample*> all;
  for (const Sample& s : samples) {
    kinds[kind_of(s.contour)].push_back(&s);
    all.push_back(&s);
  }
  std::ostringstream out;
  out << "// Written by the fit of tests/hard/tracker_confidence_test.cpp; see docs/tracking.md.\n"
         "#pragma once\n\n#include <array>\n\n#include \"tracker/confidence.h\"\n\nnamespace "
         "zygoma "
         "{\n\nstruct NamedConfidenceMap {\n  std::string_view contours;  // what the names of the "
         "contours begin with\n  ConfidenceMap map;\n};\n\n// The last is for contours it was not "
         "fitted "
         "for.\ninline constexpr std::array<NamedConfidenceMap, "
      << kinds.size() + 1 << "> kConfidenceMaps{{\n";
  const auto write = [&out](const std::string& name, const ConfidenceMap& map) {
    char line[200];
    std::snprintf(line,
                  sizeof line,
                  "    {\"%s\", {%.2f, {%.2f, %.2f, %.2f, %.2f, %.2f, %.2f}}},\n",
                  name.c_str(),
                  map.bias,
                  map.weight[0],
                  map.weight[1],
                  map.weight[2],
                  map.weight[3],
                  map.weight[4],
                  map.weight[5]);
    out << line;
    std::printf("%s", line);
  };
  // A furrow that nobody sees is doubtful, although the place where performers have it is known.
  for (const auto& [kind, list] : kinds) {
    write(kind, fit(rows_of(list), kind == "furrow" ? kFurrowMustShow : kLeastWeight));
  }
  write("", fit(rows_of(all), kLeastWeight));
  out << "}};\n\n}  // namespace zygoma\n";
  std::ofstream(std::string(ZYGOMA_SOURCE_DIR) + "/tracker/confidence_table.h") << out.str();
}

struct Bin {
  double promised = 0.0, kept = 0.0;
  int count = 0;
};

using Bins = std::array<Bin, 5>;

Bins reliability(const std::vector<Sample>& samples, const std::string& kind) {
  Bins bins;
  for (const Sample& s : samples) {
    if (!kind.empty() && kind_of(s.contour) != kind) continue;
    Bin& bin = bins[std::min(bins.size() - 1, static_cast<size_t>(s.confidence * 5.0))];
    bin.promised += s.confidence;
    bin.kept += s.far < kTrustedDistance ? 1.0 : 0.0;
    ++bin.count;
  }
  for (Bin& bin : bins) {
    if (bin.count == 0) continue;
    bin.promised /= bin.count;
    bin.kept /= bin.count;
  }
  return bins;
}

std::string row_of(const Bins& bins) {
  std::string row;
  for (const Bin& bin : bins) {
    char cell[60];
    std::snprintf(cell,
                  sizeof cell,
                  bin.count > 0 ? " %.2f / %.2f (%d) |" : " - |",
                  bin.promised,
                  bin.kept,
                  bin.count);
    row += cell;
  }
  return row;
}

TEST(Confidence, MeansTheShareOfFramesWithinTheTrustedDistance) {
  constexpr unsigned kFirstFitted = 101, kFitted = 20, kFirstHeldOut = 201;
  if (std::getenv("ZYGOMA_FIT_CONFIDENCE") != nullptr) {
    fit_offsets(kFirstFitted, kFitted);
    write_table(samples_of(kFirstFitted, kFitted, false));
    GTEST_SKIP() << "fitted; build again";
  }
  const std::vector<Sample> samples = samples_of(kFirstHeldOut, long_tests() ? 8 : 2, true);
  std::set<std::string> kinds{""};
  for (const Feature& feature : kFeatureSchema) kinds.insert(kind_of(std::string(feature.name)));
  for (const std::string& kind : kinds) {
    const Bins bins = reliability(samples, kind);
    std::printf("| %s |%s\n", kind.empty() ? "all" : kind.c_str(), row_of(bins).c_str());
    if (!kind.empty()) continue;
    for (const Bin& bin : bins) {
      // Frames of one person are not independent; a few persons fill the upper bins only.
      if (bin.count < 250) continue;
      EXPECT_NEAR(bin.promised, bin.kept, 0.1);
    }
  }
}

}  // namespace
}  // namespace zygoma::hard
