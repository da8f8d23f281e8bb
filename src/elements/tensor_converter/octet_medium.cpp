// Bytes as tensors (specification 2, "octet").
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/octet_medium.hpp"

namespace weir {

Result<StreamPlan> OctetMedium::configure(const GstCaps* caps, const Wishes& wishes) {
  plan_ = {};
  plan_.spec.rate = rate_of(caps);
  plan_.spec.tensors = wishes.tensors.empty() ? wishes.peer : wishes.tensors;
  const size_t count = plan_.spec.tensors.size();
  if (count == 0 && !wishes.peer_is_flexible)
    return Error{Code::OPTION_VALUE,
                 "the tensors in the byte stream are not known",
                 "",
                 "input-dim and input-type",
                 "",
                 "tensor_converter input-dim=3:224:224:1 input-type=uint8"};
  if (count != 1 || wishes.peer_is_flexible) {
    const char* what = count > 1    ? "several tensors"
                       : count == 0 ? "buffers of any size"
                                    : "bytes for flexible tensors";
    if (auto status = one_frame_each(wishes, what); !status) return status.error();
  }
  plan_.spec.format = count == 0 ? Format::Flexible : Format::Static;
  if (count == 0) return plan_;
  const auto bytes = plan_.spec.bytes();
  uint64_t gathered = 0;
  if (!bytes || __builtin_mul_overflow(*bytes, wishes.frames_per_tensor, &gathered) ||
      gathered > INT64_MAX)
    return Error{
        Code::LIMIT_EXCEEDED, "the tensors are too big", plan_.spec.to_string(), "", "", ""};
  plan_.frame_bytes = *bytes;
  plan_.frames_out = wishes.frames_per_tensor;
  return plan_;
}

Result<MediumFrames> OctetMedium::frames(gst::Ref<GstBuffer> buffer, Ledger*) {
  const size_t size = gst_buffer_get_size(buffer.get());
  if (plan_.spec.format == Format::Static) {
    const std::string fix = "set blocksize=" + std::to_string(plan_.frame_bytes) + " on the source";
    if (auto status = whole_frames(buffer.get(), plan_, fix); !status) return status.error();
    return MediumFrames{std::move(buffer), {}, {}};
  }
  if (size > UINT32_MAX)
    return Error{Code::LIMIT_EXCEEDED,
                 "a buffer is too big for a dimension",
                 std::to_string(size),
                 "at most " + std::to_string(UINT32_MAX) + " bytes",
                 "",
                 "set blocksize on the source"};
  return MediumFrames{
      std::move(buffer), {{ElementType::UInt8, Shape{static_cast<uint32_t>(size)}, ""}}, {}};
}

}  // namespace weir
