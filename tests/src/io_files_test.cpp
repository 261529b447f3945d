// The text files: bytes that do not depend on the locale, round trips, and complaints that say
// where and what.
#include <gtest/gtest.h>

#include <clocale>
#include <limits>
#include <locale>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "src/base/check.h"
#include "src/io/atomic_file.h"
#include "src/io/contours_file.h"
#include "src/io/contractions_file.h"
#include "src/io/corrections_file.h"
#include "src/io/output_folder.h"
#include "src/io/session_file.h"
#include "src/io/text.h"
#include "tests/src/scratch_folder.h"
#include "tracker/feature_schema.h"

namespace zygoma {
namespace {

constexpr const char* kContractionsHeader =
    "frame,timestamp,confidence,success,head_x,head_y,head_scale,head_roll,jaw,jaw_sigma,"
    "zygomaticus_major_L,zygomaticus_major_R,zygomaticus_major_L_sigma,zygomaticus_major_R_sigma,"
    "occipitofrontalis_inner_L,occipitofrontalis_inner_R,occipitofrontalis_inner_L_sigma,"
    "occipitofrontalis_inner_R_sigma,resid_px_brow_left,resid_px_brow_right,resid_px_furrow_left,"
    "resid_px_furrow_right,resid_px_nose_tip,resid_px_upper_lip,resid_px_lower_lip,"
    "resid_px_chin_boss,resid_px_hairline\n";

ContractionTrack example_track() {
  ContractionTrack track;
  track.muscles = {"zygomaticus_major_L",
                   "zygomaticus_major_R",
                   "occipitofrontalis_inner_L",
                   "occipitofrontalis_inner_R"};
  Contractions first;
  first.confidence = 0.875;
  first.success = true;
  first.head = {320.25, 180.5, 1.03125, -0.0625};
  first.jaw = 0.25;
  first.jaw_sigma = 0.015625;
  first.value = {0.5, 0.75, 0.0, 1.0};
  first.sigma = {0.03125, 0.0625, 0.125, 0.25};
  first.residual_px = {{"brow_left", 0.5}, {"upper_lip", 1.25}};
  track.frames.push_back(first);

  Contractions lost;
  lost.frame_index = 1;
  lost.time_s = 0.04;
  track.frames.push_back(lost);

  Contractions without_sigma = first;
  without_sigma.frame_index = 2;
  without_sigma.time_s = 0.125;
  without_sigma.sigma.clear();
  track.frames.push_back(without_sigma);
  return track;
}

ContourSet all_lost(int frame_index, double time_s) {
  ContourSet set{frame_index, time_s, {}};
  for (const Feature& feature : kFeatureSchema) {
    set.contours.push_back({std::string(feature.name), {}, 0.0, false});
  }
  return set;
}

std::vector<ContourSet> example_contours() {
  std::vector<ContourSet> sets{all_lost(0, 0.0), all_lost(1, 0.0333667)};
  sets[1].time_s = 0.033367;
  sets[1].contours[1].points_px = {{1.5, -2.25}, {1000.0625, 0.0}, {3.0, 4.0}};
  sets[1].contours[1].confidence = 0.75;
  sets[1].contours[1].locked = true;
  sets[1].contours[5].points_px = {{10.0, 20.0}, {30.0, 40.0}};
  sets[1].contours[5].confidence = 1.0;
  return sets;
}

template <typename Action>
void expect_complaint(const Action& action, const std::vector<std::string>& words) {
  const std::string message = message_of<InputError>(action);
  for (const std::string& word : words) {
    EXPECT_NE(message.find(word), std::string::npos) << "no '" << word << "' in: " << message;
  }
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

// Numbers with a decimal comma and grouped thousands, for streams and, if the system has such a
// locale, for the C library.
class GermanLocale {
 public:
  GermanLocale() : before_(std::locale::global(std::locale(std::locale::classic(), new Comma))) {
    for (const char* name : {"de_DE.utf8", "de_DE.UTF-8", "fr_FR.utf8", "fr_FR.UTF-8"}) {
      if (std::setlocale(LC_ALL, name) != nullptr) break;
    }
  }
  ~GermanLocale() {
    std::locale::global(before_);
    std::setlocale(LC_ALL, "C");
  }
  GermanLocale(const GermanLocale&) = delete;
  GermanLocale& operator=(const GermanLocale&) = delete;

 private:
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  std::locale before_;
};

TEST(TextTest, FixedDecimals) {
  const auto fixed = [](double value, int decimals) {
    std::string text;
    append_fixed(text, value, decimals);
    return text;
  };
  EXPECT_EQ(fixed(0.5, 4), "0.5000");
  EXPECT_EQ(fixed(-1234567.25, 1), "-1234567.2");
  EXPECT_EQ(fixed(-0.00001, 4), "0.0000");
  EXPECT_EQ(fixed(-0.0, 0), "0");
  EXPECT_EQ(fixed(std::numeric_limits<double>::quiet_NaN(), 4), "");
  EXPECT_EQ(fixed(std::numeric_limits<double>::infinity(), 4), "");
  EXPECT_EQ(fixed(std::numeric_limits<double>::max(), 2).size(), 312u);
}

TEST(ContractionsFileTest, WritesTheDocumentedBytes) {
  const ScratchFolder folder;
  write_contractions_csv(folder / "c.csv", example_track());
  EXPECT_EQ(bytes_of(folder / "c.csv"),
            std::string(kContractionsHeader) +
                "0,0.000000,0.8750,1,320.2500,180.5000,1.031250,-0.062500,0.250000,0.015625,"
                "0.500000,0.750000,0.031250,0.062500,0.000000,1.000000,0.125000,0.250000,"
                "0.5000,,,,,1.2500,,,\n"
                "1,0.040000,0.0000,0,,,,,,,,,,,,,,,,,,,,,,,\n"
                "2,0.125000,0.8750,1,320.2500,180.5000,1.031250,-0.062500,0.250000,0.015625,"
                "0.500000,0.750000,,,0.000000,1.000000,,,0.5000,,,,,1.2500,,,\n");
  EXPECT_FALSE(std::filesystem::exists(folder / "c.csv.part"));
}

TEST(ContractionsFileTest, RoundTripKeepsValuesAndBytes) {
  const ScratchFolder folder;
  write_contractions_csv(folder / "a.csv", example_track());
  const ContractionTrack track = read_contractions_csv(folder / "a.csv");
  EXPECT_EQ(track, example_track());
  write_contractions_csv(folder / "b.csv", track);
  EXPECT_EQ(bytes_of(folder / "a.csv"), bytes_of(folder / "b.csv"));
}

TEST(ContractionsFileTest, FlagsOfWhatWasSeenComeBack) {
  const ScratchFolder folder;
  ContractionTrack track = example_track();
  track.frames[0].observed = {true, false, true, true};
  track.frames[0].jaw_observed = true;
  track.frames[2].observed = {false, false, false, true};
  write_contractions_csv(folder / "a.csv", track);
  const std::string text = bytes_of(folder / "a.csv");
  EXPECT_NE(text.find("resid_px_hairline,jaw_observed,zygomaticus_major_L_observed"),
            std::string::npos);
  EXPECT_EQ(read_contractions_csv(folder / "a.csv"), track);
}

TEST(ContractionsFileTest, FiveMusclesOf1992MakeThirtyNineColumns) {
  const ScratchFolder folder;
  ContractionTrack track;
  for (const char* name : {"zygomaticus_major",
                           "levator_labii_superioris_alaeque_nasi",
                           "occipitofrontalis_inner",
                           "occipitofrontalis_major",
                           "occipitofrontalis_outer"}) {
    track.muscles.push_back(std::string(name) + "_L");
    track.muscles.push_back(std::string(name) + "_R");
  }
  write_contractions_csv(folder / "c.csv", track);
  const std::string header = bytes_of(folder / "c.csv");
  EXPECT_EQ(std::count(header.begin(), header.end(), ','), 38);
}

TEST(ContractionsFileTest, AMuscleWithoutASideComesBackToo) {
  const ScratchFolder folder;
  ContractionTrack track;
  track.muscles = {"orbicularis_oris", "mentalis_R", "mentalis_L"};
  track.frames.resize(1);
  track.frames[0].value = {0.5, 0.25, 0.125};
  write_contractions_csv(folder / "c.csv", track);
  EXPECT_EQ(read_contractions_csv(folder / "c.csv"), track);
}

TEST(ContractionsFileTest, SameBytesInEveryLocale) {
  const ScratchFolder folder;
  write_contractions_csv(folder / "plain.csv", example_track());
  write_contours_csv(folder / "plain_contours.csv", example_contours());
  const GermanLocale german;
  std::ostringstream proof;
  proof << 1234.5;
  ASSERT_EQ(proof.str(), "1.234,5");
  write_contractions_csv(folder / "german.csv", example_track());
  write_contours_csv(folder / "german_contours.csv", example_contours());
  EXPECT_EQ(bytes_of(folder / "plain.csv"), bytes_of(folder / "german.csv"));
  EXPECT_EQ(bytes_of(folder / "plain_contours.csv"), bytes_of(folder / "german_contours.csv"));
  EXPECT_EQ(read_contractions_csv(folder / "plain.csv"), example_track());
  EXPECT_EQ(read_contours_csv(folder / "plain_contours.csv"), example_contours());
}

TEST(ContractionsFileTest, ForgivesWhatEditorsDo) {
  const ScratchFolder folder;
  const std::string path =
      folder.write("edited.csv",
                   "\xEF\xBB\xBF Frame , "
                   "TIMESTAMP,Comment,confidence,success,head_x,head_y,head_scale,head_roll,"
                   "jaw,mentalis_R,mentalis_L\r\n"
                   "0, 0.0 ,hello world,1,1,0,0,1,0,0.5, 0.25 ,1\r\n"
                   "\r\n"
                   "1,0.5,,1,1,0,0,1,0,0,0,0");
  const ContractionTrack track = read_contractions_csv(path);
  EXPECT_EQ(track.muscles, (std::vector<std::string>{"mentalis_R", "mentalis_L"}));
  ASSERT_EQ(track.frames.size(), 2u);
  EXPECT_EQ(track.frames[0].value, (std::vector<double>{0.25, 1.0}));
  EXPECT_TRUE(track.frames[0].sigma.empty());
  EXPECT_EQ(track.frames[0].jaw, 0.5);
  EXPECT_EQ(track.frames[1].time_s, 0.5);
}

class BadContractionsTest : public testing::Test {
 protected:
  BadContractionsTest() {
    write_contractions_csv(folder_ / "good.csv", example_track());
    good_ = bytes_of(folder_ / "good.csv");
  }

  void expect(const std::string& bytes, std::vector<std::string> words) const {
    const std::string path = folder_.write("bad.csv", bytes);
    words.push_back(path);
    expect_complaint([&] { read_contractions_csv(path); }, words);
  }

  ScratchFolder folder_;
  std::string good_;
};

TEST_F(BadContractionsTest, NamesFileLineColumnValueAndWhatWasExpected) {
  expect(replaced(good_, "0.500000", "1.5"),
         {":2: column zygomaticus_major_L: '1.5', expected a number in [0, 1]"});
  expect(replaced(good_, "0.500000", "-0.000001"), {":2:", "zygomaticus_major_L", "'-0.000001'"});
  expect(replaced(good_, "0.500000", "nan"), {":2:", "zygomaticus_major_L", "'nan'", "a number"});
  expect(replaced(good_, "0.500000", "inf"), {":2:", "zygomaticus_major_L", "'inf'"});
  expect(replaced(good_, "0.500000", "0.5x"), {":2:", "zygomaticus_major_L", "'0.5x'"});
  expect(replaced(good_, "0.500000", ""), {":2:", "zygomaticus_major_R", "'0.750000'", "empty"});
  expect(replaced(good_, "0.750000", ""), {":2:", "zygomaticus_major_R", "empty cell"});
  expect(replaced(good_, "0.8750,1", "0.8750,2"), {":2: column success: '2'", "[0, 1]"});
  expect(replaced(good_, "0.015625", "-1"), {":2: column jaw_sigma: '-1'", "at least 0"});
  expect(replaced(good_, "1.031250", "0"), {":2: column head_scale: '0'"});
  expect(replaced(good_, "320.2500", ""), {":2: column head_x: empty cell"});
}

TEST_F(BadContractionsTest, SaysWhichFramesAreMissing) {
  expect(replaced(good_, "\n1,", "\n3,"), {":3: column frame: '3', expected 1"});
  expect(replaced(good_, "\n0,", "\n1,"), {":2: column frame: '1', expected 0"});
  expect(replaced(good_, "1,0.04", "1,0.00"), {":3: column timestamp: '0.000000'", "later"});
  expect(replaced(good_, "\n1,", "\nx,"), {":3: column frame: 'x', expected 1"});
}

TEST_F(BadContractionsTest, SaysWhatIsWrongWithTheTable) {
  expect(replaced(good_, "timestamp", "time"), {":1: missing column timestamp"});
  expect(replaced(replaced(good_, "jaw,", "chin,"), "head_x", "x"), {"missing column head_x, jaw"});
  expect(replaced(good_, ",zygomaticus_major_R,", ",smile,"),
         {"missing column zygomaticus_major_R"});
  expect(replaced(good_, "0.500000", "0,500000"), {":2: 28 cells, expected 27", "decimal point"});
  expect("frame;timestamp;jaw\n0;0;0\n", {":1:", "separated by commas"});
  expect(kContractionsHeader, {"no rows"});
  expect("", {"is empty", "expected a contractions CSV file"});
  expect(std::string("\0\1\2\xff\xfe\0 binary", 13), {"'?????? binary'"});
}

TEST_F(BadContractionsTest, NamesFilesThatCannotBeRead) {
  expect_complaint([&] { read_contractions_csv(folder_ / "missing.csv"); },
                   {folder_ / "missing.csv", "No such file", "contractions CSV file"});
  expect_complaint([&] { read_contractions_csv(folder_ / ""); }, {"is a folder"});
}

TEST(ContoursFileTest, WritesTheDocumentedBytes) {
  const ScratchFolder folder;
  write_contours_csv(folder / "c.csv", {example_contours()[1]});
  const std::string bytes = bytes_of(folder / "c.csv");
  EXPECT_TRUE(
      bytes.starts_with("frame,timestamp,contour,node,x,y,confidence,locked\n"
                        "1,0.033367,brow_left,,,,0.0000,0\n"
                        "1,0.033367,brow_right,0,1.5000,-2.2500,0.7500,1\n"
                        "1,0.033367,brow_right,1,1000.0625,0.0000,0.7500,1\n"
                        "1,0.033367,brow_right,2,3.0000,4.0000,0.7500,1\n"
                        "1,0.033367,furrow_left,,,,0.0000,0\n"))
      << bytes;
}

TEST(ContoursFileTest, RoundTripKeepsValuesAndBytes) {
  const ScratchFolder folder;
  write_contours_csv(folder / "a.csv", example_contours());
  const std::vector<ContourSet> sets = read_contours_csv(folder / "a.csv");
  EXPECT_EQ(sets, example_contours());
  write_contours_csv(folder / "b.csv", sets);
  EXPECT_EQ(bytes_of(folder / "a.csv"), bytes_of(folder / "b.csv"));
}

TEST(ContoursFileTest, AFrameWithoutContoursStillHasItsRows) {
  const ScratchFolder folder;
  write_contours_csv(folder / "a.csv", {{0, 0.0, {}}, {1, 0.5, {}}});
  const std::vector<ContourSet> sets = read_contours_csv(folder / "a.csv");
  EXPECT_EQ(sets, (std::vector<ContourSet>{all_lost(0, 0.0), all_lost(1, 0.5)}));
}

TEST(ContoursFileTest, AVisibleContourIsNeverWrittenAsLost) {
  const ScratchFolder folder;
  std::vector<ContourSet> sets = example_contours();
  sets[1].contours[1].confidence = 1e-9;
  write_contours_csv(folder / "a.csv", sets);
  EXPECT_GT(read_contours_csv(folder / "a.csv")[1].contours[1].confidence, 0.0);
}

TEST(ContoursFileTest, NamesFileLineColumnAndValue) {
  const ScratchFolder folder;
  const std::string header = "frame,timestamp,contour,node,x,y,confidence,locked\n";
  const auto expect = [&](const std::string& rows, const std::vector<std::string>& words) {
    const std::string path = folder.write("bad.csv", header + rows);
    expect_complaint([&] { read_contours_csv(path); }, words);
  };
  expect("0,0,brow_left,0,1,nan,1,0\n", {"bad.csv:2: column y: 'nan', expected a number"});
  expect("0,0,brow_middle,0,1,1,1,0\n", {":2: column contour: 'brow_middle'", "brow_left, "});
  expect("0,0,brow_left,1,1,1,1,0\n", {":2: column node: '1', expected 0"});
  expect("0,0,brow_left,0,1,1,1.5,0\n", {":2: column confidence: '1.5'", "[0, 1]"});
  expect("0,0,brow_left,0,1,1,0,0\n", {":2: column confidence: '0'"});
  expect("0,0,brow_left,,,,0,0\n0,0,brow_left,0,1,1,1,0\n", {":3: column node: '0'"});
  expect("0,0,brow_left,,,,0,0\n2,1,brow_left,,,,0,0\n", {":3: column frame: '2'", "[0, 1]"});
  expect("0,0,brow_left,,,,0,0\n1,0,brow_left,,,,0,0\n", {":3: column timestamp: '0'", "later"});
  expect("0,0,brow_left,,7,,0,0\n", {":2: column x: '7'", "empty"});
  expect("0,0,brow_left,0,1,1,1,yes\n", {":2: column locked: 'yes'"});
}

TEST(InitialContoursTest, FillsTheSchemaWithWhatIsGiven) {
  const ScratchFolder folder;
  const std::string path = folder.write(
      "init.json",
      R"({"frame": 12, "contours": {"upper_lip": [[1, 2], [3.5, 4], [5, 6]], "brow_left": [[7, 8], [9, 10]]}})");
  const ContourSet set = read_initial_contours(path);
  EXPECT_EQ(set.frame_index, 12);
  ASSERT_EQ(set.contours.size(), kFeatureSchema.size());
  ASSERT_NE(set.visible("upper_lip"), nullptr);
  EXPECT_EQ(set.visible("upper_lip")->points_px, (std::vector<Point2>{{1, 2}, {3.5, 4}, {5, 6}}));
  EXPECT_EQ(set.visible("upper_lip")->confidence, 1.0);
  ASSERT_NE(set.visible("brow_left"), nullptr);
  EXPECT_EQ(set.visible("hairline"), nullptr);
  EXPECT_EQ(set.contours[0].name, "brow_left");
}

TEST(InitialContoursTest, NamesFilePlaceAndValue) {
  const ScratchFolder folder;
  const auto expect = [&](const std::string& bytes, std::vector<std::string> words) {
    const std::string path = folder.write("init.json", bytes);
    words.push_back(path);
    expect_complaint([&] { read_initial_contours(path); }, words);
  };
  expect("", {"not valid JSON", "expected a contours JSON file"});
  expect("{\"contours\": {", {"not valid JSON at byte"});
  expect("[1, 2]", {"a list of 2, expected a contours JSON file"});
  expect(R"({"frame": 1, "frame": 2})", {"the key 'frame' is there twice"});
  expect("{}", {"has no contours"});
  expect(R"({"contours": {}})", {"has no contours"});
  expect(R"({"contours": {"nose": [[0, 0], [1, 1]]}})", {"'nose' is unknown", "nose_tip"});
  expect(R"({"contours": {"nose_tip": [[0, 0]]}})", {"contours.nose_tip", "at least two points"});
  expect(R"({"contours": {"nose_tip": [[0, 0], [1]]}})", {"contours.nose_tip[1]: a list of 1"});
  expect(R"({"contours": {"nose_tip": [[0, 0], [1, null]]}})", {"nose_tip[1]: 'null'", "number"});
  expect(R"({"contours": {"nose_tip": [[0, 0], [1, 1e999]]}})", {"too large"});
  expect(R"({"frame": -1, "contours": {"nose_tip": [[0, 0], [1, 1]]}})", {"frame: '-1'"});
  expect(R"({"frame": 1.5, "contours": {"nose_tip": [[0, 0], [1, 1]]}})", {"frame: '1.5'"});
}

TEST(CorrectionsFileTest, ReadsWhatIsInForce) {
  const ScratchFolder folder;
  const std::string spring =
      R"({"id":1,"frame":57,"contour":"upper_lip","kind":"spring","s":0,"x":212.4,"y":301.7})";
  const std::string volcano =
      R"({"id":2,"frame":58,"contour":"brow_left","kind":"volcano","x":9,"y":8,"k":3,"radius":12})";
  const auto ids = [&](const std::string& text) {
    std::vector<int> found;
    for (const Correction& c : read_corrections(folder.write("c.jsonl", text))) {
      found.push_back(c.id);
    }
    return found;
  };
  const std::string both = spring + "\r\n\n" + volcano + "\n";
  const auto corrections = read_corrections(folder.write("c.jsonl", both));
  ASSERT_EQ(corrections.size(), 2U);
  EXPECT_EQ(corrections[0].frame, 57);
  EXPECT_EQ(corrections[0].contour, "upper_lip");
  EXPECT_EQ(corrections[0].at_px, Point2(212.4, 301.7));
  EXPECT_EQ(corrections[0].stiffness, Correction{}.stiffness);
  EXPECT_EQ(corrections[1].force, MouseForce::kVolcano);
  EXPECT_EQ(corrections[1].radius, 12.0);
  EXPECT_EQ(ids(both + R"({"id":3,"undo":1})"), std::vector<int>{2});
  EXPECT_EQ(ids(both + "{\"id\":3,\"undo\":1}\n{\"id\":4,\"undo\":3}"), (std::vector<int>{1, 2}));
  EXPECT_TRUE(ids("\n").empty());
}

TEST(CorrectionsFileTest, NamesFileLineAndValue) {
  const ScratchFolder folder;
  const auto expect = [&](const std::string& line, std::vector<std::string> words) {
    const std::string path = folder.write("c.jsonl", "\n" + line + "\n");
    words.push_back(path + ":2");
    expect_complaint([&] { read_corrections(path); }, words);
  };
  const auto with = [](const std::string& entries) {
    return R"({"id":1,"contour":"upper_lip","kind":"spring","s":0.5,"x":1,"y":2,)" + entries + "}";
  };
  expect("frame 3", {"'frame 3'", "expected a corrections file"});
  expect("[1]", {"'[1]'", "expected a corrections file"});
  expect(R"({"id":1,"frame":3})", {"no contour"});
  expect(with(R"("k":3)"), {"no frame"});
  expect(with(R"("frame":-3)"), {"frame", "'-3'", "whole number"});
  expect(with(R"("frame":3,"k":-1)"), {"correction 1: k is -1, expected 0.001"});
  expect(with(R"("frame":3,"radius":5)"), {"radius is 5, expected 0.001 to 1"});
  expect(with(R"("frame":3,"colour":5)"), {"colour", "no such entry"});
  expect(R"({"id":1,"frame":3,"contour":"nose","kind":"pin","s":0,"x":1,"y":2})",
         {"contour is \"nose\""});
  expect(R"({"id":1,"frame":3,"contour":"upper_lip","kind":"push"})",
         {"kind", "'\"push\"'", "spring, pin or volcano"});
  expect(R"({"id":1,"undo":7})", {"no event has the id 7"});
}

// Damaged files: either they still make sense or the complaint is an InputError of one line.
TEST(DamagedFilesTest, AreReadOrRefusedButNeverAnythingElse) {
  const ScratchFolder folder;
  write_contractions_csv(folder / "contractions.csv", example_track());
  write_contours_csv(folder / "contours.csv", example_contours());
  const std::string contractions = bytes_of(folder / "contractions.csv");
  const std::string contours = bytes_of(folder / "contours.csv");
  const std::string json = R"({"frame": 3, "contours": {"nose_tip": [[1, 2], [3.5, 4e2]]}})";
  const std::string corrections =
      R"({"id":2,"frame":58,"contour":"brow_left","kind":"volcano","x":9,"y":8,"radius":12})";
  std::mt19937 random(5);
  int refused = 0;
  const auto read_damaged = [&](std::string bytes, const auto& read) {
    const int num_changes = 1 + static_cast<int>(random() % 4);
    for (int i = 0; i < num_changes; ++i) {
      const std::size_t at = random() % bytes.size();
      const std::string_view likely = ",.-+0123456789enaix\n\"[]{}";
      bytes[at] =
          random() % 4 == 0 ? static_cast<char>(random()) : likely[random() % likely.size()];
    }
    if (random() % 8 == 0) bytes.resize(random() % bytes.size());
    try {
      read(folder.write("damaged", bytes));
    } catch (const InputError& error) {
      ++refused;
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  };
  for (int i = 0; i < 700; ++i) {
    read_damaged(contractions, [](const std::string& path) {
      for (const Contractions& frame : read_contractions_csv(path).frames) {
        for (const double value : frame.value) ASSERT_TRUE(value >= 0.0 && value <= 1.0);
      }
    });
    read_damaged(contours, [](const std::string& path) { read_contours_csv(path); });
    read_damaged(json, [](const std::string& path) { read_initial_contours(path); });
    read_damaged(corrections, [](const std::string& path) { read_corrections(path); });
  }
  EXPECT_GT(refused, 500);
  EXPECT_LT(refused, 2700);
  const std::string deep = "{\"contours\": {\"nose_tip\": " + std::string(200000, '[');
  expect_complaint([&] { read_initial_contours(folder.write("deep", deep)); }, {"not valid JSON"});
}

TEST(AtomicFileTest, AppearsOnlyWhenCommitted) {
  const ScratchFolder folder;
  folder.write("text.txt", "before");
  {
    AtomicFile file(folder / "text.txt");
    file.stream() << "half";
  }
  EXPECT_EQ(bytes_of(folder / "text.txt"), "before");
  EXPECT_FALSE(std::filesystem::exists(folder / "text.txt.part"));
  AtomicFile file(folder / "text.txt");
  file.stream() << "after";
  file.commit();
  EXPECT_EQ(bytes_of(folder / "text.txt"), "after");
}

TEST(AtomicFileTest, NamesWhatCannotBeWritten) {
  const ScratchFolder folder;
  expect_complaint([&] { AtomicFile file(folder / "no/such/x.csv"); },
                   {folder / "no/such/x.csv", "cannot be written (No such file"});
  expect_complaint([&] { AtomicFile file(folder / ""); }, {"is a folder"});
}

TEST(AtomicFileTest, ReportsADiskThatIsFull) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full here";
  const ScratchFolder folder;
  std::filesystem::create_symlink("/dev/full", folder / "x.csv.part");
  expect_complaint(
      [&] {
        AtomicFile file(folder / "x.csv");
        file.stream() << std::string(100000, 'x');
        file.commit();
      },
      {folder / "x.csv", "cannot be written completely"});
  EXPECT_FALSE(std::filesystem::exists(folder / "x.csv"));
}

TEST(OutputFolderTest, CreatesWhatIsMissingAndKeepsWhatIsUsed) {
  const ScratchFolder folder;
  for (int round = 0; round < 2; ++round) {
    const OutputFolder output(folder / "a/b/c/");
    EXPECT_TRUE(std::filesystem::is_empty(folder / "a/b/c"));
    if (round == 1) std::ofstream(output / "result") << "kept";
  }
  EXPECT_EQ(bytes_of(folder / "a/b/c/result"), "kept");
}

TEST(OutputFolderTest, RemovesWhatItCreatedForNothing) {
  const ScratchFolder folder;
  { const OutputFolder output(folder / "a/b"); }
  EXPECT_FALSE(std::filesystem::exists(folder / "a"));

  std::filesystem::create_directory(folder / "a");
  { const OutputFolder output(folder / "a/b"); }
  EXPECT_TRUE(std::filesystem::exists(folder / "a"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a/b"));
  { const OutputFolder output(folder / "a"); }
  EXPECT_TRUE(std::filesystem::exists(folder / "a")) << "was there before";
}

TEST(OutputFolderTest, SaysWhyAFolderCannotBeUsed) {
  const ScratchFolder folder;
  folder.write("file", "");
  expect_complaint([&] { const OutputFolder output(folder / "file"); },
                   {folder / "file", "is a file", "choose another"});
  expect_complaint([&] { const OutputFolder output(folder / "file/below"); },
                   {folder / "file/below", "cannot be created"});
  expect_complaint([&] { const OutputFolder output("/proc/zygoma"); }, {"/proc/zygoma"});
  expect_complaint([&] { const OutputFolder output(""); }, {"name is empty"});
}

TEST(SessionFileTest, HoldsWhatWasRunAndHowItWent) {
  const ScratchFolder folder;
  Session session;
  session.command = "run";
  session.options = {{"VIDEO", "a.mp4"}, {"output", "o"}};
  session.source.file = "caf\xE9 \"1\".mp4";  // neither UTF-8 nor free of quotes
  session.source.num_frames = 120;
  session.source.repaired_timestamps = {118, 119};
  session.source.time_from_container = false;
  session.neutral_frame = 7;
  session.stages = {{"track", 1500.0, 12.5, {{"lost", 3}, {"bad", std::nan("")}}}};
  session.libraries = {{"opencv", "4.6.0"}};
  write_session(folder / "session.json", session);

  const nlohmann::json json = nlohmann::json::parse(bytes_of(folder / "session.json"));
  EXPECT_EQ(json["tool"]["version"], kVersion);
  EXPECT_EQ(json["command"], "run");
  EXPECT_EQ(json["options"]["VIDEO"], "a.mp4");
  EXPECT_EQ(json["source"]["frames"], 120);
  EXPECT_EQ(json["source"]["time_base"], "index");
  EXPECT_EQ(json["source"]["repaired_timestamps"], nlohmann::json({118, 119}));
  EXPECT_EQ(json["neutral_frame"], 7);
  EXPECT_EQ(json["stages"][0]["name"], "track");
  EXPECT_EQ(json["stages"][0]["ms_per_frame"], 12.5);
  EXPECT_EQ(json["stages"][0]["lost"], 3.0);
  EXPECT_TRUE(json["stages"][0]["bad"].is_null());
  EXPECT_EQ(json["stopped_early"], false);
}

TEST(SessionFileTest, VersionIsThatOfTheBuild) {
  const std::string build = bytes_of(std::string(ZYGOMA_SOURCE_DIR) + "/CMakeLists.txt");
  EXPECT_NE(build.find(std::string("project(zygoma VERSION ") + kVersion + " "), std::string::npos);
}

}  // namespace
}  // namespace zygoma
