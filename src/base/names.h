// Things with names: which of them is meant, and what to say when none is.
//
// A list is any container that can be indexed, of texts or of structs with a `name`.
#pragma once

#include <concepts>
#include <string>
#include <string_view>

#include "src/base/check.h"

namespace zygoma {

template <class Named>
constexpr std::string_view name_of(const Named& one) {
  if constexpr (std::convertible_to<const Named&, std::string_view>) {
    return one;
  } else {
    return one.name;
  }
}

// The place of that name in the list, or -1.
template <class List>
constexpr int find_name(const List& list, std::string_view name) {
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (name_of(list[i]) == name) return static_cast<int>(i);
  }
  return -1;
}

// "front, profile, turntable"
template <class List>
std::string joined_names(const List& list, std::string_view between = ", ") {
  std::string text;
  for (const auto& one : list) text.append(text.empty() ? "" : between).append(name_of(one));
  return text;
}

// The same, but throws InputError("WHAT 'NAME' is unknown, expected one of FRONT, PROFILE").
template <class List>
int require_name(const std::string& what, const List& list, std::string_view name) {
  const int place = find_name(list, name);
  require(place >= 0,
          what + " " + quote_value(name) + " is unknown, expected " +
              (list.empty() ? "none" : "one of " + joined_names(list)));
  return place;
}

}  // namespace zygoma
