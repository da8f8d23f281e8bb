// OptionReader: a cursor over an option text that creates errors with the cursor's position.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "core/tensor/element_type.hpp"
#include "weir/result.hpp"

namespace weir::transform {

class OptionReader {
 public:
  // `mode` names the mode in messages. Both texts are borrowed.
  OptionReader(std::string_view mode, std::string_view text) noexcept : mode_(mode), text_(text) {}

  size_t position() const noexcept { return position_; }
  void go_to(size_t position) noexcept { position_ = position; }
  bool at_end() const noexcept { return position_ == text_.size(); }
  std::string_view text() const noexcept { return text_; }

  // Each reads the named token and advances, or leaves the cursor unchanged.
  bool take(std::string_view word) noexcept;  // ignores case
  ElementType take_type() noexcept;           // End: no type name here
  std::string_view take_digits() noexcept;    // [0-9]*
  std::string_view take_number() noexcept;    // [-+]?[0-9]*\.?[0-9]+([eE][-+]?[0-9]+)?, or ""

  // Both report the cursor's position.
  Error syntax_error(std::string needed, std::string fix) const;
  Error value_error(std::string what, std::string needed, std::string fix) const;

 private:
  Error error(Code code, std::string what, std::string needed, std::string fix) const;

  std::string_view mode_, text_;
  size_t position_ = 0;
};

}  // namespace weir::transform
