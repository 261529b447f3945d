#include "tracker/confidence.h"

#include <gtest/gtest.h>

#include <string>

#include "tracker/feature_schema.h"

namespace zygoma {
namespace {

TEST(Confidence, FallsWithEveryTermAndStaysAProbability) {
  for (const Feature& feature : kFeatureSchema) {
    const ConfidenceMap& map = confidence_map(feature.name);
    for (unsigned k = 0; k < kNumConfidenceTerms; ++k) {
      EXPECT_GT(map.weight[k], 0.0) << feature.name;
      double before = kMostConfidence;
      for (const double value : {1.0, 0.7, 0.3, 0.1, 0.02, 0.0, -1.0}) {
        ConfidenceTerms terms = kBestTerms;
        terms[k] = value;
        const double c = confidence_of(map, terms);
        EXPECT_LE(c, before) << feature.name << ", " << to_string(static_cast<ConfidenceTerm>(k));
        EXPECT_GT(c, 0.0);
        before = c;
      }
    }
    ConfidenceTerms worst{};
    EXPECT_LT(confidence_of(map, worst), 0.3) << feature.name;
  }
}

TEST(Confidence, SidesShareAMapAndTheUnknownHaveOne) {
  EXPECT_EQ(&confidence_map("brow_left"), &confidence_map("brow_right"));
  EXPECT_NE(&confidence_map("brow_left"), &confidence_map("upper_lip"));
  EXPECT_GT(confidence_of(confidence_map("ear_left"), kBestTerms), 0.5);
}

TEST(Confidence, NamesTheTermThatCostsMost) {
  const ConfidenceMap map{2.0, {1.0, 1.0, 0.1, 1.0, 1.0, 1.0}};
  ConfidenceTerms terms = kBestTerms;
  terms[kSight] = 0.1;     // costs 0.23
  terms[kPresence] = 0.7;  // costs 0.36
  EXPECT_EQ(to_string(weakest_term(map, terms)), "presence");
  terms[kNearness] = 0.2;
  EXPECT_EQ(weakest_term(map, terms), kNearness);
}

}  // namespace
}  // namespace zygoma
