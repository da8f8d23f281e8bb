// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/client_streams.hpp"

namespace weir {

ClientStreams::ClientStreams(std::function<void(uint64_t)> on_replaced)
    : clients_(
          [this] {
            ClientStream stream;
            stream.chunker.configure(frame_bytes_, frames_out_, rate_);
            return stream;
          },
          [on_replaced = std::move(on_replaced)](ClientStream& stream) {
            on_replaced(stream.chunker.clear());
          }) {}

void ClientStreams::configure(size_t frame_bytes, uint64_t frames_out, Fraction rate) {
  frame_bytes_ = frame_bytes;
  frames_out_ = frames_out;
  rate_ = rate;
  clients_.for_each(
      [&](ClientStream& stream) { stream.chunker.configure(frame_bytes, frames_out, rate); });
}

uint64_t ClientStreams::drop() {
  uint64_t lost = 0;
  clients_.for_each([&](ClientStream& stream) { lost += stream.chunker.drop(); });
  return lost;
}

uint64_t ClientStreams::clear() {
  const uint64_t lost = drop();
  clients_.clear();
  return lost;
}

void ClientStreams::times_begin_again() {
  clients_.for_each([](ClientStream& stream) { stream.times.reset(); });
}

}  // namespace weir
