// Allocates memory for decoders.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_decoder/buffer_sink.hpp"

#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/buffer/memory_part.hpp"

namespace weir {

Status BufferSink::set_caps(const std::string& caps) {
  caps_ = caps;
  return ok();
}

void* BufferSink::reserve(uint64_t bytes) {
  if (!out_ || bytes > G_MAXSSIZE) return nullptr;
  auto allowed = limit_->check(reserved_ + bytes);
  auto memory = allowed ? gst::allocate_memory(bytes) : std::move(allowed).error();
  if (!memory) {
    refusal_ = memory.error();
    return nullptr;
  }
  reserved_ += bytes;
  maps_.emplace_back(memory->get(), GST_MAP_WRITE);
  parts_.push_back({*std::move(memory), {}});
  return maps_.back() ? static_cast<void*>(maps_.back().bytes().data()) : nullptr;
}

Status BufferSink::share_input(uint32_t index) {
  if (!out_ || index >= reader_->tensors().size())
    return Error{.code = Code::CALLBACK_FAILED,
                 .what = "a decoder shares a tensor that does not exist",
                 .offered = std::to_string(index)};
  const auto& view = reader_->tensors()[index];
  if (view.memory < 0) {
    parts_.push_back({{}, view.payload});
    return ok();
  }
  bool copied = false;
  auto part = gst::part_of(gst_buffer_peek_memory(in_, static_cast<guint>(view.memory)),
                           view.header_bytes, view.payload.size(), &copied);
  if (!part) return part.error();
  if (copied) ledger_->copied(view.payload.size());
  parts_.push_back({*std::move(part), {}});
  return ok();
}

Status BufferSink::finish() {
  maps_.clear();
  return gst::append_parts(parts_, out_, [this](size_t bytes) -> Result<gst::Ref<GstMemory>> {
    if (auto status = limit_->check(reserved_ + bytes); !status) return status.error();
    auto memory = gst::allocate_memory(bytes);
    if (!memory) return memory;
    ledger_->copied(bytes);
    reserved_ += bytes;
    return memory;
  });
}

}  // namespace weir
