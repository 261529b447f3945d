#include "tests/hard/record.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <set>
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

// Whether every test of a case ran to its end, so that its rows are all there.
bool ran_in_full(const testing::TestSuite& suite) {
  return suite.test_to_run_count() == suite.total_test_count() && suite.skipped_test_count() == 0;
}

std::set<std::string> ids_of_suites(bool only_in_full) {
  std::set<std::string> ids;
  const testing::UnitTest& all = *testing::UnitTest::GetInstance();
  for (int s = 0; s < all.total_test_suite_count(); ++s) {
    const testing::TestSuite& suite = *all.GetTestSuite(s);
    if (!only_in_full || ran_in_full(suite)) ids.insert(id_of(suite.name()));
  }
  return ids;
}

// The page with the rows of the cases that ran replaced, and of those that are no more left out.
void write_page(const std::string& path) {
  const std::set<std::string> known = ids_of_suites(false), fresh = ids_of_suites(true);
  std::ifstream file(path);
  std::string text;
  std::string line;
  while (std::getline(file, line) && line != kTableHead) text += line + "\n";
  std::map<std::string, std::vector<std::string>> table;
  while (std::getline(file, line)) {
    const std::string id = line.starts_with("| HC-") ? line.substr(2, 5) : "";
    if (known.contains(id) && !fresh.contains(id)) table[id].push_back(line);
  }
  for (const Row& row : rows()) {
    if (!fresh.contains(row.id)) continue;
    table[row.id].push_back("| " + row.id + " | " + cell(row.scene) + " | " + cell(row.measured) +
                            " | " + cell(row.criterion) + " | " + row.outcome + " |");
  }
  std::ofstream page(path);
  page << text << kTableHead << "\n|---|---|---|---|---|\n";
  for (const auto& [id, lines] : table) {
    for (const std::string& row : lines) page << row << "\n";
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

  void OnTestProgramEnd(const testing::UnitTest&) override {
    const char* page = std::getenv("ZYGOMA_STABILITY_PAGE");
    if (page == nullptr) return;
    if (!kSanitized) write_page(page);
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
