// What the hard cases measured, as the table of docs/stability.md.
//
// Every test of a hard case records one row or more. The id of a row is the name of its test suite
// (HC07 is HC-07), so the two cannot disagree. With ZYGOMA_STABILITY_PAGE naming a file, the test
// program replaces the rows of those cases in it whose tests all ran; text above the table stays:
//
//   ZYGOMA_LONG_TESTS=1 ZYGOMA_STABILITY_PAGE=docs/stability.md build/release/tests/hard_tests
#pragma once

#include <string>

namespace zygoma::hard {

enum class Outcome {
  kHolds,     // the criterion is met
  kRefused,   // bad input that is named and rejected
  kReported,  // the criterion asks for no more than that the row says so
  kOpen,      // the criterion is not met, or met in part; the row says how far
};

// A row of the test that runs. If the test fails, the row says so.
void record(const std::string& scene,
            const std::string& measured,
            const std::string& criterion,
            Outcome outcome = Outcome::kHolds);

// Two significant digits: 1.3e-09, 0.42, 17.
std::string figure(double value);

// Whether cases that take minutes were asked for (ZYGOMA_LONG_TESTS is set).
bool long_tests();

// Sanitizers make everything 10 to 30 times slower: this many of so many repetitions then.
#ifdef __SANITIZE_ADDRESS__
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif
inline constexpr int repetitions(int usual) { return kSanitized ? (usual + 14) / 15 : usual; }

// Where the table of the page begins.
inline constexpr const char* kTableHead = "| id | case | measured | criterion | outcome |";

}  // namespace zygoma::hard
