// A condition of tensor_if in C++: any callable, registered for the lifetime of an object.
//
//   const weir::RegisteredCondition bright("bright", [](const weir_frame& frame) {
//     return *static_cast<const uint8_t*>(frame.tensors[0].data) > 127;
//   });
//   ... tensor_if compared-value=CUSTOM compared-value-option=bright ...
//
// The callable runs on streaming threads, concurrently when several elements name it. An exception
// becomes an error on the bus and ends the stream. custom_condition.h describes the tensors. The
// object must outlive the pipelines that name it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <exception>
#include <functional>
#include <new>
#include <string>

#include "weir/custom_condition.h"
#include "weir/module.hpp"

namespace weir {

class RegisteredCondition {
 public:
  using Function = std::function<bool(const weir_frame&)>;

  // Throws Failure when the name is empty or taken or `function` is empty. A program that does not
  // link with libweir passes the two functions that it found with dlsym.
  RegisteredCondition(std::string name, Function function,
                      decltype(&weir_condition_register) add = weir_condition_register,
                      decltype(&weir_condition_unregister) remove = weir_condition_unregister)
      : name_(std::move(name)), function_(std::move(function)), remove_(remove) {
    const int result = function_ ? add(name_.c_str(), call, &function_) : -WEIR_OPTION_VALUE;
    if (result < 0)
      throw Failure({static_cast<Code>(-result), "a condition cannot be registered",
                     "\"" + name_ + "\"", "an unused name, and a function", "", ""});
  }
  RegisteredCondition(const RegisteredCondition&) = delete;
  RegisteredCondition& operator=(const RegisteredCondition&) = delete;
  ~RegisteredCondition() { remove_(name_.c_str()); }

 private:
  static int call(const weir_host* host, const weir_frame* in, int* result, void* data,
                  weir_error* error) {
    const auto failed = [&](int code, const char* what) {
      return host->fail(error, code, what, nullptr, nullptr, nullptr, nullptr);
    };
    try {
      *result = (*static_cast<const Function*>(data))(*in) ? 1 : 0;
      return WEIR_OK;
    } catch (const Failure& failure) {
      return fail(*host, error, failure.error());
    } catch (const std::bad_alloc&) {
      return failed(WEIR_OUT_OF_MEMORY, "memory ran out in a condition");
    } catch (const std::exception& e) {
      return failed(WEIR_CALLBACK_FAILED, e.what());
    } catch (...) {
      return failed(WEIR_CALLBACK_FAILED, "an unknown exception in a condition");
    }
  }

  std::string name_;
  Function function_;
  decltype(&weir_condition_unregister) remove_;
};

}  // namespace weir
