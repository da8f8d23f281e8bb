// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/condition/custom_condition.hpp"

#include <span>

#include "core/infer/module/guarded_call.hpp"
#include "core/infer/module/host.hpp"
#include "core/process/process_object.hpp"
#include "core/text/text.hpp"
#include "weir/join.hpp"
#include "weir/module.hpp"

namespace weir::condition {
namespace {

using Functions = infer::NamedFunctions<weir_condition_function>;
Functions& functions() {
  static auto& all = process::object<Functions>("condition-functions");
  return all;
}

// Describes the frame: "a frame of uint8 2:1, int16 3 at 0:00:00.100000000".
std::string to_string(const weir_frame& frame) {
  const std::string out =
      "a frame of " + join(std::span(frame.tensors, frame.n_tensors), ", ",
                           [](const weir_tensor& tensor) { return describe(tensor.info); });
  return frame.pts < 0 ? out : out + " at " + time_text(static_cast<uint64_t>(frame.pts));
}

Error failed(const std::string& who, int result, weir_error* error, const weir_frame& frame) {
  if (!error->set)
    return Error{
        .code = Code::CALLBACK_FAILED,
        .what = who + " failed without an error message",
        .offered = "it returned " + std::to_string(result) + " for " + to_string(frame),
        .needed =
            "0 for success, above 0 to drop the frame, or below 0 after host->fail with a message"};
  Error failure = infer::take_error(error, result, "");
  failure.what = who + " failed: " + failure.what;
  failure.code = Code::CALLBACK_FAILED;
  if (failure.offered.empty()) failure.offered = to_string(frame);
  return failure;
}

}  // namespace

Error unknown_condition(const std::string& name) {
  const std::string close = nearest(name, functions().names());
  const std::string option = "compared-value-option=";
  return Error{.code = Code::CALLBACK_UNKNOWN,
               .what = "no condition is registered under this name",
               .offered = option + name,
               .needed = functions().one_of(),
               .difference = close.empty() ? "" : "did you mean " + close + "?",
               .fix = close.empty() ? "weir_condition_register(\"" + name +
                                          "\", function, data) before the first frame"
                                    : option + close};
}

bool is_custom_condition(std::string_view name) {
  return functions().find(name).has_value();
}

Result<std::optional<bool>> CustomCondition::decide(const weir_frame& frame) {
  if (!entry_ || entry_->gate->is_closed()) entry_ = functions().find(name_);
  if (!entry_) return unknown_condition(name_);
  weir_error error;
  int decision = 0;
  const auto result = infer::call_guarded(*entry_->gate, who_, "return host->fail(...)", [&] {
    return entry_->function(&infer::host(), &frame, &decision, entry_->data, &error);
  });
  if (!result) return result.error();
  if (*result == 0) return std::optional<bool>(decision != 0);
  if (*result > 0) return std::optional<bool>();
  return failed(who_, *result, &error, frame);
}

}  // namespace weir::condition

extern "C" int weir_condition_register(const char* name, weir_condition_function condition,
                                       void* data) {
  return weir::condition::functions().add(name, condition, data);
}

extern "C" int weir_condition_unregister(const char* name) {
  return weir::condition::functions().remove(name, WEIR_CALLBACK_UNKNOWN);
}
