// FilePattern: the names of numbered files, such as img_%02d.png.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "weir/result.hpp"

namespace weir::dataset {

// A pattern of printf with exactly one conversion of an integer: %d, %i or %u, with or without a
// width and zeros in front of the number. "%%" is a percent sign. The text never reaches printf.
class FilePattern {
 public:
  // OPTION_SYNTAX, with the place, for any other pattern.
  static Result<FilePattern> parse(std::string_view text);
  std::string name(uint64_t index) const;

 private:
  std::string before_, after_;
  size_t width_ = 0;
  char fill_ = ' ';
};

}  // namespace weir::dataset
