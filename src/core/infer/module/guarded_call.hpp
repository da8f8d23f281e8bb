// Calls functions of the application and converts exceptions to errors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <exception>
#include <string>
#include <type_traits>
#include <utility>

#include "core/infer/queue/call_gate.hpp"
#include "weir/result.hpp"

namespace weir::infer {

// Returns the result of `body`, or CALLBACK_FAILED for an exception. `who` ("the function mine") is
// the subject of the message; `instead` describes how it should fail without throwing.
template <class Body>
Result<std::invoke_result_t<Body>> call_guarded(const std::string& who, const char* instead,
                                                Body&& body) {
  const auto threw = [&](const char* what) {
    return Error{.code = Code::CALLBACK_FAILED,
                 .what = who + " threw an exception",
                 .offered = what,
                 .needed = "no exception across C functions",
                 .fix = std::string("catch it there and ") + instead};
  };
  try {
    return std::forward<Body>(body)();
  } catch (const std::exception& e) {
    return threw(e.what());
  } catch (...) {
    return threw("not a std::exception");
  }
}

// The same for a function that the program may unregister: CALLBACK_UNKNOWN after that.
template <class Body>
Result<std::invoke_result_t<Body>> call_guarded(CallGate& gate, const std::string& who,
                                                const char* instead, Body&& body) {
  const CallGate::Visit visit(gate);
  if (!visit)
    return Error{.code = Code::CALLBACK_UNKNOWN,
                 .what = who + " is no longer registered",
                 .offered = "a frame after it was unregistered",
                 .needed = "a function that stays registered while a pipeline uses it",
                 .fix = "stop the pipeline before you unregister the function"};
  return call_guarded(who, instead, std::forward<Body>(body));
}

}  // namespace weir::infer
