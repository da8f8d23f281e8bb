// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/result_roles.hpp"

#include <algorithm>

#include "core/text/text.hpp"
#include "weir/join.hpp"

namespace weir {
namespace {

constexpr size_t kMaxTextBytes = 65536, kMaxRoles = 256;

// `set` gets the index and the text of each entry.
template <class Set>
void each_entry(std::string_view text, Set&& set) {
  if (text.empty() || text.size() > kMaxTextBytes) return;
  size_t index = 0;
  for (const auto entry : split(text, ";")) {
    if (index == kMaxRoles) return;
    set(index++, std::string(entry));
  }
}

void drop_empty(ResultRoles* roles) {
  const auto named = [](const ResultRole& role) { return !role.columns.empty(); };
  if (std::none_of(roles->begin(), roles->end(), named)) roles->clear();
}

}  // namespace

ResultRoles parse_roles(std::string_view columns, std::string_view sources) {
  ResultRoles out;
  each_entry(columns, [&](size_t, std::string text) { out.push_back({std::move(text), {}}); });
  each_entry(sources, [&](size_t i, std::string text) {
    if (i < out.size()) out[i].source = std::move(text);
  });
  drop_empty(&out);
  return out;
}

std::string columns_text(const ResultRoles& roles) {
  return join(roles, ";", [](const ResultRole& role) { return role.columns; });
}
std::string sources_text(const ResultRoles& roles) {
  return join(roles, ";", [](const ResultRole& role) { return role.source; });
}

void append_roles(const ResultRoles& more, size_t tensors, size_t before, ResultRoles* roles) {
  if (more.empty() && roles->empty()) return;
  roles->resize(before);
  for (size_t i = 0; i < tensors; ++i) roles->push_back(i < more.size() ? more[i] : ResultRole{});
}

ResultRoles pick_roles(const ResultRoles& roles, std::span<const size_t> tensors) {
  ResultRoles out;
  if (roles.empty()) return out;
  for (const size_t index : tensors)
    out.push_back(index < roles.size() ? roles[index] : ResultRole{});
  drop_empty(&out);
  return out;
}

}  // namespace weir
