// ClientStreams: the frames and the time of each client that sends through one converter.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>

#include "core/sync/backwards_time.hpp"
#include "elements/tensor_converter/chunker.hpp"
#include "gstcpp/per_client.hpp"

namespace weir {

struct ClientStream {
  Chunker chunker;
  BackwardsTimeWatch times;
};

// Buffers without a client are of client 0. At most gst::kClientLimit clients have frames waiting.
class ClientStreams {
 public:
  // `given_up` is told how many buffers were lost with a client whose place was needed.
  explicit ClientStreams(std::function<void(uint64_t lost)> given_up);

  // As Chunker::configure, for the clients there are and those that come.
  void configure(size_t frame_bytes, uint64_t frames_out, Fraction rate);
  ClientStream& of(int64_t client) { return clients_.of(client); }
  uint64_t drop();          // the frames that wait; how many buffers are lost by it
  uint64_t clear();         // forgets all clients; how many buffers are lost by it
  void times_begin_anew();  // a new segment: its times are not compared with those before

 private:
  size_t frame_bytes_ = 1;
  uint64_t frames_out_ = 1;
  Fraction rate_;
  gst::PerClient<ClientStream> clients_;
};

}  // namespace weir
