// Fields: reads the fields of a JSON object of a card and collects what is wrong with them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "weir/join.hpp"

namespace weir::card {

using Json = nlohmann::json;

struct Fault {
  std::string place, value, needed;
};
using Faults = std::vector<Fault>;

constexpr char kPlainText[] = "a text of at most 4096 bytes, without control characters";
// Returns whether a card may have this text: it reaches properties, terminals and lines to paste.
bool is_plain_text(std::string_view text) noexcept;
// Returns whether the text names a file in the folder of the card: no folders, neither . nor ..
bool is_name_of_a_file(std::string_view text) noexcept;

// Reads the fields of one object. Keeps the first fault of each field; faulty fields get defaults.
class Fields {
 public:
  Fields(const Json& object, std::string where, Faults* faults);

  // Makes each field that is not among `known` a fault.
  void only(std::initializer_list<const char*> known);
  // Reads a plain text, which is not empty if it is needed.
  std::string text(const char* key, bool needed);
  // Reads a list of finite numbers.
  std::vector<double> numbers(const char* key);
  // Returns null for a field that is absent or null.
  const Json* find(const char* key, bool needed);

  template <class T>
  T one_of(const char* key, std::initializer_list<std::pair<const char*, T>> choices, T otherwise,
           bool needed) {
    const std::string given = text(key, needed);
    if (given.empty()) return otherwise;
    for (const auto& [name, value] : choices)
      if (given == name) return value;
    fail(key, "one of " + join(choices, ", ", [](const auto& choice) { return choice.first; }));
    return otherwise;
  }

  // Adds a fault of a field; an empty key names the object itself.
  void fail(const std::string& key, const std::string& needed);
  // Adds a fault of a part of a field: `place` is below the object.
  void fail_at(const std::string& place, const Json& value, const std::string& needed);
  bool has_fault(const std::string& key) const;
  std::string where(const std::string& key) const { return where_ + "/" + key; }

 private:
  void add(std::string place, std::string shown, const std::string& needed);
  bool is_faulty(const std::string& place) const;

  const Json& object_;
  std::string where_;
  Faults& faults_;
};

}  // namespace weir::card
