// docs/stability.md and the tests say the same: every id of its table is a test suite, and every
// test suite of a hard case is in the table.
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <string>

#include "tests/hard/record.h"

namespace zygoma::hard {
namespace {

TEST(StabilityPage, HasARowForEveryHardCase) {
  std::ifstream page(std::string(ZYGOMA_SOURCE_DIR) + "/docs/stability.md");
  std::set<std::string> listed;
  bool in_table = false;
  for (std::string line; std::getline(page, line);) {
    in_table = in_table || line == kTableHead;
    if (in_table && line.starts_with("| HC-")) listed.insert("HC" + line.substr(5, 2));
  }
  EXPECT_TRUE(in_table);
  std::set<std::string> tested;
  const testing::UnitTest& all = *testing::UnitTest::GetInstance();
  for (int s = 0; s < all.total_test_suite_count(); ++s) {
    const std::string suite = all.GetTestSuite(s)->name();
    if (suite.starts_with("HC")) tested.insert(suite);
  }
  EXPECT_EQ(listed, tested);
}

}  // namespace
}  // namespace zygoma::hard
