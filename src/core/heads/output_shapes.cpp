// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/output_shapes.hpp"
#include "core/tensor/geometry.hpp"

#include <algorithm>
#include <utility>

#include "core/text/text.hpp"

namespace weir::heads {

size_t element_count(const OutputSignature& output) noexcept {
  return static_cast<size_t>(output.shape.count().value_or(0));
}

size_t matrix_rows(const OutputSignature& output, size_t columns) noexcept {
  const Shape& shape = output.shape;
  const size_t count = element_count(output);
  if (columns == 0 || count == 0) return 0;
  if (columns == 1 && shape[0] == count) return count;
  const size_t rows = count / columns;
  return shape[0] == columns && shape[1] == rows ? rows : 0;
}

bool has_name_with(const OutputSignature& output, std::string_view part) {
  return lower(output.name).find(lower(part)) != std::string::npos;
}

bool any_name_has(const ModelSignature& model, std::string_view part) {
  return std::any_of(model.outputs.begin(), model.outputs.end(),
                     [&](const OutputSignature& output) { return has_name_with(output, part); });
}

bool looks_like_picture(const ModelSignature& model) noexcept {
  constexpr uint32_t kColours = 3;
  if (model.outputs.size() != 1 || model.labels > 0 || model.input.width == 0) return false;
  const Shape& shape = model.outputs[0].shape;
  const bool is_packed = shape[0] == kColours;
  if (shape.min_rank() != 3 || (!is_packed && shape[2] != kColours)) return false;
  const uint32_t width = shape[is_packed ? 1 : 0], height = shape[is_packed ? 2 : 1];
  return width % model.input.width == 0 &&
         uint64_t{width} * model.input.height == uint64_t{height} * model.input.width;
}

Error picture_instead_of_results(const ModelSignature& model, std::string fix) {
  return {.code = Code::SPEC_MISMATCH,
          .what = "no head: the output looks like a picture",
          .offered = model.describe_outputs() + ", three numbers for each pixel of the input",
          .needed = "results; or the name of the head, if they are scores of three classes",
          .fix = std::move(fix)};
}

void need_input_size(Size input) {
  if (input.width > 0 && input.height > 0) return;
  throw Failure({.code = Code::SPEC_MISMATCH,
                 .what = "the size of the model's input is not known",
                 .offered = "a stream without source map, a model without fixed input",
                 .needed = "width and height in pixels",
                 .fix = "tensor_decoder custom=input:640:480"});
}

float to_probability(float value) noexcept {
  return value > 0 ? std::min(value, 1.0f) : 0;
}

}  // namespace weir::heads
