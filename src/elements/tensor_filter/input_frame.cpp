// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/input_frame.hpp"

#include <algorithm>
#include <cstring>

#include "elements/tensor_filter/input_fix.hpp"
#include "gstcpp/buffer/module_values.hpp"

namespace weir {
namespace {

// A buffer with its own mappings, kept for an engine.
struct HeldBuffer {
  gst::Ref<GstBuffer> buffer;
  std::vector<gst::MappedMemory> maps;  // unmapped before the buffer is released

  bool has(const weir_tensor& tensor) const {
    const auto* begin = static_cast<const std::byte*>(tensor.data);
    return std::any_of(maps.begin(), maps.end(), [&](const auto& map) {
      const auto bytes = map.bytes();
      return begin >= bytes.data() && begin + tensor.bytes <= bytes.data() + bytes.size();
    });
  }
};

}  // namespace

InputFrame::InputFrame(const OpenModel* model, SharedFilterPlan plan, size_t session,
                       Ledger* ledger)
    : model_(model), plan_(std::move(plan)), session_(session), ledger_(ledger) {
  describe();
}

void InputFrame::describe() {
  tensors_ = frame_tensors(plan_->model_inputs);
  frame_ = {};
  frame_.struct_size = sizeof frame_;
  frame_.n_tensors = static_cast<uint32_t>(tensors_.size());
  frame_.tensors = tensors_.data();
}

Status InputFrame::read(GstBuffer* buffer, const infer::ModelLease::Frame* use,
                        GstClockTime deadline) {
  buffer_ = buffer;
  if (auto status = reader_.read(buffer, plan_->input); !status) return status.error();
  ledger_->copied(reader_.bytes_copied());
  if (plan_->input.format != Format::Static)
    if (auto status = follow_headers(use); !status) return status;
  // A replaced model may need another alignment.
  const auto* info = use ? &use->model().info() : nullptr;
  const size_t alignment = info ? info->alignment : plan_->alignment;
  const size_t padding = info ? info->input_padding : plan_->padding;
  if (auto status = place(std::max(alignment, plan_->fallback_alignment),
                          std::max(padding, plan_->fallback_padding));
      !status)
    return status;
  frame_.pts = gst::abi_time(GST_BUFFER_PTS(buffer));
  frame_.duration = gst::abi_time(GST_BUFFER_DURATION(buffer));
  frame_.deadline = gst::abi_time(deadline);
  maps_.fill(buffer, plan_->input_choice, &frame_);
  return ok();
}

// In flexible streams the headers of each frame give its shapes.
Status InputFrame::follow_headers(const infer::ModelLease::Frame* use) {
  std::vector<TensorSpec> specs;
  for (const auto& view : views()) specs.push_back(view.spec);
  auto chosen = choose_tensors(specs, plan_->input_choice, "input-combination");
  if (!chosen) return chosen.error();
  auto shapes = fit(plan_->declared_inputs, *chosen);
  if (!shapes) return with_input_fix(shapes.error(), *model_, specs, plan_->medium);
  if (!use) return ok();  // the shape of the model is fixed, and the frame matches it
  const bool same = std::equal(
      shapes->begin(), shapes->end(), plan_->model_inputs.begin(), plan_->model_inputs.end(),
      [](const auto& a, const auto& b) { return a.type == b.type && a.shape == b.shape; });
  if (same && resolved_on_ == use->sessions_number()) return ok();
  auto plan = model_->plan_for_shapes(*plan_, *use, session_, *std::move(shapes));
  if (!plan) return plan.error();
  plan_ = std::make_shared<const FilterPlan>(*std::move(plan));
  describe();
  resolved_on_ = use->sessions_number();
  return ok();
}

Status InputFrame::place(size_t alignment, size_t padding) {
  const auto& choice = plan_->input_choice;
  const size_t count = choice.empty() ? views().size() : choice.size();
  if (count != tensors_.size())
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the frame and the model have different numbers of tensors",
                 .offered = std::to_string(count),
                 .needed = std::to_string(tensors_.size()),
                 .difference = "number of tensors"};
  for (size_t i = 0; i < count; ++i) {
    const auto& view = views()[choice.empty() ? i : choice[i]];
    size_t capacity = view.capacity;
    const auto bytes = suitable(i, view, alignment, padding, &capacity);
    tensors_[i].data = bytes.data();
    tensors_[i].bytes = bytes.size();
    tensors_[i].capacity = capacity;
    tensors_[i].flags = WEIR_TENSOR_READONLY;
  }
  return ok();
}

// Returns the payload, or a copy if its address or the readable bytes after it do not suit the
// model.
std::span<std::byte> InputFrame::suitable(size_t index, const gst::TensorPlace& view,
                                          size_t alignment, size_t padding, size_t* capacity) {
  const size_t size = view.payload.size(), needed = size + padding;
  if (reinterpret_cast<uintptr_t>(view.payload.data()) % alignment == 0 && view.capacity >= needed)
    return view.payload;
  if (copies_.size() <= index) copies_.resize(index + 1);
  auto& copy = copies_[index];
  copy.resize(needed + alignment - 1);
  void* at = copy.data();
  size_t room = copy.size();
  std::align(alignment, needed, at, room);
  if (size > 0) std::memcpy(at, view.payload.data(), size);
  ledger_->copied(size);
  *capacity = needed;
  return {static_cast<std::byte*>(at), size};
}

std::shared_ptr<const void> InputFrame::hold() {
  auto held = std::make_shared<HeldBuffer>();
  held->buffer = gst::Ref<GstBuffer>::share(buffer_);
  for (guint i = 0; i < gst_buffer_n_memory(buffer_); ++i) {
    gst::MappedMemory map(gst_buffer_peek_memory(buffer_, i), GST_MAP_READ);
    if (!map) return nullptr;
    held->maps.push_back(std::move(map));
  }
  const bool all = std::all_of(tensors_.begin(), tensors_.end(),
                               [&](const auto& tensor) { return held->has(tensor); });
  return all ? held : nullptr;
}

}  // namespace weir
