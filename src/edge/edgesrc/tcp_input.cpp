// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/edgesrc/tcp_input.hpp"

#include <utility>

#include "core/wire/peer_error.hpp"
#include "gstcpp/buffer/caps_text.hpp"

namespace weir {
Result<std::unique_ptr<BufferInput>> TcpInput::open(const std::string& host, uint32_t port,
                                                    uint64_t max_bytes, const Times& times,
                                                    int interruption) {
  auto subscriber = edge::StreamSubscriber::open(host, port, {.message_bytes = max_bytes},
                                                 times.connect, interruption);
  if (!subscriber) return subscriber.error();
  return std::unique_ptr<BufferInput>(
      new TcpInput(*std::move(subscriber), times, interruption, false));
}

Result<std::unique_ptr<BufferInput>> TcpInput::connect(const std::string& host, uint32_t port,
                                                       uint64_t max_bytes, const Times& times,
                                                       int interruption) {
  auto subscriber = edge::StreamSubscriber::connect(host, port, {.message_bytes = max_bytes}, times,
                                                    interruption);
  if (!subscriber) return subscriber.error();
  return std::unique_ptr<BufferInput>(
      new TcpInput(*std::move(subscriber), times, interruption, true));
}

Result<std::optional<InputEvent>> TcpInput::greet() {
  const auto deadline = was_silent_ ? io::Deadline() : io::deadline_in(times_.greet);
  const auto greeted = subscriber_.greet(deadline, interruption_);
  if (!greeted && greeted.error().code == Code::CANCELLED)
    return std::optional(InputEvent{InputEvent::Kind::Interrupted});
  if (!greeted) return greeted.error();
  is_greeted_ = *greeted;
  if (is_greeted_) return std::optional<InputEvent>();
  was_silent_ = true;
  return std::optional(InputEvent{InputEvent::Kind::Silent});
}

Result<std::optional<InputEvent>> TcpInput::announced_caps() const {
  const std::string& text = subscriber_.caps();
  if (text.empty()) return std::optional<InputEvent>();
  auto caps = gst::caps_from_text(text);
  if (!caps) return wire::peer_error("the caps of the edgesink are not valid", caps.error());
  if (!gst_caps_is_fixed(caps->get())) return std::optional<InputEvent>();
  return std::optional(InputEvent{InputEvent::Kind::Caps, *std::move(caps), {}});
}

Result<InputEvent> TcpInput::receive() {
  if (!is_greeted_) {
    auto event = greet();
    if (!event) return event.error();
    if (*event) return **std::move(event);
  }
  if (!std::exchange(has_given_caps_, true)) {
    auto event = announced_caps();
    if (!event) return event.error();
    if (*event) return **std::move(event);
  }
  auto received = subscriber_.receive(interruption_);
  if (!received) return received.error();
  if (received->end)
    return InputEvent{*received->end == edge::StreamSubscriber::End::Lost
                          ? InputEvent::Kind::Lost
                          : InputEvent::Kind::Interrupted};
  InputEvent out{InputEvent::Kind::Buffer};
  auto buffer = buffers_.make(std::move(received->memories), &out.copied);
  if (!buffer) return buffer.error();
  out.buffer = *std::move(buffer);
  return out;
}

}  // namespace weir
