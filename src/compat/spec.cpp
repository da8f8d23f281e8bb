// SPDX-License-Identifier: LGPL-2.1-or-later
#include "compat/spec.hpp"

#include <algorithm>

#include "compat/guard.hpp"
#include "core/text/text.hpp"
#include "nnstreamer_plugin_api_util.h"

namespace weir::compat {

Shape parse_shape(std::string_view text) {
  std::string numbers;
  for (const auto part : split(text, ":", NNS_TENSOR_RANK_LIMIT)) {
    const auto word = strip(part);
    const auto digits = word.substr(0, word.find_first_not_of("0123456789"));
    numbers += (numbers.empty() ? "" : ":") + std::string(digits.empty() ? word : digits);
    if (word.empty()) break;
  }
  return Shape::parse(numbers);
}

std::string rank_text(const Shape& shape, unsigned rank, bool padding) {
  if (rank == 0 || rank > NNS_TENSOR_RANK_LIMIT) return shape.to_string();
  const size_t known = shape.rank();
  return shape.with_rank(known > rank ? rank : known).to_string(padding ? rank : 0);
}

TensorSpec to_spec(const GstTensorInfo& info) {
  return {element_type(info.type), to_shape(info.dimension), info.name ? info.name : ""};
}

void write(const TensorSpec& spec, GstTensorInfo* info) {
  info->name = spec.name.empty() ? nullptr : text(spec.name);
  info->type = static_cast<tensor_type>(spec.type);
  std::copy(spec.shape.dims().begin(), spec.shape.dims().end(), info->dimension);
}

const GstTensorInfo* tensor_at(const GstTensorsInfo& info, size_t index) noexcept {
  if (index < NNS_TENSOR_MEMORY_MAX) return &info.info[index];
  return info.extra && index < NNS_TENSOR_SIZE_LIMIT ? &info.extra[index - NNS_TENSOR_MEMORY_MAX]
                                                     : nullptr;
}
GstTensorInfo* tensor_at(GstTensorsInfo& info, size_t index) noexcept {
  return const_cast<GstTensorInfo*>(tensor_at(std::as_const(info), index));
}

GstTensorInfo* room_at(GstTensorsInfo& info, size_t index) noexcept {
  if (index >= NNS_TENSOR_MEMORY_MAX && index < NNS_TENSOR_SIZE_LIMIT && !info.extra) {
    info.extra = g_new(GstTensorInfo, NNS_TENSOR_SIZE_EXTRA_LIMIT);
    for (size_t i = 0; i < NNS_TENSOR_SIZE_EXTRA_LIMIT; ++i) gst_tensor_info_init(&info.extra[i]);
  }
  return tensor_at(info, index);
}

bool can_be(const char* function, const GstTensorsInfo& info) noexcept {
  if (info.num_tensors <= NNS_TENSOR_SIZE_LIMIT) return true;
  return or_else(function, false, [&] {
    warn(function, Error{.code = Code::LIMIT_EXCEEDED,
                         .what = "a description has too many tensors",
                         .offered = "num_tensors " + std::to_string(info.num_tensors),
                         .needed = "at most " + std::to_string(NNS_TENSOR_SIZE_LIMIT)});
    return false;
  });
}

FrameSpec to_spec(const GstTensorsInfo& info) {
  FrameSpec spec;
  spec.format =
      info.format <= _NNS_TENSOR_FORMAT_END ? static_cast<Format>(info.format) : Format::End;
  const size_t count = std::min<size_t>(info.num_tensors, NNS_TENSOR_SIZE_LIMIT);
  for (size_t i = 0; i < count; ++i) {
    const auto* tensor = tensor_at(info, i);
    spec.tensors.push_back(tensor ? to_spec(*tensor) : TensorSpec{});
  }
  return spec;
}

FrameSpec to_spec(const GstTensorsConfig& config) {
  FrameSpec spec = to_spec(config.info);
  spec.rate = {config.rate_n, config.rate_d};
  return spec;
}

void write(const FrameSpec& spec, GstTensorsInfo* info) {
  gst_tensors_info_init(info);
  info->format = static_cast<tensor_format>(spec.format);
  info->num_tensors =
      static_cast<unsigned>(std::min<size_t>(spec.tensors.size(), NNS_TENSOR_SIZE_LIMIT));
  for (size_t i = 0; i < info->num_tensors; ++i) write(spec.tensors[i], room_at(*info, i));
}

void write(const FrameSpec& spec, GstTensorsConfig* config) {
  write(spec, &config->info);
  config->rate_n = spec.rate.numerator;
  config->rate_d = spec.rate.denominator;
}

}  // namespace weir::compat
