// Profiles of performers, and what `zygoma retarget` does with them.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "src/base/check.h"
#include "src/io/contours_file.h"
#include "src/io/contractions_file.h"
#include "src/io/profile_file.h"
#include "tests/retarget/fake_face.h"
#include "tests/src/program.h"
#include "tests/src/scratch_folder.h"

namespace zygoma {
namespace {

// Rest, a smile, rest: as a tracker would write it.
void write_smile(const std::string& path, const FaceResponse& face) {
  std::vector<ContourSet> contours;
  for (int t = 0; t < 45; ++t) {
    Eigen::VectorXd u = Eigen::VectorXd::Zero(face.num_controls());
    const double smile = t > 15 && t < 35 ? 0.7 : 0.0;
    u[0] = u[1] = smile;
    contours.push_back(fake::observe(face, u, fake::camera(1.3), t, t / 30.0));
  }
  write_contours_csv(path, contours);
}

PerformerProfile some_profile() {
  PerformerProfile profile;
  const FaceResponse face = fake::make_face();
  profile.neutral.contours = stack_contours(
      fake::observe(face, Eigen::VectorXd::Zero(face.num_controls()), fake::camera(1.3), 0, 0.0));
  profile.range = {{"zygomaticus_major_L", 1.25}, {"jaw", 0.5}};
  return profile;
}

TEST(ProfileFile, ComesBackAsItWasWritten) {
  const ScratchFolder folder;
  const std::string path = folder / "me.json";
  const PerformerProfile profile = some_profile();
  write_profile(path, profile);
  const PerformerProfile back = read_profile(path);
  EXPECT_EQ(back.range, profile.range);
  EXPECT_EQ(back.neutral.contours.nodes, profile.neutral.contours.nodes);
  EXPECT_EQ(back.neutral.contours.confidence, profile.neutral.contours.confidence);
}

TEST(ProfileFile, DamageIsNamedInOneLine) {
  const ScratchFolder folder;
  const std::string path = folder / "me.json";
  write_profile(path, some_profile());
  std::string text = bytes_of(path);
  const auto expect_complaint = [&](const std::string& content, const std::string& what) {
    std::ofstream(path) << content;
    try {
      read_profile(path);
      ADD_FAILURE() << what;
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find("me.json"), std::string::npos) << message;
      EXPECT_NE(message.find(what), std::string::npos) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
  };
  expect_complaint(text.substr(0, text.size() / 2), "not valid JSON");
  expect_complaint("[]", "has no schema");
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    changed.replace(changed.find(from), from.size(), to);
    return changed;
  };
  expect_complaint(replaced("zygoma-profile/1", "zygoma-profile/9"), "schema");
  expect_complaint(replaced("_major_L\": 1.25", "_major_L\": 125"), "range.zygomaticus_major_L");
  expect_complaint(replaced("\"range\"", "\"rage\""), "has no range");
  expect_complaint(replaced("\"brow_left\"", "\"brow_lost\""), "'brow_lost' is unknown");
}

TEST(RetargetCommand, AProfileIsSavedUsedAndRefusedForAnother) {
  const ScratchFolder folder;
  const std::string contours = folder / "contours.csv";
  const std::string profile = folder / "me.json";
  write_smile(contours, fake::make_face());
  const auto retarget = [&](std::vector<std::string> more) {
    more.insert(more.begin(),
                {"retarget", contours, "--quality", "draft", "-o", folder / "result"});
    return run_program(folder, more);
  };
  Outcome result = retarget({"--smooth", "stable", "--save-profile", profile});
  ASSERT_EQ(result.code, 0) << result.err;
  for (const char* file : {"contractions.csv",
                           "contractions_filtered.csv",
                           "retarget_report.json",
                           "contractions.svg",
                           "session.json"}) {
    EXPECT_TRUE(std::filesystem::exists(folder / (std::string("result/") + file))) << file;
  }
  EXPECT_FALSE(read_profile(profile).range.empty());

  result = retarget({"--profile", profile});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.err.find("another performer"), std::string::npos) << result.err;
  // The performer's own full strength is 1.
  double strongest = 0.0;
  for (const Contractions& frame :
       read_contractions_csv(folder / "result/contractions.csv").frames) {
    strongest = std::max(strongest, frame.value[0]);
  }
  EXPECT_GT(strongest, 0.85);

  write_smile(contours, fake::make_other_face(0.55, 1.5, 20.0));
  result = retarget({"--profile", profile});
  EXPECT_EQ(result.code, 2);
  EXPECT_NE(result.err.find("is of another performer"), std::string::npos) << result.err;
}

TEST(AnimateCommand, TheSameCurvesDriveAnotherFace) {
  const ScratchFolder folder;
  const std::string contours = folder / "contours.csv";
  write_smile(contours, fake::make_face());
  Outcome result =
      run_program(folder, {"retarget", contours, "--quality", "draft", "-o", folder / "result"});
  ASSERT_EQ(result.code, 0) << result.err;
  const std::string scene = folder.write(
      "child.json",
      R"({"head": {"surface_vertices": 300, "albedo_size_px": 64, "identity": {"face_width": 1.06,
          "chin_length": 0.94}}, "motion": {"frames_per_s": 30, "duration_s": 0.1,
          "keys": [{"time_s": 0}]}})");
  const std::vector<std::string> base{
      "animate", folder / "result/contractions.csv", "--height", "120", "-o"};
  std::vector<std::string> usual = base;
  usual.push_back(folder / "usual.mp4");
  std::vector<std::string> other = base;
  other.insert(other.end(), {folder / "other.mp4", "--face", scene});
  result = run_program(folder, usual);
  ASSERT_EQ(result.code, 0) << result.err;
  result = run_program(folder, other);
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("45 frames animated"), std::string::npos) << result.out;
  EXPECT_NE(bytes_of(folder / "usual.mp4"), bytes_of(folder / "other.mp4"));
  result = run_program(
      folder,
      {"animate", folder / "result/contractions.csv", "-o", folder / "x.mp4", "--face", contours});
  EXPECT_EQ(result.code, 2);
}

}  // namespace
}  // namespace zygoma
