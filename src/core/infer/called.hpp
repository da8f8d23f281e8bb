// Calling a function of a user's: nothing that it throws goes further.
#pragma once
#include <exception>
#include <string>
#include <type_traits>
#include <utility>

#include "core/infer/call_gate.hpp"
#include "weir/result.hpp"

namespace weir::infer {

// What `body` returns. What it threw becomes CALLBACK_FAILED; `who` ("the function mine") is its
// subject, `instead` says how it fails without throwing.
template <class Body>
Result<std::invoke_result_t<Body>> called(const std::string& who, const char* instead,
                                          Body&& body) {
  const auto threw = [&](const char* what) {
    return Error{Code::CALLBACK_FAILED,
                 who + " threw an exception",
                 what,
                 "nothing thrown across C",
                 "",
                 std::string("catch it there and ") + instead};
  };
  try {
    return std::forward<Body>(body)();
  } catch (const std::exception& e) {
    return threw(e.what());
  } catch (...) {
    return threw("what is no std::exception");
  }
}

// The same for a function that the program may unregister: CALLBACK_UNKNOWN once it has.
template <class Body>
Result<std::invoke_result_t<Body>> called(CallGate& gate, const std::string& who,
                                          const char* instead, Body&& body) {
  const CallGate::Visit visit(gate);
  if (!visit)
    return Error{Code::CALLBACK_UNKNOWN,
                 who + " is no longer registered",
                 "a frame after it was unregistered",
                 "a function that stays registered while a pipeline uses it",
                 "",
                 "stop the pipeline before you unregister the function"};
  return called(who, instead, std::forward<Body>(body));
}

}  // namespace weir::infer
