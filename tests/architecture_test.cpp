// The tables below ARE the architecture: which room may include which rooms and which libraries.
// Every #include of the project is held against them, so a knot between folders shows up as
// `face/x.cpp:2: face must not include retarget` instead of as a habit.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace zygoma {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

// A library: its headers begin with one of the prefixes.
struct Library {
  std::string name;
  Words prefixes;
};

const std::vector<Library> kLibraries{
    {"OpenCV core", {"opencv2/core"}},
    {"OpenCV imgproc", {"opencv2/imgproc"}},
    {"OpenCV video", {"opencv2/video.hpp", "opencv2/video/"}},
    {"OpenCV objdetect", {"opencv2/objdetect"}},
    {"OpenCV face", {"opencv2/face"}},
    {"OpenCV imgcodecs", {"opencv2/imgcodecs"}},
    {"OpenCV videoio", {"opencv2/videoio"}},
    {"Eigen", {"Eigen/"}},
    {"Ceres", {"ceres/"}},
    {"CHOLMOD", {"suitesparse/"}},
    {"Embree", {"embree3/", "embree4/"}},
    {"FFmpeg", {"libavformat/", "libavcodec/", "libavutil/", "libswscale/"}},
    {"nlohmann-json", {"nlohmann/"}},
    {"CLI11", {"CLI/"}},
    {"GoogleTest", {"gtest/", "gmock/"}},
    {"Google Benchmark", {"benchmark/"}},
    {"Bullet", {"BulletCollision/", "BulletSoftBody/"}},
    {"SIMD intrinsics", {"immintrin.h"}},
    {"POSIX", {"unistd.h", "sys/", "fcntl.h", "dlfcn.h", "spawn.h", "malloc.h"}},
};

struct Room {
  std::string folder;
  Words rooms;                // that it may include besides itself
  Words libraries;            // that any of its files may include
  Words libraries_in_source;  // that only its .cpp files may include: slow to compile, or private
};

// Engines neither print, nor read clocks, nor catch signals: whoever runs them does.
const Words kEngines{
    "src/base", "tracker", "face", "retarget", "src/io", "src/render", "src/synthetic"};
const Words kNotForEngines{"iostream", "chrono", "ctime", "csignal"};

const std::vector<Room> kRooms{
    {"src/base", {}, {}, {}},
    {"tracker",
     {"src/base"},
     {"OpenCV core", "Eigen"},
     {"OpenCV imgproc", "OpenCV video", "OpenCV objdetect", "OpenCV face"}},
    {"face", {"src/base"}, {"Eigen"}, {"SIMD intrinsics"}},
    {"retarget", {"src/base", "tracker", "face"}, {"Eigen"}, {"Ceres"}},
    {"src/io",
     {"src/base", "tracker", "face", "retarget"},
     {"OpenCV core", "Eigen"},
     {"OpenCV imgproc", "OpenCV imgcodecs", "OpenCV videoio", "FFmpeg", "nlohmann-json", "POSIX"}},
    {"src/render",
     {"src/base", "tracker", "face"},
     {"OpenCV core", "Eigen", "Embree"},
     {"OpenCV imgproc"}},
    {"src/synthetic",
     {"src/base", "tracker", "face", "src/render"},
     {"OpenCV core", "Eigen"},
     {"OpenCV imgproc"}},
    {"src/pipeline",
     {"src/base", "tracker", "face", "retarget", "src/io", "src/render", "src/synthetic"},
     {"OpenCV core", "Eigen"},
     {"OpenCV imgproc"}},
    {"src/cli",
     {"src/base",
      "tracker",
      "face",
      "retarget",
      "src/io",
      "src/render",
      "src/synthetic",
      "src/pipeline"},
     {"OpenCV core", "Eigen"},
     {"CLI11", "POSIX"}},
    {"src/main.cpp", {"src/cli"}, {}, {}},
    {"tests",
     {"src/base",
      "tracker",
      "face",
      "retarget",
      "src/io",
      "src/render",
      "src/synthetic",
      "src/pipeline",
      "src/cli"},
     {"OpenCV core",
      "OpenCV imgproc",
      "OpenCV video",
      "OpenCV objdetect",
      "OpenCV face",
      "OpenCV imgcodecs",
      "Eigen",
      "Ceres",
      "CHOLMOD",
      "nlohmann-json",
      "GoogleTest",
      "Google Benchmark",
      "Bullet",
      "SIMD intrinsics",
      "POSIX"},
     {}},
    {"samples",
     {"src/base",
      "tracker",
      "face",
      "retarget",
      "src/io",
      "src/render",
      "src/synthetic",
      "src/pipeline"},
     {"OpenCV core", "Eigen"},
     {"OpenCV imgproc", "OpenCV imgcodecs"}},
};

