// Writes tensors of zeros after their headers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/results/empty_frame.hpp"

#include <algorithm>
#include <optional>

#include "core/tensor/tensor_header.hpp"
#include "weir/results.h"

namespace weir::results {
namespace {

std::optional<TensorSpec> make_spec(const ResultRole& role) {
  weir_result_columns columns;
  if (!weir_results_parse(role.columns.c_str(), 0, &columns)) return std::nullopt;
  switch (columns.kind) {
    case WEIR_RESULT_ROWS:
      return TensorSpec{ElementType::Float32, Shape{columns.length, 1}, {}};
    case WEIR_RESULT_MASKS:
      return TensorSpec{ElementType::UInt8, Shape{1, 1, 1}, {}};
    case WEIR_RESULT_SCORES:
    case WEIR_RESULT_DEPTH:
      return TensorSpec{ElementType::Float32, Shape{1, 1}, {}};
    case WEIR_RESULT_CLASS_MAP:
      return TensorSpec{ElementType::UInt16, Shape{1, 1}, {}};
    case WEIR_RESULT_TEXT:
      return TensorSpec{ElementType::UInt8, Shape{1, 1}, {}};
    default:
      return TensorSpec{ElementType::UInt8, Shape{1}, {}};
  }
}

}  // namespace

bool write_empty(const ResultRoles& roles, const Reserve& reserve) {
  std::vector<TensorHeader> headers;
  for (const ResultRole& role : roles) {
    const auto spec = make_spec(role);
    if (!spec) return false;
    TensorHeader header;
    header.format = Format::Flexible;
    header.spec = *spec;
    headers.push_back(header);
  }
  for (const TensorHeader& header : headers) {
    const auto bytes =
        reserve(kTensorHeaderBytes + static_cast<size_t>(header.spec.bytes().value_or(0)));
    std::fill(bytes.begin(), bytes.end(), std::byte{});
    write_tensor_header(header, bytes.first<kTensorHeaderBytes>());
  }
  return true;
}

}  // namespace weir::results
