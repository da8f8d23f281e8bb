// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/subplugin/table.hpp"

#include <algorithm>

#include "core/process/process_object.hpp"
#include "core/text/text.hpp"
#include "weir/join.hpp"

namespace weir::subplugin {

const char* to_string(Kind kind) noexcept {
  constexpr const char* kNames[] = {"filter", "decoder", "converter", "trainer"};
  return kNames[static_cast<size_t>(kind)];
}

Status check_name(std::string_view name) {
  if (name.empty())
    return Error{.code = Code::OPTION_VALUE,
                 .what = "a sub-plugin has no name",
                 .offered = "\"\"",
                 .needed = "a name"};
  if (equal_ignoring_case(name, "any") || equal_ignoring_case(name, "auto"))
    return Error{.code = Code::OPTION_VALUE,
                 .what = "this name is reserved",
                 .offered = std::string(name),
                 .needed = "a name other than any and auto"};
  return ok();
}

Status Table::add(Kind kind, std::string_view name, const void* descriptor) {
  Status status = check_name(name);
  if (status && !of(kind).add(std::string(name), descriptor))
    status = Error{.code = Code::OPTION_VALUE,
                   .what = std::string("another ") + to_string(kind) + " already has this name",
                   .offered = std::string(name),
                   .needed = "an unused name"};
  if (status)
    note("it registered the " + std::string(to_string(kind)) + " " + std::string(name));
  else
    refuse(kind, status.error());
  return status;
}

void Table::refuse(Kind kind, const Error& reason) {
  note("a " + std::string(to_string(kind)) + " was rejected: " + reason.what +
       (reason.offered.empty() ? "" : " (" + reason.offered + ")"));
}

bool Table::remove(Kind kind, std::string_view name) {
  if (!of(kind).remove(name)) return false;
  std::lock_guard lock(mutex_);
  descriptions_.erase({kind, std::string(name)});
  return true;
}

const void* Table::find(Kind kind, std::string_view name) const {
  return of(kind).find(name).value_or(nullptr);
}

std::vector<std::string> Table::names(Kind kind) const {
  return of(kind).names();
}

void Table::describe(Kind kind, const std::string& name, const std::string& key,
                     const std::string& text) {
  std::lock_guard lock(mutex_);
  auto& all = descriptions_[{kind, name}];
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const auto& each) { return each.first == key; });
  if (found == all.end())
    all.emplace_back(key, text);
  else
    found->second = text;
}

Table::Descriptions Table::descriptions(Kind kind, const std::string& name) const {
  std::lock_guard lock(mutex_);
  const auto found = descriptions_.find({kind, name});
  return found == descriptions_.end() ? Descriptions{} : found->second;
}

void Table::note(const std::string& event) {
  std::lock_guard lock(mutex_);
  const auto recording = recordings_.find(std::this_thread::get_id());
  if (recording != recordings_.end()) recording->second->events_.push_back(event);
}

Table::Recording::Recording(Table& table) : table_(table), outer_(nullptr) {
  std::lock_guard lock(table_.mutex_);
  outer_ = std::exchange(table_.recordings_[std::this_thread::get_id()], this);
}

Table::Recording::~Recording() {
  std::lock_guard lock(table_.mutex_);
  if (outer_)
    table_.recordings_[std::this_thread::get_id()] = outer_;
  else
    table_.recordings_.erase(std::this_thread::get_id());
}

std::string Table::Recording::to_string() const {
  std::lock_guard lock(table_.mutex_);
  const std::string out = join(events_, "; ");
  return out.empty() ? "it registered nothing" : out;
}

Table& table() {
  static auto& all = process::object<Table>("nnstreamer-sub-plugins");
  return all;
}

Functions& custom_decoders() {
  static auto& all = process::object<Functions>("nnstreamer-custom-decoders");
  return all;
}

Functions& custom_converters() {
  static auto& all = process::object<Functions>("nnstreamer-custom-converters");
  return all;
}

}  // namespace weir::subplugin
