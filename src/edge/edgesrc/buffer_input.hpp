// BufferInput: where edgesrc gets its buffers from.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <memory>
#include <string>

#include "gstcpp/element/ref.hpp"
#include "weir/result.hpp"

namespace weir {

struct InputEvent {
  enum class Kind {
    Caps,         // `caps` of the buffers that follow
    Buffer,       // `buffer`
    End,          // of the stream
    Lost,         // the sender has ended or closed the connection
    Silent,       // the sender has not started the handshake; once for each connection
    Interrupted,  // by the descriptor that the input waits for
  };
  Kind kind;
  gst::Ref<GstCaps> caps{};
  gst::Ref<GstBuffer> buffer{};
  uint64_t copied = 0;  // bytes of the buffer that could have been shared
};

// A connection. Used by the streaming thread.
class BufferInput {
 public:
  BufferInput() = default;
  BufferInput(const BufferInput&) = delete;
  BufferInput& operator=(const BufferInput&) = delete;
  virtual ~BufferInput() = default;
  // Waits for what comes next. An error ends the connection.
  virtual Result<InputEvent> receive() = 0;
  // The caps that the stream has from now on.
  virtual void set_caps(const GstCaps*) {}
  // Ends waits that do not watch the descriptor, until it is called with false. Any thread.
  virtual void interrupt(bool) {}
  // Adds counts of this kind of input. Any thread.
  virtual void add_stats(GstStructure*) const {}
};

// Connects to an edgesink of another process, whose memory the buffers have. `interruption` is
// borrowed. Errors: those of local::Subscriber::connect().
Result<std::unique_ptr<BufferInput>> connect_local_input(const std::string& path, int interruption);

}  // namespace weir
