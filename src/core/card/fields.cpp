// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/card/fields.hpp"

#include <algorithm>
#include <cmath>

#include "core/text/text.hpp"

namespace weir::card {
namespace {

constexpr size_t kMaxTextBytes = 4096;
constexpr size_t kMaxShownBytes = 80;

// Cuts the text without leaving half a character at its end.
std::string shortened(std::string text) {
  if (text.size() <= kMaxShownBytes) return text;
  size_t end = kMaxShownBytes;
  while (end > 0 && (text[end] & 0xC0) == 0x80) --end;
  return text.substr(0, end);
}

// Shows a value on one line and without control characters: JSON escapes them, except DEL.
std::string shown(const Json& value) {
  std::string out = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::replace(out.begin(), out.end(), '\x7f', ' ');
  return out;
}

// Shows a key as a part of the place that an error names.
std::string shown_key(const std::string& key) {
  const std::string text = shown(Json(key));
  return shortened(text.substr(1, text.size() - 2));
}

}  // namespace

bool is_plain_text(std::string_view text) noexcept {
  return text.size() <= kMaxTextBytes && std::none_of(text.begin(), text.end(), [](char c) {
           return static_cast<unsigned char>(c) < ' ' || c == '\x7f';
         });
}

bool is_name_of_a_file(std::string_view text) noexcept {
  return !text.empty() && text != "." && text != ".." && text.find('/') == std::string_view::npos &&
         is_plain_text(text);
}

Fields::Fields(const Json& object, std::string where, Faults* faults)
    : object_(object), where_(std::move(where)), faults_(*faults) {
  if (!object_.is_object()) fail("", "an object {...}");
}

void Fields::only(std::initializer_list<const char*> known) {
  if (!object_.is_object()) return;
  const std::vector<std::string> names(known.begin(), known.end());
  for (const auto& [key, value] : object_.items()) {
    if (std::find(names.begin(), names.end(), key) != names.end()) continue;
    const std::string close = nearest(key, names);
    fail(key, close.empty() ? "a known field of a card" : "did you mean " + close + "?");
  }
}

std::string Fields::text(const char* key, bool needed) {
  const Json* value = find(key, needed);
  if (!value) return "";
  if (!value->is_string() || (needed && value->get_ref<const std::string&>().empty())) {
    fail(key, "a string");
    return "";
  }
  auto out = value->get<std::string>();
  if (is_plain_text(out)) return out;
  fail(key, kPlainText);
  return "";
}

std::vector<double> Fields::numbers(const char* key) {
  std::vector<double> out;
  const Json* value = find(key, false);
  if (!value) return out;
  const bool good = value->is_array() && std::all_of(value->begin(), value->end(), [](auto& n) {
                      return n.is_number() && std::isfinite(n.template get<double>());
                    });
  if (!good) fail(key, "a list of numbers");
  if (good) out = value->get<std::vector<double>>();
  return out;
}

const Json* Fields::find(const char* key, bool needed) {
  if (!object_.is_object()) return nullptr;
  const auto at = object_.find(key);
  if (at != object_.end() && !at->is_null()) return &*at;
  if (needed) fail(key, "it is required");
  return nullptr;
}

void Fields::fail(const std::string& key, const std::string& needed) {
  if (!object_.is_object() && !key.empty()) return;  // the object itself is the fault
  const Json* value = object_.is_object() && object_.contains(key) ? &object_[key] : nullptr;
  add(key.empty() ? where_ : where(shown_key(key)),
      value         ? shown(*value)
      : key.empty() ? object_.type_name()
                    : "nothing",
      needed);
}

void Fields::fail_at(const std::string& place, const Json& value, const std::string& needed) {
  add(where(place), shown(value), needed);
}

bool Fields::has_fault(const std::string& key) const {
  return is_faulty(where(key));
}

void Fields::add(std::string place, std::string shown, const std::string& needed) {
  if (!is_faulty(place)) faults_.push_back({std::move(place), shortened(std::move(shown)), needed});
}

bool Fields::is_faulty(const std::string& place) const {
  return std::any_of(faults_.begin(), faults_.end(),
                     [&place](const Fault& fault) { return fault.place == place; });
}

}  // namespace weir::card
