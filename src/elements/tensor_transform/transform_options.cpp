// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_transform/transform_options.hpp"

#include <cstring>

#include "core/text/text.hpp"

namespace weir {
namespace {

Error missing_option() {
  return Error{
      .code = Code::OPTION_SYNTAX,
      .what = "mode and option are not set",
      .needed = "a mode and an option that fits it",
      .fix = "tensor_transform mode=arithmetic option=typecast:float32,add:-127.5,div:127.5"};
}

Result<TensorChoice> parse_choice(const std::string& apply) {
  TensorChoice choice;
  for (const auto part : split(apply, ",")) {
    const auto text = strip(part);
    if (text.empty()) continue;
    const auto index = parse_unsigned(text);
    if (!index || *index >= kTensorLimit)
      return Error{.code = Code::OPTION_SYNTAX,
                   .what = "apply cannot be read",
                   .offered = apply,
                   .needed = "a comma list of tensor indices",
                   .difference = std::string(text),
                   .fix = "apply=0,2"};
    choice.push_back(static_cast<size_t>(*index));
  }
  return choice;
}

}  // namespace

Result<TransformOptions> parse_options(const TransformSettings& s) {
  if (!is_set(s)) return missing_option();
  auto operation = transform::parse(s.mode, *s.option);
  if (!operation) return operation.error();
  auto choice = parse_choice(s.apply);
  if (!choice) return choice.error();
  return TransformOptions{s, *std::move(operation), *std::move(choice)};
}

Status refuse_unfit_option(TransformSettings* settings) {
  settings->refused.reset();
  if (is_set(*settings))
    if (const auto operation = transform::parse(settings->mode, *settings->option); !operation) {
      settings->refused = operation.error();
      settings->option = settings->option_taken;
      return operation.error();
    }
  settings->option_taken = settings->option;
  return ok();
}

Status check_option_change(const char* name, const TransformSettings& wanted) {
  const auto options = parse_options(wanted);
  if (options || !is_set(wanted) || std::strcmp(name, "mode") == 0) return ok();
  if (std::strcmp(name, "option") == 0)
    for (int mode = 0; mode <= static_cast<int>(transform::Mode::Padding); ++mode)
      if (transform::parse(static_cast<transform::Mode>(mode), *wanted.option)) return ok();
  return options.error();
}

}  // namespace weir
