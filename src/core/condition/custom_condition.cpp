// The register of conditions, and calling one.
#include "core/condition/custom_condition.hpp"

#include "core/infer/called.hpp"
#include "core/infer/host.hpp"
#include "core/process/process_object.hpp"

namespace weir::condition {
namespace {

using Functions = infer::NamedFunctions<weir_condition_function>;
Functions& functions() {
  static auto& all = process::object<Functions>("condition-functions");
  return all;
}

}  // namespace

Error unknown_condition(const std::string& name) {
  return Error{Code::CALLBACK_UNKNOWN,
               "no condition is registered under this name",
               "compared-value-option=" + name,
               functions().one_of(),
               "",
               "weir_condition_register(\"" + name + "\", function, data) before the first frame"};
}

bool is_custom_condition(std::string_view name) {
  return functions().find(name).has_value();
}

Result<std::optional<bool>> CustomCondition::decide(const weir_frame& frame) {
  if (!entry_) entry_ = functions().find(name_);
  if (!entry_) return unknown_condition(name_);
  weir_error error;
  int answer = 0;
  const auto result = infer::called("the condition " + name_, "return host->fail(...)", [&] {
    return entry_->function(&infer::host(), &frame, &answer, entry_->data, &error);
  });
  if (!result) return result.error();
  if (*result == 0) return std::optional<bool>(answer != 0);
  if (*result > 0) return std::optional<bool>();
  const Error said = infer::take_error(&error, *result, "it gave no reason");
  return Error{Code::CALLBACK_FAILED, "the condition " + name_ + " failed: " + said.what,
               said.offered,          said.needed,
               said.difference,       said.fix};
}

}  // namespace weir::condition

extern "C" int weir_condition_register(const char* name, weir_condition_function condition,
                                       void* data) {
  return weir::condition::functions().add(name, condition, data);
}

extern "C" int weir_condition_unregister(const char* name) {
  return weir::condition::functions().remove(name, WEIR_CALLBACK_UNKNOWN);
}
