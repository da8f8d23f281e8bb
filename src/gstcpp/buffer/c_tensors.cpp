// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/c_tensors.hpp"

#include <glib.h>

#include <algorithm>
#include <cstring>

namespace weir::gst {
namespace {

constexpr size_t kOwn = NNS_TENSOR_MEMORY_MAX;

Error nonsense(const std::string& who, const std::string& what, const std::string& needed) {
  return {.code = Code::CALLBACK_FAILED,
          .what = who + " returned invalid tensors",
          .offered = what,
          .needed = needed,
          .fix = "correct " + who};
}

// Reads the number of an enumeration: a callee may have written a value that it does not define.
template <class Enumeration>
int number(const Enumeration& from) noexcept {
  int out;
  static_assert(sizeof out == sizeof from);
  std::memcpy(&out, &from, sizeof out);
  return out;
}

// The C struct ends its dimensions at the first 0.
Result<TensorSpec> to_spec(const GstTensorInfo& info, const std::string& who, size_t index) {
  const std::string place = "tensor " + std::to_string(index) + ": ";
  const int type = number(info.type);
  if (type < 0 || type >= _NNS_END)
    return nonsense(who, place + "type " + std::to_string(type), "a type from 0 to 10");
  TensorSpec spec{static_cast<ElementType>(type), Shape(std::span<const uint32_t>(info.dimension)),
                  info.name ? info.name : ""};
  if (!spec.valid() || !spec.bytes())
    return nonsense(who, place + "dimensions " + spec.shape.to_string(),
                    "dimensions of 1 or more, within the limits");
  return spec;
}

}  // namespace

CTensors::CTensors(const FrameSpec& spec) {
  for (auto& info : config_.info.info) info.type = _NNS_END;
  const size_t count = std::min<size_t>(spec.tensors.size(), NNS_TENSOR_SIZE_LIMIT);
  config_.info.num_tensors = static_cast<unsigned>(count);
  config_.info.format = static_cast<tensor_format>(spec.format);
  config_.rate_n = spec.rate.numerator;
  config_.rate_d = spec.rate.denominator;
  if (count > kOwn) {
    config_.info.extra = g_new0(GstTensorInfo, NNS_TENSOR_SIZE_EXTRA_LIMIT);
    for (size_t i = 0; i < NNS_TENSOR_SIZE_EXTRA_LIMIT; ++i) config_.info.extra[i].type = _NNS_END;
  }
  for (size_t i = 0; i < count; ++i) {
    const auto& from = spec.tensors[i];
    GstTensorInfo& to = i < kOwn ? config_.info.info[i] : config_.info.extra[i - kOwn];
    to.name = from.name.empty() ? nullptr : g_strdup(from.name.c_str());
    to.type = static_cast<tensor_type>(from.type);
    std::copy(from.shape.dims().begin(), from.shape.dims().end(), to.dimension);
  }
}

CTensors::~CTensors() {
  for (auto& info : config_.info.info) g_free(info.name);
  if (config_.info.extra)
    for (size_t i = 0; i < NNS_TENSOR_SIZE_EXTRA_LIMIT; ++i) g_free(config_.info.extra[i].name);
  g_free(config_.info.extra);
}

Result<FrameSpec> CTensors::spec(const std::string& who) const {
  FrameSpec out;
  const int format = number(config_.info.format);
  if (format != _NNS_TENSOR_FORMAT_STATIC && format != _NNS_TENSOR_FORMAT_FLEXIBLE)
    return nonsense(who, "format " + std::to_string(format), "static (0) or flexible (1)");
  out.format = static_cast<Format>(format);
  out.rate = {config_.rate_n, config_.rate_d};
  if (out.format == Format::Flexible) return out;  // each frame carries its own tensors
  const unsigned count = config_.info.num_tensors;
  if (count == 0 || count > NNS_TENSOR_SIZE_LIMIT)
    return nonsense(who, std::to_string(count) + " tensors", "1 to 256");
  if (count > kOwn && !config_.info.extra)
    return nonsense(who, std::to_string(count) + " tensors, `extra` is NULL",
                    "`extra` with room for 240");
  for (size_t i = 0; i < count; ++i) {
    auto spec = to_spec(i < kOwn ? config_.info.info[i] : config_.info.extra[i - kOwn], who, i);
    if (!spec) return spec.error();
    out.tensors.push_back(*std::move(spec));
  }
  return out;
}

std::vector<GstTensorMemory> c_memories(const FrameLayout& reader) {
  std::vector<GstTensorMemory> out;
  for (const auto& view : reader.tensors())
    out.push_back(
        {view.payload.data() - view.header_bytes, view.payload.size() + view.header_bytes});
  return out;
}

}  // namespace weir::gst
