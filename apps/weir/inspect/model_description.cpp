// Formats a model's metadata, which may have any keys and values of any length.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "inspect/model_description.hpp"

namespace weir::app {
namespace {

constexpr size_t kMax = 120;  // characters of a value; --json prints all

bool is_empty(const Json& value) {
  return value.empty() || value == "";  // empty(): null, {}, []
}

std::string shortened(const Json& value) {
  std::string out = value.is_string() ? value.get<std::string>() : value.dump();
  if (out.size() <= kMax) return out;
  size_t end = kMax;
  while (end > 0 && (out[end] & 0xC0) == 0x80) --end;  // do not split a character
  return out.substr(0, end) + " ...";
}

}  // namespace

Json model_description(const infer::Model& model) {
  const char* text = model.info().metadata_json;
  Json metadata = Json::parse(text ? text : "null", nullptr, false);
  if (!metadata.is_object()) metadata = nullptr;
  return {{"metadata", std::move(metadata)}};
}

std::string description_text(const Json& description) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& [key, value] : description["metadata"].items())
    if (!is_empty(value)) rows.push_back({key, shortened(value)});
  if (rows.empty()) return "";
  rows.insert(rows.begin(), {"key", "value"});
  return "\nThe file says\n" + table(rows, "  ");
}

}  // namespace weir::app
