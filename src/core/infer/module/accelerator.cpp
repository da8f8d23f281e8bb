// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/accelerator.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "core/text/text.hpp"
#include "weir/join.hpp"

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
  return join(kNames, ", ", [](const auto& entry) { return entry.first; });
}

Error unreadable(std::string_view text, std::string_view part) {
  std::vector<std::string> words{"true", "false"};
  for (const auto& [name, number] : kNames) words.emplace_back(name);
  const std::string close = nearest(lower(std::string(part)), words);
  return Error{.code = Code::OPTION_VALUE,
               .what = "accelerator cannot be read: no accelerator is used",
               .offered = "accelerator=" + std::string(text),
               .needed = "true or false, then names: " + known_names(),
               .difference = "at \"" + std::string(part) + "\"" +
                             (close.empty() ? "" : ", did you mean " + close + "?"),
               .fix = "accelerator=true:npu,gpu"};
}

bool same(std::string_view a, std::string_view b) {
  const auto x = accelerator_number(a), y = accelerator_number(b);
  return x && y ? *x == *y : a == b;
}

bool lists(const std::vector<std::string>& names, std::string_view name) {
  return std::any_of(names.begin(), names.end(), [&](const auto& n) { return same(n, name); });
}

// Returns the first invalid part, or nullopt.
std::optional<std::string_view> read_list(std::string_view list, AcceleratorRequest* out) {
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

// The first requested accelerator that is supported, in the words of choose_accelerator(); nullopt
// if that leaves the choice to the engine. `skipped` gets the names that are not supported.
std::optional<std::string> first_named(const AcceleratorRequest& request,
                                       const std::vector<std::string>& supported,
                                       std::vector<std::string>* skipped) {
  for (const auto& name : request.names) {
    if (lists(request.excluded, name)) continue;
    if (name == "none") return name;
    if (name == "default") return "";
    if (name == "auto") break;
    if (lists(supported, name)) return name;
    skipped->push_back(name);
  }
  return std::nullopt;
}

}  // namespace

std::optional<unsigned> accelerator_number(std::string_view name) noexcept {
  for (const auto& [known, number] : kNames)
    if (known == name) return number;
  return std::nullopt;
}

AcceleratorRequest parse_accelerator(std::string_view given, std::optional<Error>* warning) {
  const std::string_view text = strip(given);
  if (text.empty()) return {};
  const size_t colon = text.find(':');
  const auto head = strip(text.substr(0, colon));
  const bool wanted = equal_ignoring_case(head, "true");
  AcceleratorRequest request;
  std::optional<std::string_view> fault;
  if (!wanted && !equal_ignoring_case(head, "false")) fault = head;
  if (!fault && colon != std::string_view::npos)
    fault = read_list(strip(text.substr(colon + 1)), &request);
  if (fault && warning) *warning = unreadable(text, *fault);
  if (fault || !wanted) request = {};
  request.kind =
      fault || !wanted ? AcceleratorRequest::Kind::None : AcceleratorRequest::Kind::Hardware;
  return request;
}

std::string choose_accelerator(const AcceleratorRequest& request,
                               const std::vector<std::string>& supported) {
  if (request.kind == AcceleratorRequest::Kind::EngineDefault) return "";
  if (request.kind == AcceleratorRequest::Kind::None) return "none";
  std::vector<std::string> skipped;
  if (const auto named = first_named(request, supported, &skipped)) return *named;
  if (supported.empty()) return skipped.empty() ? "auto" : join(skipped, ",");
  for (const auto& name : supported)
    if (!lists(request.excluded, name)) return name;
  return "none";
}

std::optional<Error> unavailable_hardware(const AcceleratorRequest& request,
                                          const std::vector<std::string>& supported,
                                          std::string_view engine, std::string_view text) {
  if (request.kind != AcceleratorRequest::Kind::Hardware || supported.empty()) return std::nullopt;
  std::vector<std::string> skipped;
  const bool takes_any =
      std::find(request.names.begin(), request.names.end(), "auto") != request.names.end();
  if (takes_any || first_named(request, supported, &skipped) || skipped.empty())
    return std::nullopt;
  const std::string used = choose_accelerator(request, supported);
  return Error{.code = Code::OPTION_VALUE,
               .what = "the engine " + std::string(engine) + " has no accelerator " +
                       join(skipped, ", ") + ": " + used + " is used",
               .offered = "accelerator=" + std::string(text),
               .needed = "one of: " + join(supported, ", "),
               .fix = "accelerator=true:" + used};
}

}  // namespace weir::infer
