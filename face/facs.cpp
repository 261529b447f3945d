#include "face/facs.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

#include "face/muscle_table.h"
#include "src/base/names.h"

namespace zygoma {
namespace {

// Units without a muscle here, and what they need.
struct OtherUnit {
  int first;
  int last;
  const char* what;
};
constexpr std::array<OtherUnit, 10> kOthers{{
    {19, 19, "shows the tongue"},
    {29, 30, "moves the jaw forward or sideways, which here only opens"},
    {31, 31, "clenches the jaw, which shows in no skin here"},
    {32, 32, "bites a lip"},
    {33, 35, "fills or empties the cheeks with breath"},
    {36, 37, "moves the tongue"},
    {51, 58, "moves the head"},
    {61, 66, "turns the eyes"},
    {69, 76, "scores what can be seen of the face, and moves nothing"},
    {80, 82, "is swallowing, chewing or shrugging"},
}};

// Pairs that no face can show at once.
constexpr std::array<std::array<int, 2>, 6> kConflicts{
    {{26, 27}, {5, 41}, {5, 42}, {5, 43}, {5, 45}, {5, 46}}};

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

std::vector<std::string_view> split(std::string_view text, char at) {
  std::vector<std::string_view> parts;
  for (;;) {
    const auto end = text.find(at);
    parts.push_back(trimmed(text.substr(0, end)));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

// A whole number or a decimal at the head of the text, which is taken off; false if there is none.
template <typename Number>
bool take_number(std::string_view& text, Number& value) {
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc()) return false;
  text.remove_prefix(result.ptr - text.data());
  return true;
}

// One unit as written.
struct Token {
  std::string text;
  const ActionUnit* unit = nullptr;
  bool left = true;
  bool right = true;
  Lip lip = Lip::kBoth;
  double intensity = 1.0;

  bool meets(const Token& other) const {
    const bool side = (left && other.left) || (right && other.right);
    const bool flap = lip == Lip::kBoth || other.lip == Lip::kBoth || lip == other.lip;
    return side && flap;
  }
};

bool has_lips(const ActionUnit& unit) {
  return std::any_of(unit.pulls.begin(), unit.pulls.end(), [](const ActionPull& pull) {
    return pull.lip != Lip::kBoth;
  });
}

const ActionUnit& unit_of(int number, const std::string& where) {
  for (const ActionUnit& unit : action_units()) {
    if (unit.number == number) return unit;
  }
  for (const OtherUnit& other : kOthers) {
    require(number < other.first || number > other.last,
            where + ": action unit " + std::to_string(number) + " " + other.what +
                "; no muscle of this face does that");
  }
  throw InputError(where + ": there is no action unit " + std::to_string(number) +
                   " (zygoma face list aus shows them)");
}

void take_prefix(std::string_view& rest, const std::string& where, Token& token) {
  if (rest.starts_with('L') || rest.starts_with('R')) {
    (rest.front() == 'L' ? token.right : token.left) = false;
    rest.remove_prefix(1);
  }
  require(!rest.starts_with('U'),
          where + ": U says one side but not which; expected L or R of the subject");
  if (rest.starts_with('T') || rest.starts_with('B')) {
    token.lip = rest.front() == 'T' ? Lip::kTop : Lip::kBottom;
    rest.remove_prefix(1);
  }
}

double take_intensity(std::string_view rest, const std::string& where) {
  if (rest.empty()) return 1.0;
  if (rest.size() == 1 && rest[0] >= 'A' && rest[0] <= 'E') return (rest[0] - 'A' + 1) / 5.0;
  double percent = 0.0;
  std::string_view number = rest;
  if (number.starts_with(':')) {
    number.remove_prefix(1);
    if (take_number(number, percent) && number == "%") {
      require_range(where + ": intensity in %", percent, 0.0, 100.0);
      return percent / 100.0;
    }
  }
  throw InputError(where + ": intensity " + quote_value(rest) +
                   ", expected A to E or a percentage like :60%");
}

Token token_from(std::string_view text) {
  Token token;
  token.text = std::string(text);
  const std::string where = "action unit " + quote_value(text);
  std::string_view rest = text;
  take_prefix(rest, where, token);
  int number = 0;
  const bool has_digit = !rest.empty() && rest[0] >= '0' && rest[0] <= '9';
  require(has_digit && take_number(rest, number),
          where + ": no number, expected action units like 1+2+5B+R12A");
  token.unit = &unit_of(number, where);
  token.intensity = take_intensity(rest, where);
  require(token.lip == Lip::kBoth || has_lips(*token.unit),
          where + ": action unit " + std::to_string(number) + " has no top and bottom part");
  const bool jaw_alone = token.unit->pulls.empty();
  require((token.left && token.right) || !jaw_alone,
          where + ": action unit " + std::to_string(number) + " moves the jaw, which has no sides");
  require(!token.unit->one_sided || !token.left || !token.right,
          where + ": a " + token.unit->name + " has a side, expected L or R before the number");
  return token;
}

void require_together(const Token& a, const Token& b) {
  if (!a.meets(b)) return;
  const int x = a.unit->number;
  const int y = b.unit->number;
  require(x != y,
          "action unit " + std::to_string(x) + " is there twice, as " + quote_value(a.text) +
              " and " + quote_value(b.text));
  for (const auto& [one, other] : kConflicts) {
    const bool both = (x == one && y == other) || (x == other && y == one);
    require(!both,
            "action units " + std::to_string(one) + " and " + std::to_string(other) +
                " exclude each other");
  }
}

// The strongest wish wins.
void ask_for(Pose& pose, const std::string& muscle, double contraction) {
  double& wanted = pose.contraction[muscle];
  wanted = std::max(wanted, contraction);
}

void apply(const Token& token, Pose& pose) {
  for (const ActionPull& pull : token.unit->pulls) {
    const bool other_lip =
        token.lip != Lip::kBoth && pull.lip != Lip::kBoth && pull.lip != token.lip;
    if (other_lip) continue;
    const double contraction = pull.weight * token.intensity;
    if (token.left) ask_for(pose, std::string(pull.muscle) + "_L", contraction);
    if (token.right) ask_for(pose, std::string(pull.muscle) + "_R", contraction);
  }
  pose.jaw = std::max(pose.jaw, token.unit->jaw * token.intensity);
}

// Waters' macros in the values of his file, right and left side of the subject; `per_value` is
// what one unit of it shortens the muscle by, over our largest shortening: his displacement at the
// skin end over the length between the ends, divided by s.
struct MacroMuscle {
  const char* muscle;
  double per_value;
};
constexpr std::array<MacroMuscle, 9> kMacroMuscles{{
    {"zygomaticus_major", 0.109 / 0.30},
    {"depressor_anguli_oris", 0.492 / 0.35},
    {"occipitofrontalis_inner", 0.082 / 0.35},
    {"occipitofrontalis_major", 0.557 / 0.35},
    {"occipitofrontalis_outer", 0.162 / 0.33},
    {"levator_labii_superioris", 0.145 / 0.30},
    {"levator_labii_superioris_alaeque_nasi", 0.169 / 0.25},
    {"corrugator_supercilii", 0.241 / 0.58},
    // His secondary frontalis ends below the inner one and half as far from the bone.
    {"occipitofrontalis_inner", 0.5 * 0.345 / 0.25},
}};
struct Macro {
  const char* name;
  double value[9][2];
};
constexpr std::array<Macro, 6> kMacros{{
    {"waters:happiness",
     {{1.1, 1.0}, {0, 0}, {.8, .9}, {.2, .2}, {.1, .3}, {0, 0}, {0, 0}, {0, 0}, {0, 0}}},
    {"waters:anger",
     {{0, 0}, {.7, .6}, {.2, 0}, {.1, 0}, {2, 2}, {1.8, 1.9}, {1.2, 1.1}, {1.4, 1.3}, {.2, .3}}},
    {"waters:surprise",
     {{.2, .2}, {.4, .4}, {1.4, .9}, {.5, .4}, {.2, .7}, {0, 0}, {0, .1}, {0, 0}, {.5, .6}}},
    {"waters:sadness",
     {{0, 0}, {.7, .7}, {3.1, 3.9}, {0, 0}, {0, 0}, {.2, .7}, {.2, .2}, {0, 0}, {0, 0}}},
    {"waters:fear",
     {{.6, .5}, {.5, .5}, {.2, .2}, {.6, .5}, {.2, .2}, {.2, .2}, {.1, .1}, {.2, .2}, {.4, .3}}},
    {"waters:disgust",
     {{.8, .1}, {0, .5}, {.2, 0}, {0, 0}, {.4, 1.7}, {1.1, 2}, {.7, .2}, {2.3, 2.4}, {0, 0}}},
}};

Pose pose_of_macro(const Macro& macro) {
  Pose pose;
  for (std::size_t m = 0; m < kMacroMuscles.size(); ++m) {
    for (const int side : {0, 1}) {
      const double more = macro.value[m][side] * kMacroMuscles[m].per_value;
      if (more == 0.0) continue;
      double& c =
          pose.contraction[std::string(kMacroMuscles[m].muscle) + (side == 0 ? "_R" : "_L")];
      c = std::min(1.0, c + more);
    }
  }
  return pose;
}

// Both red margins.
std::vector<ActionPull> margins(double weight) {
  return {{"orbicularis_oris_marginal_superior", weight, Lip::kTop},
          {"orbicularis_oris_marginal_inferior", weight, Lip::kBottom}};
}

}  // namespace

const std::vector<ActionUnit>& action_units() {
  static const std::vector<ActionUnit> units{
      {1, "inner brow raiser", "upper", {{"occipitofrontalis_inner", 1.0}}},
      {2,
       "outer brow raiser",
       "upper",
       {{"occipitofrontalis_outer", 1.0}, {"occipitofrontalis_major", 0.5}}},
      {4,
       "brow lowerer",
       "upper",
       {{"corrugator_supercilii", 1.0}, {"depressor_supercilii", 1.0}, {"procerus", 0.6}}},
      {5, "upper lid raiser", "upper", {{"levator_palpebrae_superioris", 1.0}}},
      {6,
       "cheek raiser",
       "upper",
       {{"orbicularis_oculi_orbital", 1.0}, {"orbicularis_oculi_palpebral", 0.15}}},
      {7, "lid tightener", "upper", {{"orbicularis_oculi_palpebral", 0.35}}},
      {8, "lips toward each other", "miscellaneous", margins(0.6)},
      {9,
       "nose wrinkler",
       "vertical",
       {{"levator_labii_superioris_alaeque_nasi", 1.0},
        {"levator_labii_superioris", 0.4},
        {"procerus", 0.7},
        {"corrugator_supercilii", 0.3}}},
      {10, "upper lip raiser", "vertical", {{"levator_labii_superioris", 1.0}}},
      {11, "nasolabial deepener", "oblique", {{"zygomaticus_minor", 1.0}}},
      {12, "lip corner puller", "oblique", {{"zygomaticus_major", 1.0}}},
      {13, "sharp lip puller", "oblique", {{"levator_anguli_oris", 1.0}}},
      {14, "dimpler", "horizontal", {{"buccinator", 1.0}}},
      {15, "lip corner depressor", "vertical", {{"depressor_anguli_oris", 1.0}}},
      {16, "lower lip depressor", "vertical", {{"depressor_labii_inferioris", 1.0}}},
      {17, "chin raiser", "vertical", {{"mentalis", 1.0}}},
      {18,
       "lip pucker",
       "orbital",
       {{"incisivus_labii_superioris", 0.6, Lip::kTop},
        {"orbicularis_oris_superior", 0.8, Lip::kTop},
        {"incisivus_labii_inferioris", 0.6, Lip::kBottom},
        {"orbicularis_oris_inferior", 0.8, Lip::kBottom}}},
      {20, "lip stretcher", "horizontal", {{"risorius", 1.0}, {"platysma", 0.4}}},
      {21, "neck tightener", "miscellaneous", {{"platysma", 1.0}}},
      {22,
       "lip funneler",
       "orbital",
       {{"orbicularis_oris_superior", 0.8, Lip::kTop},
        {"levator_labii_superioris", 0.5, Lip::kTop},
        {"orbicularis_oris_inferior", 0.8, Lip::kBottom},
        {"depressor_labii_inferioris", 0.8, Lip::kBottom}},
       0.1},
      {23,
       "lip tightener",
       "orbital",
       {{"orbicularis_oris_marginal_superior", 0.8, Lip::kTop},
        {"incisivus_labii_superioris", 0.5, Lip::kTop},
        {"orbicularis_oris_marginal_inferior", 0.8, Lip::kBottom},
        {"incisivus_labii_inferioris", 0.5, Lip::kBottom}}},
      {24,
       "lip pressor",
       "orbital",
       {{"orbicularis_oris_marginal_superior", 0.8, Lip::kTop},
        {"orbicularis_oris_marginal_inferior", 0.8, Lip::kBottom},
        {"mentalis", 0.3, Lip::kBottom},
        {"buccinator", 0.2}}},
      {25, "lips part", "vertical", {{"depressor_labii_inferioris", 0.4}}, 0.06},
      {26, "jaw drop", "vertical", {}, 0.35},
      {27, "mouth stretch", "vertical", {}, 1.0},
      {28, "lip suck", "orbital", margins(1.0), 0.12},
      {38, "nostril dilator", "miscellaneous", {{"nasalis_alar", 1.0}}},
      {39, "nostril compressor", "miscellaneous", {{"nasalis_transverse", 1.0}}},
      {41, "lid droop", "upper", {{"orbicularis_oculi_palpebral", 0.25}}},
      {42, "slit", "upper", {{"orbicularis_oculi_palpebral", 0.75}}},
      {43, "eyes closed", "upper", {{"orbicularis_oculi_palpebral", 1.0}}},
      {44,
       "squint",
       "upper",
       {{"orbicularis_oculi_palpebral", 0.5}, {"orbicularis_oculi_orbital", 0.5}}},
      {45, "blink", "upper", {{"orbicularis_oculi_palpebral", 1.0}}},
      {46, "wink", "upper", {{"orbicularis_oculi_palpebral", 1.0}}, 0.0, true},
  };
  return units;
}

const std::vector<Expression>& expressions() {
  static const std::vector<Expression> all = [] {
    std::vector<Expression> list{{"neutral", "", {}}};
    // EMFACS.
    for (const auto& [name, units] : {std::pair{"happiness", "6+12"},
                                      {"sadness", "1+4+15"},
                                      {"surprise", "1+2+5B+26"},
                                      {"fear", "1+2+4+5+20+26"},
                                      {"anger", "4+5+7+23"},
                                      {"disgust", "9+15+16"},
                                      {"contempt", "R12A+R14A"}}) {
      list.push_back({name, units, pose_of_action_units(units)});
    }
    for (const Macro& macro : kMacros) list.push_back({macro.name, "", pose_of_macro(macro)});
    return list;
  }();
  return all;
}

Pose pose_of_action_units(const std::string& text) {
  std::vector<Token> tokens;
  for (const std::string_view part : split(text, '+')) {
    require(
        !part.empty(),
        "action units " + quote_value(text) + ": one is empty, expected units like 1+2+5B+R12A");
    tokens.push_back(token_from(part));
  }
  Pose pose;
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) require_together(tokens[k], tokens[i]);
    apply(tokens[i], pose);
  }
  return pose;
}