// Slow to compile, hence confined to a single file.
const Words kOnlyInOneFile{"CLI11"};

const std::set<std::string> kTopLevel{"CMakeLists.txt",
                                      "CMakePresets.json",
                                      "README.md",
                                      "LICENSE",
                                      "src",
                                      "tracker",
                                      "retarget",
                                      "face",
                                      "tests",
                                      "samples",
                                      "docs",
                                      "cmake",
                                      // not in the repository (.gitignore):
                                      "build",
                                      "compile_commands.json"};
constexpr int kMostFilesInBase = 5;

bool contains(const Words& words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

bool is_below(std::string_view path, std::string_view folder) {
  return path == folder ||
         (path.starts_with(folder) && path.size() > folder.size() && path[folder.size()] == '/');
}

const Room* room_of(std::string_view path) {
  for (const Room& room : kRooms) {
    if (is_below(path, room.folder)) return &room;
  }
  return nullptr;
}

const Library* library_of(std::string_view header) {
  for (const Library& library : kLibraries) {
    for (const std::string& prefix : library.prefixes) {
      if (!header.starts_with(prefix)) continue;
      // "opencv2/video" is not "opencv2/videoio": a prefix ends where a word ends.
      const char next = header.size() > prefix.size() ? header[prefix.size()] : '.';
      if (prefix.ends_with('/') || next == '.' || next == '/') return &library;
    }
  }
  return nullptr;
}

struct Include {
  int line = 0;
  bool quoted = false;
  std::string header;
};

std::vector<Include> includes_of(const std::string& text) {
  std::vector<Include> includes;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::string_view rest = line;
    const auto skip_blanks = [&rest] {
      const auto first = rest.find_first_not_of(" \t");
      rest.remove_prefix(first == std::string_view::npos ? rest.size() : first);
    };
    skip_blanks();
    if (!rest.starts_with('#')) continue;
    rest.remove_prefix(1);
    skip_blanks();
    if (!rest.starts_with("include")) continue;
    rest.remove_prefix(7);
    skip_blanks();
    if (rest.empty() || (rest.front() != '"' && rest.front() != '<')) continue;
    const bool quoted = rest.front() == '"';
    const auto end = rest.find(quoted ? '"' : '>', 1);
    includes.push_back({number, quoted, std::string(rest.substr(1, end - 1))});
  }
  return includes;
}

class Survey {
 public:
  explicit Survey(fs::path root) : root_(std::move(root)) {
    for (const Room& room : kRooms) {
      if (fs::exists(root_ / room.folder)) survey_folder(room.folder);
    }
    survey_top_level();
    for (const auto& [library, files] : files_with_library_) {
      if (!contains(kOnlyInOneFile, library) || files.size() < 2) continue;
      for (const std::string& file : files) {
        complain(file + ": " + library + " belongs in one file only");
      }
    }
  }

  const Words& violations() const { return violations_; }
  int num_files() const { return num_files_; }

 private:
  void complain(const std::string& violation) { violations_.push_back(violation); }

