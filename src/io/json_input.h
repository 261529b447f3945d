// What the readers of JSON share: one way to parse and one to complain.
//
// Templates of the library's value, so that the library itself stays out of headers.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "src/base/check.h"
#include "src/io/text.h"

namespace zygoma {

// Throws InputError("FILE: contours.brow_left[3]: VALUE, expected WHAT").
template <class Json>
[[noreturn]] void complain(const std::string& where,
                           const Json& value,
                           const std::string& expected) {
  // Objects and lists are not repeated: they can be long, and deep enough to be a trap.
  std::string text = value.is_object()  ? "an object"
                     : value.is_array() ? "a list of " + std::to_string(value.size())
                                        : "";
  if (text.empty()) {
    text = quote_value(value.dump(-1, ' ', true, Json::error_handler_t::replace));
  }
  throw InputError(where + ": " + text + ", expected " + expected);
}

// The whole file. `kind` says what was expected. Refuses what the library would pass over, too: a
// key that is there twice.
template <class Json>
Json parse_json(const std::string& path, const std::string& kind) {
  const std::string text = read_text_file(path, kind);
  std::vector<std::set<std::string>> keys;  // of the objects that are open
  std::string last_key;
  const auto watch = [&](int /*depth*/, typename Json::parse_event_t event, Json& value) {
    if (event == Json::parse_event_t::object_start) keys.emplace_back();
    if (event == Json::parse_event_t::object_end) keys.pop_back();
    if (event == Json::parse_event_t::key) {
      last_key = value.template get<std::string>();
      require(keys.back().insert(last_key).second,
              path + ": the key " + quote_value(last_key) + " is there twice in one object");
    }
    return true;
  };
  try {
    return Json::parse(text, watch);
  } catch (const typename Json::parse_error& error) {
    throw InputError(path + ": not valid JSON at byte " + std::to_string(error.byte) +
                     ", expected " + kind);
  } catch (const typename Json::exception&) {
    throw InputError(path + ": holds a number that is too large, after the key " +
                     quote_value(last_key) + ", expected " + kind);
  }
}

}  // namespace zygoma
