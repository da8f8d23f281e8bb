// Assignment: pairs rows with columns of a matrix so that the sum of the values is as large as
// possible (the Hungarian method).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace weir::track {

class Matrix {
 public:
  Matrix(size_t rows, size_t columns) : rows_(rows), columns_(columns), values_(rows * columns) {}
  size_t rows() const noexcept { return rows_; }
  size_t columns() const noexcept { return columns_; }
  double& at(size_t row, size_t column) noexcept { return values_[row * columns_ + column]; }
  double at(size_t row, size_t column) const noexcept { return values_[row * columns_ + column]; }

 private:
  size_t rows_, columns_;
  std::vector<double> values_;
};

// The column of each row; as many rows have one as there are columns, if there are fewer columns.
// Values may be 0: callers leave such pairs out. Takes time in proportion to the square of the
// smaller side and to the larger one.
std::vector<std::optional<size_t>> best_assignment(const Matrix& values);

}  // namespace weir::track