Pose pose_of_expression(const std::string& name) {
  const int place = find_name(expressions(), name);
  require(place >= 0,
          "expression " + quote_value(name) + " is unknown, expected one of " +
              joined_names(expressions()) + ", action units like 1+2+5B, or muscle=value");
  return expressions()[place].pose;
}

Pose pose_of_muscles(const std::string& text) {
  Pose pose;
  bool has_jaw = false;
  for (const std::string_view part : split(text, ',')) {
    const auto equals = part.find('=');
    require(equals != std::string_view::npos,
            quote_value(part) + " has no value, expected muscle=value,muscle=value,...");
    const std::string name(trimmed(part.substr(0, equals)));
    std::string_view number = trimmed(part.substr(equals + 1));
    double value = 0.0;
    require(take_number(number, value) && number.empty() && std::isfinite(value),
            name + " is " + quote_value(trimmed(part.substr(equals + 1))) +
                ", expected a number in [0, 1]");
    require_range(name, value, 0.0, 1.0);
    if (name == "jaw") {
      require(!has_jaw, "jaw is there twice");
      has_jaw = true;
      pose.jaw = value;
      continue;
    }
    for (const std::string& muscle : muscles_meant("", name)) {
      require(pose.contraction.emplace(muscle, value).second,
              "muscle " + muscle + " is there twice");
    }
  }
  return pose;
}

Pose pose_of(const std::string& text) {
  const std::string_view trim = trimmed(text);
  require(!trim.empty(), "no expression given, expected a name, action units or muscle=value");
  if (trim.find('=') != std::string_view::npos) return pose_of_muscles(text);
  const bool has_digit = trim.find_first_of("0123456789") != std::string_view::npos;
  return has_digit ? pose_of_action_units(text) : pose_of_expression(std::string(trim));
}

Controls controls_of(const Pose& pose, const Anatomy& anatomy) {
  Controls controls{std::vector<double>(anatomy.muscles.size(), 0.0),
                    pose.jaw * anatomy.jaw.full_rad};
  for (const auto& [muscle, value] : pose.contraction) {
    const int index = anatomy.muscle_index(muscle);
    require(index >= 0, "muscle '" + muscle + "': this face has no muscle of that name");
    controls.contraction[index] = value;
  }
  return controls;
}

}  // namespace zygoma
