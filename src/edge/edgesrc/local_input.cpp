// LocalInput: buffers in the memory of an edgesink of another process.
// SPDX-License-Identifier: LGPL-2.1-or-later

#include <cstring>
#include <memory>
#include <string>
#include <utility>

#include "core/text/shell_quote.hpp"
#include "edge/buffer_metas.hpp"
#include "edge/edgesrc/buffer_input.hpp"
#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/buffer/caps_text.hpp"
#include "transport/local/subscriber.hpp"

namespace weir {

class LocalInput : public BufferInput {
 public:
  LocalInput(local::Subscriber subscriber, int interruption)
      : subscriber_(std::move(subscriber)), interruption_(interruption) {}
  Result<InputEvent> receive() override;

 private:
  local::Subscriber subscriber_;
  const int interruption_;
};
namespace {

using Frame = std::shared_ptr<const local::ReceivedFrame>;

// What a buffer can have without a copy: more memories are merged.
guint max_memories() {
  return gst_buffer_get_max_memory();
}

void release(gpointer frame) {
  const std::unique_ptr<Frame> owned(static_cast<Frame*>(frame));
}

// Those of a buffer's content: none of GstMiniObject or of its memory.
constexpr uint64_t kFlags =
    UINT32_MAX & ~uint64_t{GST_MINI_OBJECT_FLAG_LAST - 1} & ~uint64_t{GST_BUFFER_FLAG_TAG_MEMORY};

Result<gst::Ref<GstMemory>> make_memory(std::span<const std::byte> bytes, const Frame& frame,
                                        bool copies) {
  if (copies) {
    auto out = gst::allocate_memory(bytes.size());
    if (!out) return out;
    const gst::MappedMemory map(out->get(), GST_MAP_WRITE);
    if (!bytes.empty()) std::memcpy(map.bytes().data(), bytes.data(), bytes.size());
    return out;
  }
  // Read-only: an element that writes gets a copy.
  void* const data = const_cast<std::byte*>(bytes.data());
  return gst::Ref<GstMemory>::adopt(gst_memory_new_wrapped(
      GST_MEMORY_FLAG_READONLY, data, bytes.size(), 0, bytes.size(), new Frame(frame), release));
}

Result<gst::Ref<GstBuffer>> make_buffer(const Frame& frame, bool copies) {
  if (frame->memories.size() > max_memories())
    return local::bad_writer("a frame of " + std::to_string(frame->memories.size()) + " memories");
  auto out = gst::Ref<GstBuffer>::adopt(gst_buffer_new());
  for (const auto& bytes : frame->memories) {
    auto memory = make_memory(bytes, frame, copies);
    if (!memory) return memory.error();
    gst_buffer_append_memory(out.get(), memory->release());
  }
  GST_BUFFER_PTS(out.get()) = frame->times.pts;
  GST_BUFFER_DTS(out.get()) = frame->times.dts;
  GST_BUFFER_DURATION(out.get()) = frame->times.duration;
  GST_BUFFER_OFFSET(out.get()) = frame->times.offset;
  GST_BUFFER_OFFSET_END(out.get()) = frame->times.offset_end;
  GST_BUFFER_FLAG_UNSET(out.get(), GST_BUFFER_FLAG_TAG_MEMORY);  // set by appending
  GST_BUFFER_FLAGS(out.get()) |= static_cast<guint>(frame->times.flags & kFlags);
  if (auto status = decode_metas(frame->metas, out.get()); !status) return status.error();
  return out;
}

}  // namespace

Result<std::unique_ptr<BufferInput>> connect_local_input(const std::string& path,
                                                         int interruption) {
  auto subscriber = local::Subscriber::connect(path, interruption);
  if (!subscriber) return subscriber.error();
  return std::unique_ptr<BufferInput>(new LocalInput(*std::move(subscriber), interruption));
}

Result<InputEvent> LocalInput::receive() {
  auto event = subscriber_.receive(interruption_);
  if (!event) return event.error();
  switch (event->kind) {
    case local::StreamEvent::Kind::Caps: {
      auto caps = gst::caps_from_text(event->caps);
      if (!caps)
        return local::bad_writer("caps that cannot be used: " + caps.error().offered + ", not " +
                                 caps.error().needed);
      if (!gst_caps_is_fixed(caps->get()))
        return local::bad_writer("caps that are not fixed: " + quoted_text(event->caps));
      return InputEvent{InputEvent::Kind::Caps, *std::move(caps), {}};
    }
    case local::StreamEvent::Kind::Frame: {
      // The elements downstream keep all frames that they may: without a copy both sides would
      // wait.
      const bool copies = subscriber_.holds_all();
      auto buffer = make_buffer(event->frame, copies);
      if (!buffer) return buffer.error();
      const uint64_t copied = copies ? gst_buffer_get_size(buffer->get()) : 0;
      return InputEvent{InputEvent::Kind::Buffer, {}, *std::move(buffer), copied};
    }
    case local::StreamEvent::Kind::End:
      return InputEvent{InputEvent::Kind::End};
    case local::StreamEvent::Kind::Lost:
      return InputEvent{InputEvent::Kind::Lost};
    case local::StreamEvent::Kind::Interrupted:
      break;
  }
  return InputEvent{InputEvent::Kind::Interrupted};
}

}  // namespace weir
