// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/converted_medium.hpp"

#include <algorithm>

#include "core/tensor/packed_tensors.hpp"
#include "core/tensor/tensor_header.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/memory_part.hpp"
#include "gstcpp/buffer/module_values.hpp"

namespace weir {
namespace {

GstClockTime gst_time(int64_t time) {
  return time < 0 ? GST_CLOCK_TIME_NONE : static_cast<GstClockTime>(time);
}

// The memory of `tensor`, without its first `skipped` bytes: a part of the buffer that `maps` holds
// if the converter shared it.
Result<gst::Ref<GstMemory>> make_memory(infer::ConvertedTensor& tensor, size_t skipped,
                                        GstBuffer* buffer,
                                        const std::vector<gst::MappedMemory>& maps,
                                        Ledger* ledger) {
  const weir_tensor& made = tensor.memory();
  const auto* data = static_cast<const std::byte*>(made.data);
  const bool shared = !made.release && (made.flags & WEIR_TENSOR_ALIASES_INPUT) != 0;
  for (size_t i = 0; shared && i < maps.size(); ++i) {
    const auto all = maps[i].bytes();
    // Compared as numbers: the pointers may belong to different objects.
    const auto offset = reinterpret_cast<uintptr_t>(data) - reinterpret_cast<uintptr_t>(all.data());
    if (offset > all.size() || made.bytes > all.size() - offset) continue;
    uint64_t copied = 0;
    auto part = gst::make_part(gst_buffer_peek_memory(buffer, static_cast<guint>(i)),
                               offset + skipped, made.bytes - skipped, &copied);
    if (copied > 0) ledger->copied(copied);
    return part;
  }
  const size_t bytes = made.bytes;
  auto whole = gst::make_memory(tensor, ledger);
  if (!whole || skipped == 0) return whole;
  uint64_t copied = 0;
  return gst::make_part(whole->get(), skipped, bytes - skipped, &copied);
}

Error flexible_tensors_are_not_gathered(uint32_t frames_per_tensor) {
  return {.code = Code::OPTION_VALUE,
          .what = "frames with flexible tensors cannot be combined into one output",
          .offered = "frames-per-tensor=" + std::to_string(frames_per_tensor),
          .needed = "frames-per-tensor=1",
          .fix = "tensor_converter frames-per-tensor=1"};
}

weir_frame make_frame(GstBuffer* buffer, std::vector<weir_tensor>* tensors) {
  weir_frame out{};
  out.struct_size = sizeof out;
  out.n_tensors = static_cast<uint32_t>(tensors->size());
  out.tensors = tensors->data();
  out.pts = gst::abi_time(GST_BUFFER_PTS(buffer));
  out.duration = gst::abi_time(GST_BUFFER_DURATION(buffer));
  out.deadline = -1;
  if (GST_BUFFER_IS_DISCONT(buffer)) out.flags |= WEIR_FRAME_DISCONT;
  return out;
}

}  // namespace

Result<StreamPlan> ConvertedMedium::configure(const GstCaps* caps, const Preferences& preferences) {
  const gst::UniqueText text{gst_caps_to_string(caps)};
  auto tensors = converter_->configure(text.get());
  if (!tensors) return tensors.error();
  frames_per_tensor_ = preferences.frames_per_tensor;
  if (auto status = gather(frames_per_tensor_, &*tensors); !status) return status.error();
  StreamPlan plan;
  plan.spec.format = Format::Static;
  plan.spec.rate = get_rate(caps);
  plan.frames_out = frames_per_tensor_;
  plan.frames_have_rates = true;
  user_ = preferences.tensors;
  plan_before_the_first(preferences, &plan);
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
  auto frame = converter_->convert(make_frame(buffer.get(), &inputs));
  if (!frame) return frame.error();
  MediumFrames out;
  if (frame->tensors.empty()) return out;
  out.buffer = gst::Ref<GstBuffer>::adopt(gst_buffer_new());
  gst_buffer_copy_into(out.buffer.get(), buffer.get(), GST_BUFFER_COPY_METADATA, 0,
                       static_cast<gsize>(-1));
  GST_BUFFER_PTS(out.buffer.get()) = gst_time(frame->pts);
  GST_BUFFER_DURATION(out.buffer.get()) = gst_time(frame->duration);
  const bool is_empty =
      std::any_of(frame->tensors.begin(), frame->tensors.end(),
                  [](const auto& tensor) { return tensor.spec().shape.is_empty(); });
  if (is_empty && !frame->is_flexible)
    return MediumFrames{.buffer = {}, .gap = gst::gap_like(out.buffer.get())};
  out.rate = frame->rate;
  out.is_flexible = frame->is_flexible;
  // More tensors than memories are packed by the element, which writes the headers itself.
  out.has_headers = frame->is_flexible && frame->tensors.size() <= kMemoryLimit;
  if (out.is_flexible && frames_per_tensor_ > 1)
    return flexible_tensors_are_not_gathered(frames_per_tensor_);
  const size_t skipped = out.is_flexible && !out.has_headers ? kTensorHeaderBytes : 0;
  for (auto& tensor : frame->tensors) {
    out.tensors.push_back(tensor.spec());
    auto memory = make_memory(tensor, skipped, buffer.get(), maps, ledger);
    if (!memory) return memory.error();
    gst_buffer_append_memory(out.buffer.get(), memory->release());
  }
  if (auto status = gather(frames_per_tensor_, &out.tensors); !status) return status.error();
  if (auto status = agree(out.tensors, user_); !status) return status.error();
  return out;
}

}  // namespace weir
