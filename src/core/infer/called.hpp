// Calling a function of a user's: nothing that it throws goes further.
#pragma once
#include <exception>
#include <string>
#include <type_traits>
#include <utility>

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

}  // namespace weir::infer