  void survey_folder(const std::string& folder) {
    if (fs::is_regular_file(root_ / folder)) return survey_file(folder);
    int num_files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(root_ / folder)) {
      if (!entry.is_regular_file()) continue;
      ++num_files;
      const std::string extension = entry.path().extension().string();
      if (extension != ".h" && extension != ".cpp") continue;
      survey_file(fs::relative(entry.path(), root_).generic_string());
    }
    if (folder == "src/base" && num_files > kMostFilesInBase) {
      complain("src/base: " + std::to_string(num_files) + " files, at most " +
               std::to_string(kMostFilesInBase) + ": it must not become a drawer");
    }
  }

  void survey_file(const std::string& path) {
    ++num_files_;
    std::ifstream file(root_ / path, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(file)),
                           std::istreambuf_iterator<char>());
    const bool is_header = path.ends_with(".h");
    if (is_header && text.find("\n#pragma once\n") == std::string::npos) {
      complain(path + ": a header needs #pragma once");
    }
    const std::string name = fs::path(path).stem().string();
    if (name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") != std::string::npos) {
      complain(path + ": file names are snake_case");
    }
    const Room& room = *room_of(path);
    for (const Include& include : includes_of(text)) {
      const std::string place = path + ":" + std::to_string(include.line) + ": ";
      if (include.quoted) {
        check_own(room, place, include.header);
      } else {
        check_foreign(room, place, include.header, is_header);
      }
    }
  }

  void check_own(const Room& room, const std::string& place, const std::string& header) {
    if (header.starts_with("generated/")) return;  // by the build, for the room itself
    const Room* target = room_of(header);
    if (target == nullptr || !fs::exists(root_ / header)) {
      complain(place + "\"" + header + "\" is not a path from the root of the project");
    } else if (target != &room && !contains(room.rooms, target->folder)) {
      complain(place + room.folder + " must not include " + target->folder);
    }
  }

  void check_foreign(const Room& room,
                     const std::string& place,
                     const std::string& header,
                     bool is_header) {
    const Library* library = library_of(header);
    if (library == nullptr) {
      const bool is_standard = header.find_first_of("./") == std::string::npos;
      if (!is_standard) complain(place + "<" + header + "> is of no library in the table");
      if (contains(kEngines, room.folder) && contains(kNotForEngines, header)) {
        complain(place + room.folder + " must not include <" + header + ">");
      }
      return;
    }
    const bool anywhere = contains(room.libraries, library->name);
    const bool in_source = contains(room.libraries_in_source, library->name);
    if (!anywhere && !in_source) {
      complain(place + room.folder + " must not include " + library->name);
    } else if (!anywhere && is_header) {
      complain(place + library->name + " belongs in the .cpp files of " + room.folder);
    }
    const std::string file = place.substr(0, place.find(':'));
    if (!room.folder.starts_with("tests")) files_with_library_[library->name].insert(file);
  }

  void survey_top_level() {
    for (const auto& entry : fs::directory_iterator(root_)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with('.') || kTopLevel.contains(name)) continue;
      complain(name + ": does not belong at the top level");
    }
  }

  fs::path root_;
  Words violations_;
  std::map<std::string, std::set<std::string>> files_with_library_;
  int num_files_ = 0;
};

TEST(ArchitectureTest, TheProjectKeepsToTheTables) {
  const Survey survey(ZYGOMA_SOURCE_DIR);
  for (const std::string& violation : survey.violations()) ADD_FAILURE() << violation;
  EXPECT_GT(survey.num_files(), 30);
}

TEST(ArchitectureTest, TheTablesHaveNoCycle) {
  // A room may only include rooms listed above it.
  Words above;
  for (const Room& room : kRooms) {
    for (const std::string& target : room.rooms) {
      EXPECT_TRUE(contains(above, target)) << room.folder << " includes " << target;
    }
    above.push_back(room.folder);
  }
}

TEST(ArchitectureTest, EveryLibraryInTheTablesIsKnown) {
  for (const Room& room : kRooms) {
    for (const Words& names : {room.libraries, room.libraries_in_source}) {
      for (const std::string& name : names) {
        EXPECT_TRUE(std::any_of(kLibraries.begin(), kLibraries.end(), [&](const Library& library) {
          return library.name == name;
        })) << name;
      }
    }
  }
}

