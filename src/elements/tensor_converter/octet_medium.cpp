// Converts bytes to tensors (docs/compatibility/converter.md 2.3).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/octet_medium.hpp"

namespace weir {

namespace {

// The bytes of a frame, if those of `frames` of them can be counted.
Result<uint64_t> bytes_of(const FrameSpec& spec, uint32_t frames) {
  const auto bytes = spec.bytes();
  uint64_t gathered = 0;
  if (bytes && !__builtin_mul_overflow(*bytes, frames, &gathered) && gathered <= INT64_MAX)
    return *bytes;
  return Error{
      .code = Code::LIMIT_EXCEEDED, .what = "the tensors are too big", .offered = spec.to_string()};
}

}  // namespace

Result<StreamPlan> OctetMedium::configure(const GstCaps* caps, const Preferences& preferences) {
  plan_ = {};
  plan_.spec.rate = rate_of(caps);
  plan_.spec.tensors = preferences.tensors.empty() ? preferences.peer : preferences.tensors;
  const size_t count = plan_.spec.tensors.size();
  if (count == 0 && !preferences.peer_is_flexible)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "the tensors in the byte stream are unknown",
                 .needed = "input-dim and input-type",
                 .fix = "tensor_converter input-dim=3:224:224:1 input-type=uint8"};
  if (count != 1 || preferences.peer_is_flexible) {
    const char* what = count > 1    ? "several tensors"
                       : count == 0 ? "buffers of any size"
                                    : "bytes for flexible tensors";
    if (auto status = one_frame_each(preferences, what); !status) return status.error();
  }
  plan_.spec.format = count == 0 ? Format::Flexible : Format::Static;
  if (count == 0) return plan_;
  const auto bytes = bytes_of(plan_.spec, preferences.frames_per_tensor);
  if (!bytes) return bytes.error();
  plan_.frame_bytes = *bytes;
  plan_.frames_out = preferences.frames_per_tensor;
  return plan_;
}

Status OctetMedium::accepts(const GstBuffer* buffer) const {
  if (plan_.spec.format != Format::Static) return ok();
  return whole_frames(buffer, plan_,
                      "set blocksize=" + std::to_string(plan_.frame_bytes) + " on the source");
}

Result<MediumFrames> OctetMedium::frames(gst::Ref<GstBuffer> buffer, Ledger*) {
  const size_t size = gst_buffer_get_size(buffer.get());
  if (auto status = accepts(buffer.get()); !status) return status.error();
  if (plan_.spec.format == Format::Static) return MediumFrames{std::move(buffer), {}, {}};
  if (size > UINT32_MAX)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "a buffer is too big for a dimension",
                 .offered = std::to_string(size),
                 .needed = "at most " + std::to_string(UINT32_MAX) + " bytes",
                 .fix = "set blocksize on the source"};
  return MediumFrames{
      std::move(buffer), {{ElementType::UInt8, Shape{static_cast<uint32_t>(size)}, ""}}, {}};
}

}  // namespace weir
