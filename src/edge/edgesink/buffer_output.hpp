// BufferOutput: where edgesink sends its buffers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <memory>

#include "core/io/deadline.hpp"
#include "core/ledger/ledger.hpp"
#include "weir/result.hpp"

namespace weir {
namespace local {
struct LocalPublisherOptions;
}

// set_caps(), publish() and end() are called by the streaming thread, everything else by any.
class BufferOutput {
 public:
  enum class Outcome {
    Sent,         // to one receiver at least
    NoReceiver,   // there is none
    Missed,       // no receiver had room
    Interrupted,  // call publish() with the same buffer again to go on
  };

  BufferOutput() = default;
  BufferOutput(const BufferOutput&) = delete;
  BufferOutput& operator=(const BufferOutput&) = delete;
  virtual ~BufferOutput() = default;

  // The caps of the buffers that follow.
  virtual Status set_caps(GstCaps* caps) = 0;
  // Called before each buffer of a stream that may have no caps.
  virtual Status set_no_caps() { return ok(); }
  // Counts bytes that it copies in `ledger`.
  virtual Result<Outcome> publish(GstBuffer* buffer, Ledger* ledger) = 0;
  // Reports the end of the stream to receivers, where the protocol has one.
  virtual void end() = 0;
  // False after the deadline or an interruption.
  virtual bool wait_for_receiver(const io::Deadline& deadline) = 0;
  // Ends waiting calls, and those that would wait until resume().
  virtual void interrupt() = 0;
  virtual void resume() = 0;
  // Adds what upstream should allocate to its ALLOCATION query.
  virtual void propose_allocation(GstQuery* query) = 0;
  virtual void add_stats(GstStructure* stats) const = 0;
};

// Listens for other processes, which get the buffers in shared memory. Errors: those of
// local::Publisher::open().
Result<std::unique_ptr<BufferOutput>> open_local_output(local::LocalPublisherOptions options);

}  // namespace weir
