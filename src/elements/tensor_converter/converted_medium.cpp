// Buffers to frames of the ABI and back.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/converted_medium.hpp"

#include <algorithm>

#include "gstcpp/frame_errors.hpp"
#include "gstcpp/module_values.hpp"

namespace weir {
namespace {

GstClockTime gst_time(int64_t time) {
  return time < 0 ? GST_CLOCK_TIME_NONE : static_cast<GstClockTime>(time);
}

}  // namespace

Result<StreamPlan> ConvertedMedium::configure(const GstCaps* caps, const Wishes& wishes) {
  const gst::UniqueText text{gst_caps_to_string(caps)};
  auto tensors = converter_->configure(text.get());
  if (!tensors) return tensors.error();
  frames_per_tensor_ = wishes.frames_per_tensor;
  if (auto status = gather(frames_per_tensor_, &*tensors); !status) return status.error();
  StreamPlan plan;
  plan.spec.format = Format::Static;
  plan.spec.rate = rate_of(caps);
  plan.frames_out = frames_per_tensor_;
  user_ = wishes.tensors;
  plan_before_the_first(wishes, &plan);
  if (!plan.first_frame_decides) return plan;
  plan.spec.tensors = *std::move(tensors);
  if (plan.spec.tensors.empty()) plan.spec.tensors = {{ElementType::UInt8, Shape{1, 1, 1, 1}, ""}};
  return plan;
}

Result<MediumFrames> ConvertedMedium::frames(gst::Ref<GstBuffer> buffer, Ledger* ledger) {
  std::vector<gst::MappedMemory> maps;
  std::vector<weir_tensor> inputs;
  for (guint i = 0; i < gst_buffer_n_memory(buffer.get()); ++i) {
    maps.emplace_back(gst_buffer_peek_memory(buffer.get(), i), GST_MAP_READ);
    if (!maps.back()) return gst::memory_not_mapped();
    inputs.push_back(gst::byte_tensor(maps.back()));
  }
  weir_frame in{};
  in.struct_size = sizeof in;
  in.n_tensors = static_cast<uint32_t>(inputs.size());
  in.tensors = inputs.data();
  in.pts = gst::abi_time(GST_BUFFER_PTS(buffer.get()));
  in.duration = gst::abi_time(GST_BUFFER_DURATION(buffer.get()));
  in.deadline = -1;
  if (GST_BUFFER_IS_DISCONT(buffer.get())) in.flags |= WEIR_FRAME_DISCONT;
  auto frame = converter_->convert(in);
  if (!frame) return frame.error();
  MediumFrames out;
  if (frame->tensors.empty()) return out;
  out.buffer = gst::Ref<GstBuffer>::adopt(gst_buffer_new());
  gst_buffer_copy_into(out.buffer.get(), buffer.get(), GST_BUFFER_COPY_METADATA, 0,
                       static_cast<gsize>(-1));
  GST_BUFFER_PTS(out.buffer.get()) = gst_time(frame->pts);
  GST_BUFFER_DURATION(out.buffer.get()) = gst_time(frame->duration);
  out.rate = frame->rate;
  for (auto& tensor : frame->tensors) {
    out.tensors.push_back(tensor.spec());
    auto memory = gst::memory_of(tensor, ledger);
    if (!memory) return memory.error();
    gst_buffer_append_memory(out.buffer.get(), memory->release());
  }
  if (auto status = gather(frames_per_tensor_, &out.tensors); !status) return status.error();
  if (auto status = agree(out.tensors, user_); !status) return status.error();
  return out;
}

}  // namespace weir
