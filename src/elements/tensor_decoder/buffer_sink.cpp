// Memory for decoders.
#include "elements/tensor_decoder/buffer_sink.hpp"

#include <cstring>

#include "gstcpp/allocation.hpp"
#include "gstcpp/frame_errors.hpp"
#include "gstcpp/memory_part.hpp"

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
  gst_buffer_append_memory(out_, memory->release());
  return maps_.back() ? static_cast<void*>(maps_.back().bytes().data()) : nullptr;
}

Status BufferSink::share_input(uint32_t index) {
  if (!out_ || index >= reader_->tensors().size())
    return Error{Code::CALLBACK_FAILED,
                 "a decoder shares a tensor that is not there",
                 std::to_string(index),
                 "",
                 "",
                 ""};
  const auto& view = reader_->tensors()[index];
  if (view.memory >= 0) {
    bool copied = false;
    auto part = gst::part_of(gst_buffer_peek_memory(in_, static_cast<guint>(view.memory)),
                             view.header_bytes, view.payload.size(), &copied);
    if (!part) return part.error();
    if (copied) ledger_->copied(view.payload.size());
    gst_buffer_append_memory(out_, part->release());
    return ok();
  }
  void* copy = reserve(view.payload.size());
  if (!copy) return gst::memory_ran_out(view.payload.size());
  std::memcpy(copy, view.payload.data(), view.payload.size());
  ledger_->copied(view.payload.size());
  return ok();
}

}  // namespace weir
