// CustomCondition: calls conditions that the program registered through weir/custom_condition.h.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "core/infer/module/named_functions.hpp"
#include "weir/custom_condition.h"
#include "weir/result.hpp"

namespace weir::condition {

// Looks up the name on the first frame, and again after the function was unregistered. Use from one
// thread at a time.
class CustomCondition {
 public:
  explicit CustomCondition(std::string name)
      : name_(std::move(name)), who_("the condition " + name_) {}
  // nullopt: drop the frame. CALLBACK_UNKNOWN with the registered names, CALLBACK_FAILED with the
  // function's message.
  Result<std::optional<bool>> decide(const weir_frame& frame);

 private:
  std::string name_, who_;
  std::optional<infer::NamedFunctions<weir_condition_function>::Entry> entry_;
};

Error unknown_condition(const std::string& name);
bool is_custom_condition(std::string_view name);

}  // namespace weir::condition
