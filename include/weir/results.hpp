// Weir Results (results.h) in C++: columns of a stream's caps, and rows by column.
//
//   const auto columns = weir::result_columns(text, 0);
//   if (columns && columns->kind == WEIR_RESULT_ROWS)
//     for (size_t i = 0; i < n; ++i) use(weir::ResultRow(*columns, numbers + i * columns->length));
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cmath>
#include <optional>
#include <string>

#include "weir/detection.hpp"
#include "weir/results.h"

namespace weir {

// Returns the entry of tensor `index` of a weir-columns text; nullopt if it is not valid.
inline std::optional<weir_result_columns> result_columns(const std::string& text, uint32_t index) {
  weir_result_columns columns;
  if (!weir_results_parse(text.c_str(), index, &columns)) return std::nullopt;
  return columns;
}

// A row for reading; borrows both. Columns that the row does not have read as their neutral value.
class ResultRow {
 public:
  ResultRow(const weir_result_columns& columns, const float* row) noexcept
      : columns_(columns), row_(row) {}

  bool has_box() const noexcept { return columns_.box >= 0; }
  Box box() const noexcept {
    const float* at = has_box() ? row_ + columns_.box : nullptr;
    return at ? Box{at[0], at[1], at[2], at[3]} : Box{};
  }
  // Returns the score; 0 or less, or NaN: background, to be skipped.
  float score() const noexcept { return number(columns_.score, 1); }
  bool is_background() const noexcept { return !(score() > 0); }
  int32_t class_index() const noexcept { return integer(columns_.class_index, 0); }
  uint32_t track() const noexcept {
    const int32_t track = integer(columns_.track, 0);
    return track > 0 ? static_cast<uint32_t>(track) : 0;
  }
  int32_t parent() const noexcept { return integer(columns_.parent, -1); }
  float rotation() const noexcept { return number(columns_.rotation, 0); }
  uint32_t n_points() const noexcept { return columns_.n_points; }
  float x(uint32_t point) const noexcept { return at_point(point)[0]; }
  float y(uint32_t point) const noexcept { return at_point(point)[1]; }
  float point_score(uint32_t point) const noexcept {
    return columns_.point_length == 3 ? at_point(point)[2] : 1;
  }

 private:
  float number(int32_t index, float absent) const noexcept {
    return index >= 0 ? row_[index] : absent;
  }
  // Returns the number of a column. Numbers that no int32_t holds read as if the column were
  // absent.
  int32_t integer(int32_t index, int32_t absent) const noexcept {
    const float value = number(index, static_cast<float>(absent));
    return std::abs(value) < 2147483648.0f ? static_cast<int32_t>(value) : absent;
  }
  const float* at_point(uint32_t point) const noexcept {
    return row_ + columns_.points + size_t{point} * columns_.point_length;
  }

  const weir_result_columns& columns_;
  const float* row_;
};

}  // namespace weir