// A project of a few files with something wrong in it.
class PlantedProject : public testing::Test {
 protected:
  PlantedProject() {
    root_ = fs::temp_directory_path() / ("zygoma_planted_" + std::to_string(getpid()));
    fs::remove_all(root_);
    write("face/a.h", "\n#pragma once\n");
    write("retarget/b.h", "\n#pragma once\n");
    write("tracker/c.h", "\n#pragma once\n");
  }
  ~PlantedProject() override {
    std::error_code ignored;
    fs::remove_all(root_, ignored);
  }

  void write(const std::string& path, const std::string& text) const {
    fs::create_directories((root_ / path).parent_path());
    std::ofstream(root_ / path) << text;
  }

  void expect(const Words& violations) const {
    Words found = Survey(root_).violations();
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, violations);
  }

  fs::path root_;
};

TEST_F(PlantedProject, IsFineWithoutViolation) {
  write("retarget/x.cpp", "#include <ceres/ceres.h>\n#include <vector>\n#include \"face/a.h\"\n");
  expect({});
}

TEST_F(PlantedProject, ShowsAForbiddenRoom) {
  write("face/x.cpp", "#include \"face/a.h\"\n#include \"retarget/b.h\"\n");
  write("tracker/y.cpp", "  #  include \"face/a.h\"\n");
  expect({"face/x.cpp:2: face must not include retarget",
          "tracker/y.cpp:1: tracker must not include face"});
}

TEST_F(PlantedProject, ShowsAForbiddenLibrary) {
  write("face/x.cpp", "#include <opencv2/core.hpp>\n");
  write("retarget/d.h", "\n#pragma once\n#include <ceres/ceres.h>\n");
  write("tracker/y.cpp", "#include <opencv2/video/tracking.hpp>\n#include <opencv2/videoio.hpp>\n");
  write("tracker/z.cpp", "#include <QtWidgets/QWidget>\n");
  expect({"face/x.cpp:1: face must not include OpenCV core",
          "retarget/d.h:3: Ceres belongs in the .cpp files of retarget",
          "tracker/y.cpp:2: tracker must not include OpenCV videoio",
          "tracker/z.cpp:1: <QtWidgets/QWidget> is of no library in the table"});
}

TEST_F(PlantedProject, ShowsAnEngineThatReadsTheClock) {
  write("face/x.cpp", "#include <chrono>\n");
  expect({"face/x.cpp:1: face must not include <chrono>"});
}

TEST_F(PlantedProject, ShowsASlowLibraryInTwoFiles) {
  write("src/cli/x.cpp", "#include <CLI/CLI.hpp>\n");
  write("src/cli/y.cpp", "#include <CLI/CLI.hpp>\n");
  expect({"src/cli/x.cpp: CLI11 belongs in one file only",
          "src/cli/y.cpp: CLI11 belongs in one file only"});
}

TEST_F(PlantedProject, ShowsHeadersNamesAndPathsThatAreWrong) {
  write("face/bare.h", "#include <vector>\n");
  write("face/CamelCase.cpp", "");
  write("face/x.cpp", "#include \"a.h\"\n");
  expect({"face/CamelCase.cpp: file names are snake_case",
          "face/bare.h: a header needs #pragma once",
          "face/x.cpp:1: \"a.h\" is not a path from the root of the project"});
}

TEST_F(PlantedProject, ShowsClutter) {
  write("utils/x.cpp", "");
  write("notes.txt", "");
  write(".hidden", "");
  for (const char* name : {"1", "2", "3", "4", "5", "6"}) {
    write(std::string("src/base/f") + name + ".h", "\n#pragma once\n");
  }
  expect({"notes.txt: does not belong at the top level",
          "src/base: 6 files, at most 5: it must not become a drawer",
          "utils: does not belong at the top level"});
}

}  // namespace
}  // namespace zygoma
