// ClientStreams: the frames and times of each client of one converter.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>

#include "core/sync/backwards_time.hpp"
#include "elements/tensor_converter/chunker.hpp"
#include "gstcpp/element/per_client.hpp"

namespace weir {

struct ClientStream {
  Chunker chunker;
  BackwardsTimeWatch times;
};

// Buffers without a client belong to client 0. At most gst::kClientLimit clients have waiting
// frames.
class ClientStreams {
 public:
  // `given_up` gets the number of buffers lost when a client is replaced.
  explicit ClientStreams(std::function<void(uint64_t lost)> on_replaced);

  // Like Chunker::configure, for present and future clients.
  void configure(size_t frame_bytes, uint64_t frames_out, Fraction rate);
  ClientStream& of(int64_t client) { return clients_.of(client); }
  uint64_t drop();           // drops waiting frames; returns how many buffers are lost
  uint64_t clear();          // removes all clients; returns how many buffers are lost
  void times_begin_again();  // a new segment: times before it are not compared

 private:
  size_t frame_bytes_ = 1;
  uint64_t frames_out_ = 1;
  Fraction rate_;
  gst::PerClient<ClientStream> clients_;
};

}  // namespace weir
