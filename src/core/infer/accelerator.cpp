// Reading and choosing accelerators.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/accelerator.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "core/text/text.hpp"

namespace weir::infer {
namespace {

constexpr std::array<std::pair<std::string_view, unsigned>, 14> kNames{{
    {"none", 0},
    {"auto", 1},
    {"default", 2},
    {"cpu", 0x1000},
    {"cpu.simd", 0x1100},
    {"cpu.neon", 0x1100},
    {"gpu", 0x2000},
    {"npu", 0x4000},
    {"npu.movidius", 0x4001},
    {"npu.edgetpu", 0x4002},
    {"npu.vivante", 0x4003},
    {"npu.srcn", 0x4004},
    {"npu.slsi", 0x4005},
    {"npu.sr", 0x4100},
}};

std::string known_names() {
  std::string out;
  for (const auto& [name, number] : kNames) out += (out.empty() ? "" : ", ") + std::string(name);
  return out;
}

Error unreadable(std::string_view text, std::string_view part) {
  std::vector<std::string> words{"true", "false"};
  for (const auto& [name, number] : kNames) words.emplace_back(name);
  const std::string close = nearest(lower(std::string(part)), words);
  return Error{
      Code::OPTION_VALUE,
      "accelerator cannot be read: no accelerator is used",
      "accelerator=" + std::string(text),
      "true or false, then names: " + known_names(),
      "at \"" + std::string(part) + "\"" + (close.empty() ? "" : ", did you mean " + close + "?"),
      "accelerator=true:npu,gpu"};
}

bool same(std::string_view a, std::string_view b) {
  const auto x = accelerator_number(a), y = accelerator_number(b);
  return x && y ? *x == *y : a == b;
}

bool lists(const std::vector<std::string>& names, std::string_view name) {
  return std::any_of(names.begin(), names.end(), [&](const auto& n) { return same(n, name); });
}

// The place of the first fault, or nothing.
std::optional<std::string_view> read_list(std::string_view list, AcceleratorWish* out) {
  if (list.starts_with('(') != list.ends_with(')')) return list;
  if (list.starts_with('(')) list = list.substr(1, list.size() - 2);
  for (const auto part : split(list, ",")) {
    const auto word = strip(part);
    const bool excluded = word.starts_with('!');
    const std::string name = lower(std::string(excluded ? word.substr(1) : word));
    if (!accelerator_number(name)) return word;
    (excluded ? out->excluded : out->names).push_back(name);
  }
  return std::nullopt;
}

}  // namespace

std::optional<unsigned> accelerator_number(std::string_view name) noexcept {
  for (const auto& [known, number] : kNames)
    if (known == name) return number;
  return std::nullopt;
}

AcceleratorWish parse_accelerator(std::string_view given, std::optional<Error>* warning) {
  const std::string_view text = strip(given);
  if (text.empty()) return {};
  const size_t colon = text.find(':');
  const auto head = strip(text.substr(0, colon));
  const bool wanted = equal_ignoring_case(head, "true");
  AcceleratorWish wish;
  std::optional<std::string_view> fault;
  if (!wanted && !equal_ignoring_case(head, "false")) fault = head;
  if (!fault && colon != std::string_view::npos)
    fault = read_list(strip(text.substr(colon + 1)), &wish);
  if (fault && warning) *warning = unreadable(text, *fault);
  if (fault || !wanted) wish = {};
  wish.kind = fault || !wanted ? AcceleratorWish::Kind::None : AcceleratorWish::Kind::Hardware;
  return wish;
}

std::string choose_accelerator(const AcceleratorWish& wish,
                               const std::vector<std::string>& supported) {
  if (wish.kind == AcceleratorWish::Kind::EngineDefault) return "";
  if (wish.kind == AcceleratorWish::Kind::None) return "none";
  std::string all;
  for (const auto& name : wish.names) {
    if (lists(wish.excluded, name)) continue;
    if (name == "none") return name;
    if (name == "default") return "";
    if (name == "auto") break;
    if (lists(supported, name)) return name;
    all += (all.empty() ? "" : ",") + name;
  }
  if (supported.empty()) return all.empty() ? "auto" : all;
  for (const auto& name : supported)
    if (!lists(wish.excluded, name)) return name;
  return "none";
}

}  // namespace weir::infer
