// Result<T>: a value, or an Error that describes what went wrong and how to fix it. Member names
// follow std::expected.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "weir/codes.h"
#include "weir/printable_text.hpp"

namespace weir {

enum class Code : int {
#define WEIR_CODE_ENUM(name, number, title) name = number,
  WEIR_ERROR_CODES(WEIR_CODE_ENUM)
#undef WEIR_CODE_ENUM
};

// The parts of an error message. Only `what` is always set.
struct Error {
  Code code = Code::INTERNAL;
  std::string what{};        // what failed, one sentence without a full stop
  std::string offered{};     // what was received
  std::string needed{};      // what is required
  std::string difference{};  // the first difference between the two, or the place of a typo
  std::string fix{};         // a line to paste or a command to run

  // Returns "WEIR-2001: what\n  offered: ...\n  needed: ...\n  first difference: ...\n  fix: ...",
  // with control characters and bytes that are not UTF-8 escaped: parts may be text of a peer or a
  // file.
  std::string message() const {
    std::string text = "WEIR-" + std::to_string(static_cast<int>(code)) + ": " + what;
    const auto add = [&text](const char* name, const std::string& part) {
      if (!part.empty()) text += std::string("\n  ") + name + ": " + part;
    };
    add("offered", offered);
    add("needed", needed);
    add("first difference", difference);
    add("fix", fix);
    return printable_text(text);
  }
};

template <class T = std::monostate>
class [[nodiscard]] Result {
 public:
  Result(T value) : v_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : v_(std::in_place_index<1>, std::move(error)) {}

  bool has_value() const noexcept { return v_.index() == 0; }
  explicit operator bool() const noexcept { return has_value(); }
  // Precondition: has_value().
  T& operator*() & noexcept { return *std::get_if<0>(&v_); }
  const T& operator*() const& noexcept { return *std::get_if<0>(&v_); }
  T&& operator*() && noexcept { return std::move(*std::get_if<0>(&v_)); }
  T* operator->() noexcept { return std::get_if<0>(&v_); }
  const T* operator->() const noexcept { return std::get_if<0>(&v_); }
  // Precondition: !has_value().
  const Error& error() const& noexcept { return *std::get_if<1>(&v_); }
  Error&& error() && noexcept { return std::move(*std::get_if<1>(&v_)); }

 private:
  std::variant<T, Error> v_;
};

using Status = Result<>;
inline Status ok() {
  return std::monostate{};
}

}  // namespace weir
