// zygoma strip: its tables hold what its plots show, close to the closed forms where those hold.
#include <gtest/gtest.h>

#include <cmath>

#include "src/io/text.h"
#include "tests/src/program.h"
#include "tests/src/scratch_folder.h"

namespace zygoma {
namespace {

// Of the small strains, as a share of the largest value.
double deviation(const CsvTable& table, const char* measured, const char* closed_form) {
  double off = 0.0;
  double largest = 0.0;
  for (int row = 0; row < table.num_rows(); ++row) {
    if (!table.cell(row, table.find("curve")).starts_with("small")) continue;
    EXPECT_EQ(table.cell(row, table.find("converged")), "1") << "row " << row;
    const double expected = table.number(row, table.find(closed_form), -1e9, 1e9);
    off = std::max(off, std::abs(table.number(row, table.find(measured), -1e9, 1e9) - expected));
    largest = std::max(largest, std::abs(expected));
  }
  return off / largest;
}

TEST(StripCommandTest, WritesCurvesThatFollowTheClosedForms) {
  const ScratchFolder folder;
  const Outcome outcome = run_program(
      folder, {"strip", "-o", folder / "out", "--with", "viscosity:ratio=0.8,relaxation_s=0.1"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("relaxation"), std::string::npos) << outcome.out;
  for (const char* name : {"stress_strain", "relaxation", "creep", "hysteresis"}) {
    const std::string svg = bytes_of(folder / ("out/strip_" + std::string(name) + ".svg"));
    EXPECT_TRUE(svg.starts_with("<svg ")) << name;
    EXPECT_EQ(svg.find("nan"), std::string::npos) << name;
  }
  const auto table = [&](const char* name, const std::string& closed_form) {
    return CsvTable(folder / ("out/strip_" + std::string(name) + ".csv"),
                    "curves",
                    {"curve", "time_s", "strain", "stress_kpa", closed_form, "converged"});
  };
  const auto stress = [&](const char* name) {
    return deviation(table(name, "closed_form_kpa"), "stress_kpa", "closed_form_kpa");
  };
  EXPECT_LT(stress("relaxation"), 1e-3);
  EXPECT_LT(stress("hysteresis"), 1e-3);
  const CsvTable creep = table("creep", "closed_form_strain");
  EXPECT_LT(deviation(creep, "strain", "closed_form_strain"), 1e-3);
  // The printed law has no equilibrium where its force jumps; the smooth one always has.
  const CsvTable slow = table("stress_strain", "closed_form_kpa");
  int failed_as_printed = 0;
  for (int row = 0; row < slow.num_rows(); ++row) {
    const bool converged = slow.cell(row, slow.find("converged")) == "1";
    const bool printed = slow.cell(row, slow.find("curve")) == "printed_law";
    EXPECT_TRUE(converged || printed) << "row " << row;
    failed_as_printed += converged ? 0 : 1;
  }
  EXPECT_GT(failed_as_printed, 0);
  EXPECT_NE(outcome.err.find("printed_law: no equilibrium in"), std::string::npos) << outcome.err;
}

TEST(StripCommandTest, TakesOnlyEffectsWithinTheTissue) {
  const ScratchFolder folder;
  const Outcome outcome = run_program(folder, {"strip", "-o", folder / "out", "--with", "gravity"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("gravity acts from outside"), std::string::npos) << outcome.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "out")) << "left behind";
}

}  // namespace
}  // namespace zygoma
