#include "src/io/corrections_file.h"

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "src/base/check.h"
#include "src/io/json_input.h"
#include "src/io/text.h"

namespace zygoma {
namespace {

using nlohmann::json;

constexpr const char* kKind =
    R"(a corrections file of lines like {"id": 1, "frame": 57, "contour": "upper_lip", )"
    R"("kind": "spring", "s": 0.5, "x": 212.4, "y": 301.7})";

// One line of the file.
class Line {
 public:
  Line(std::string where, const std::string& text) : where_(std::move(where)) {
    try {
      object_ = json::parse(text);
    } catch (const json::exception&) {
      throw InputError(where_ + ": " + quote_value(text) + ", expected " + kKind);
    }
    require(object_.is_object(), where_ + ": " + quote_value(text) + ", expected " + kKind);
  }

  const std::string& where() const { return where_; }
  bool has(const char* key) const { return object_.contains(key); }

  double number(const char* key, std::optional<double> usual = std::nullopt) const {
    if (!has(key) && usual) return *usual;
    const json& value = at(key);
    const bool finite = value.is_number() && std::isfinite(value.get<double>());
    if (!finite) complain(key, value, "a number");
    return value.get<double>();
  }

  int whole(const char* key) const {
    const double value = number(key);
    const bool fits = value >= 0.0 && value <= 1e9 && value == std::floor(value);
    if (!fits) complain(key, at(key), "a whole number, 0 or above");
    return static_cast<int>(value);
  }

  std::string text(const char* key) const {
    const json& value = at(key);
    if (!value.is_string()) complain(key, value, "a text");
    return value.get<std::string>();
  }

  void expect_only(const std::set<std::string>& keys) const {
    for (const auto& [key, value] : object_.items()) {
      if (!keys.contains(key)) complain(key, value, "no such entry");
    }
  }

  [[noreturn]] void complain(const std::string& key,
                             const json& value,
                             const std::string& expected) const {
    zygoma::complain(where_ + ": " + key, value, expected);
  }

 private:
  const json& at(const char* key) const {
    const auto found = object_.find(key);
    require(found != object_.end(), where_ + ": no " + key + ", expected " + kKind);
    return *found;
  }

  std::string where_;
  json object_;
};

Correction correction_from(const Line& line) {
  line.expect_only({"id", "frame", "contour", "kind", "s", "x", "y", "k", "radius"});
  Correction correction;
  correction.id = line.whole("id");
  correction.frame = line.whole("frame");
  correction.contour = line.text("contour");
  const std::map<std::string, MouseForce> kinds{{"spring", MouseForce::kSpring},
                                                {"pin", MouseForce::kPin},
                                                {"volcano", MouseForce::kVolcano}};
  const std::string kind = line.text("kind");
  const auto known = kinds.find(kind);
  if (known == kinds.end()) line.complain("kind", kind, "spring, pin or volcano");
  correction.force = known->second;
  const bool volcano = correction.force == MouseForce::kVolcano;
  correction.along = volcano ? 0.0 : line.number("s");
  correction.at_px = {line.number("x"), line.number("y")};
  correction.stiffness = line.number("k", correction.stiffness);
  correction.radius = volcano ? line.number("radius") : line.number("radius", correction.radius);
  try {
    correction.check();
  } catch (const InputError& error) {
    throw InputError(line.where() + ": " + error.what());
  }
  return correction;
}

// Events in the order of the file; which of them are undone is decided from the last one back.
struct Events {
  std::map<int, Correction> corrections;
  std::vector<std::pair<int, int>> undos;  // id, and what it takes away

  bool knows(int id) const {
    if (corrections.contains(id)) return true;
    for (const auto& [undo, undone] : undos) {
      if (undo == id) return true;
    }
    return false;
  }
};

void add_event(const Line& line, Events& events) {
  const int id = line.whole("id");
  require(!events.knows(id),
          line.where() + ": id " + std::to_string(id) + " is taken, expected a new one");
  if (!line.has("undo")) {
    events.corrections.emplace(id, correction_from(line));
    return;
  }
  line.expect_only({"id", "undo"});
  const int undone = line.whole("undo");
  require(events.knows(undone),
          line.where() + ": undo: no event has the id " + std::to_string(undone) +
              ", expected one of a line above");
  events.undos.emplace_back(id, undone);
}

}  // namespace

std::vector<Correction> read_corrections(const std::string& path) {
  const std::string text = read_text_file(path, kKind);
  Events events;
  int number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string line = text.substr(begin, end - begin);
    begin = end + 1;
    ++number;
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    add_event(Line(path + ":" + std::to_string(number), line), events);
  }
  std::set<int> gone;
  for (auto undo = events.undos.rbegin(); undo != events.undos.rend(); ++undo) {
    if (!gone.contains(undo->first)) gone.insert(undo->second);
  }
  std::vector<Correction> in_force;
  for (const auto& [id, correction] : events.corrections) {
    if (!gone.contains(id)) in_force.push_back(correction);
  }
  return in_force;
}

}  // namespace zygoma
