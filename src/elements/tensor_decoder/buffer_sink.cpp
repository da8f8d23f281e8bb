// Memory for decoders.
#include "elements/tensor_decoder/buffer_sink.hpp"

#include <cstring>

#include "core/tensor/packed_tensors.hpp"
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
  parts_.push_back({*std::move(memory), {}});
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

size_t BufferSink::size_of(const Part& part) {
  return part.memory ? gst_memory_get_sizes(part.memory.get(), nullptr, nullptr)
                     : part.bytes.size();
}

Status BufferSink::copy(const Part& part, std::span<std::byte> out) {
  gst::MappedMemory map;
  if (part.memory) map = gst::MappedMemory(part.memory.get(), GST_MAP_READ);
  if (part.memory && !map) return gst::memory_not_mapped();
  const std::span<const std::byte> from = part.memory ? map.bytes() : part.bytes;
  if (!from.empty()) std::memcpy(out.data(), from.data(), from.size());
  return ok();
}

Result<gst::Ref<GstMemory>> BufferSink::joined(std::span<const Part> parts) {
  size_t total = 0;
  for (const Part& part : parts) total += size_of(part);
  if (auto status = limit_->check(reserved_ + total); !status) return status.error();
  auto memory = gst::allocate_memory(total);
  if (!memory) return memory;
  const gst::MappedMemory map(memory->get(), GST_MAP_WRITE);
  if (!map) return gst::memory_not_mapped();
  size_t at = 0;
  for (const Part& part : parts) {
    if (auto status = copy(part, map.bytes().subspan(at)); !status) return status.error();
    at += size_of(part);
  }
  ledger_->copied(total);
  reserved_ += total;
  return memory;
}

// A buffer joins its memories by itself when it gets more than it can have, and maps them for that.
Status BufferSink::finish() {
  maps_.clear();
  const size_t alone = parts_.size() > kMemoryLimit ? kMemoryLimit - 1 : parts_.size();
  const auto append = [this](std::span<const Part> parts) -> Status {
    auto one = parts.size() == 1 && parts[0].memory ? Result(parts[0].memory) : joined(parts);
    if (!one) return one.error();
    gst_buffer_append_memory(out_, one->release());
    return ok();
  };
  const std::span<const Part> parts(parts_);
  for (size_t i = 0; i < alone; ++i)
    if (auto status = append(parts.subspan(i, 1)); !status) return status;
  return alone < parts.size() ? append(parts.subspan(alone)) : ok();
}

}  // namespace weir
