// Looking things up by name: in texts and in structs, and what is said when there is no such name.
#include "src/base/names.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "tests/src/scratch_folder.h"

namespace zygoma {
namespace {

struct Planet {
  std::string_view name;
  int moons;
};
constexpr std::array<Planet, 3> kPlanets{{{"Venus", 0}, {"Earth", 1}, {"Mars", 2}}};
static_assert(find_name(kPlanets, "Mars") == 2);

TEST(Names, AreFoundInTextsAndInStructs) {
  const std::vector<std::string> words{"front", "profile", "front"};
  EXPECT_EQ(find_name(words, "front"), 0);
  EXPECT_EQ(find_name(words, "profile"), 1);
  EXPECT_EQ(find_name(words, "pro"), -1);
  EXPECT_EQ(find_name(words, "Profile"), -1);
  EXPECT_EQ(kPlanets[require_name("planet", kPlanets, "Earth")].moons, 1);
  EXPECT_EQ(joined_names(kPlanets), "Venus, Earth, Mars");
  EXPECT_EQ(joined_names(words, " | "), "front | profile | front");
  EXPECT_EQ(joined_names(std::vector<std::string>()), "");
}

TEST(Names, ThatAreUnknownAreRefusedWithTheOthers) {
  const auto refusal = [](const auto& list, const std::string& name) {
    return message_of<InputError>([&] { require_name("planet", list, name); });
  };
  EXPECT_EQ(refusal(kPlanets, "Pluto"),
            "planet 'Pluto' is unknown, expected one of Venus, Earth, Mars");
  EXPECT_EQ(refusal(std::vector<Planet>(), "Pluto"), "planet 'Pluto' is unknown, expected none");
  EXPECT_EQ(refusal(kPlanets, "two\nlines"),
            "planet 'two?lines' is unknown, expected one of Venus, Earth, Mars");
  EXPECT_LT(refusal(kPlanets, std::string(5000, 'x')).size(), 120U);
}

}  // namespace
}  // namespace zygoma
