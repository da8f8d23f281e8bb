// Converts accelerators between names and numbers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <array>
#include <string>

#include "compat/guard.hpp"
#include "core/infer/module/accelerator.hpp"
#include "core/text/text.hpp"
#include "nnstreamer_plugin_api_filter.h"

using namespace weir::compat;

namespace {

// The first name of a number is used for output.
constexpr std::array<const char*, 13> kNames{
    "none",         "auto",        "default",     "cpu",      "cpu.simd", "gpu",   "npu",
    "npu.movidius", "npu.edgetpu", "npu.vivante", "npu.srcn", "npu.slsi", "npu.sr"};

accl_hw parse_hardware(std::string_view name, accl_hw otherwise) {
  const auto number = weir::infer::accelerator_number(weir::lower(weir::strip(name)));
  return number ? static_cast<accl_hw>(*number) : otherwise;
}

accl_hw chosen(const weir::infer::AcceleratorRequest& request, const char** supported,
               const char* automatic, const char* standard) {
  std::vector<std::string> list;
  if (automatic && *automatic) list.push_back(weir::lower(automatic));
  for (; supported && *supported; ++supported) list.push_back(weir::lower(*supported));
  const auto word = weir::infer::choose_accelerator(request, list);
  if (word.empty()) return standard ? parse_hardware(standard, ACCL_DEFAULT) : ACCL_DEFAULT;
  return parse_hardware(weir::split(word, ",")[0], ACCL_NONE);
}

}  // namespace

accl_hw parse_accl_hw_fill(parse_accl_args args) {
  return or_else(__func__, ACCL_NONE, [&] {
    std::optional<weir::Error> warning;
    const auto request = weir::infer::parse_accelerator(args.in_accl ? args.in_accl : "", &warning);
    if (warning) warn("parse_accl_hw", *warning);
    return chosen(request, args.sup_accl, args.auto_accl, args.def_accl);
  });
}

// The parentheses avoid the header's macro of the same name.
accl_hw(parse_accl_hw)(const char* accelerators, const char** supported_accelerators,
                       const char* auto_accelerator, const char* default_accelerator) {
  return parse_accl_hw_fill(
      {accelerators, supported_accelerators, auto_accelerator, default_accelerator});
}

accl_hw get_accl_hw_type(const char* name) {
  if (!given(__func__, {name})) return ACCL_NONE;
  return or_else(__func__, ACCL_NONE, [&] { return parse_hardware(name, ACCL_NONE); });
}

const char* get_accl_hw_str(accl_hw hw) {
  for (const char* name : kNames)
    if (weir::infer::accelerator_number(name) == static_cast<unsigned>(hw)) return name;
  return kNames[0];
}
