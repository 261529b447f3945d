#include "tests/hard/record.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <vector>

namespace zygoma::hard {
namespace {

struct Row {
  std::string id, scene, measured, criterion, outcome;
};

std::vector<Row>& rows() {
  static std::vector<Row> all;
  return all;
}

std::string id_of(const std::string& suite) { return suite.substr(0, 2) + "-" + suite.substr(2); }

// A bar would end the cell.
std::string cell(const std::string& text) {
  std::string escaped;
  for (const char c : text) escaped += c == '|' ? std::string("\\|") : std::string(1, c);
  return escaped;
}

// What stands above the table.
std::string text_of(const std::string& path) {
  std::ifstream file(path);
  std::string text;
  for (std::string line; std::getline(file, line) && line != kTableHead;) text += line + "\n";
  return text;
}

void write_page(const std::string& path) {
  std::stable_sort(
      rows().begin(), rows().end(), [](const Row& a, const Row& b) { return a.id < b.id; });
  const std::string text = text_of(path);
  std::ofstream page(path);
  page << text << kTableHead << "\n|---|---|---|---|---|\n";
  for (const Row& row : rows()) {
    page << "| " << row.id << " | " << cell(row.scene) << " | " << cell(row.measured) << " | "
         << cell(row.criterion) << " | " << row.outcome << " |\n";
  }
  if (!page) std::fprintf(stderr, "%s: cannot be written\n", path.c_str());
}

class Recorder final : public testing::EmptyTestEventListener {
 public:
  void OnTestStart(const testing::TestInfo&) override { first_ = rows().size(); }

  void OnTestEnd(const testing::TestInfo& test) override {
    if (!test.result()->Failed()) return;
    for (std::size_t k = first_; k < rows().size(); ++k) rows()[k].outcome = "**fails**";
  }

  void OnTestProgramEnd(const testing::UnitTest& all) override {
    const char* page = std::getenv("ZYGOMA_STABILITY_PAGE");
    if (page == nullptr) return;
    if (!kSanitized && all.test_to_run_count() == all.total_test_count() &&
        all.skipped_test_count() == 0) {
      write_page(page);
    } else {
      std::fprintf(stderr, "%s: not written: not all tests ran in full\n", page);
    }
  }

 private:
  std::size_t first_ = 0;
};

[[maybe_unused]] const bool recording = [] {
  testing::UnitTest::GetInstance()->listeners().Append(new Recorder);
  return true;
}();

}  // namespace

void record(const std::string& scene,
            const std::string& measured,
            const std::string& criterion,
            Outcome outcome) {
  const char* words[] = {"holds", "refused", "reported", "open"};
  const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
  rows().push_back({id_of(test->test_suite_name()),
                    scene,
                    measured,
                    criterion,
                    words[static_cast<int>(outcome)]});
  std::printf("  %s: %s (%s)\n", scene.c_str(), measured.c_str(), rows().back().outcome.c_str());
}

std::string figure(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", value);
  return text;
}

bool long_tests() { return std::getenv("ZYGOMA_LONG_TESTS") != nullptr; }

}  // namespace zygoma::hard
