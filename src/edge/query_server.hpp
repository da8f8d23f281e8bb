// QueryServer: what a protocol gives to a pair of tensor_query_serversrc and
// tensor_query_serversink. The plug-in of a protocol registers how to open one.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "core/filter/described_model.hpp"
#include "core/limit/buffer_limit.hpp"
#include "core/process/process_object.hpp"
#include "edge/serversrc_settings.hpp"
#include "transport/query_request.hpp"

namespace weir {

// What became of a frame that tensor_query_serversink received.
enum class Delivery {
  Sent,
  NoRequest,    // the frame answers no request
  OtherServer,  // the frame answers a request of a server with another protocol
  Lost          // the client has gone, or does not receive
};

// The server of one pair. Thread-safe, but set_input() and make_frame() are the source's streaming
// thread's, set_output() and respond() the sink's.
class QueryServer {
 public:
  QueryServer() = default;
  QueryServer(const QueryServer&) = delete;
  QueryServer& operator=(const QueryServer&) = delete;
  virtual ~QueryServer() = default;

  // Lets clients find the server; called once, after it has been paired.
  virtual Status publish() = 0;
  // The port that it listens on; 0 without one.
  virtual uint32_t port() const = 0;
  // What it serves and where, for the log.
  virtual std::string description() const = 0;
  // Caps of the requests. `names` of the tensors, by the filter that takes them; may be empty.
  virtual Status set_input(GstCaps* caps, const std::vector<std::string>& names,
                           const BufferLimit& limit) = 0;
  // Caps of the responses. `names` of the tensors, by the filter that made them; may be empty.
  // `model`, which may be null, describes the tensors of a flexible stream.
  virtual Status set_output(GstCaps* caps, const std::vector<std::string>& names,
                            const DescribedModel* model) = 0;
  // What the responses will be, before their caps, which come with the first request: fixed caps,
  // or null if that request decides. Called on the source's streaming thread after set_input();
  // has no effect after set_output().
  virtual Status expect_output(GstCaps* caps, const std::vector<std::string>& names) = 0;
  // Waits for a request whose client still waits. Null after interrupt(), until resume().
  virtual std::shared_ptr<QueryRequest> take() = 0;
  virtual void interrupt() = 0;
  virtual void resume() = 0;
  // The frame of a request. Ends the request when it returns an error.
  virtual Result<gst::Ref<GstBuffer>> make_frame(QueryRequest& request) = 0;
  // Answers `request`, which the buffer belongs to; it may be null or another server's. Adds the
  // bytes that it copied.
  virtual Result<Delivery> respond(QueryRequest* request, GstBuffer* buffer,
                                   uint64_t* bytes_copied) = 0;
  // Whether frames flow: in PLAYING.
  virtual Status set_running(bool running) = 0;
  // Refuses the requests that come, and ends those that wait. Those that were taken can still be
  // answered.
  virtual void close() = 0;
  // Ends all requests, and refuses those that come. Called once.
  virtual void stop() = 0;
  // How many requests ended in which way: for the log.
  virtual std::string summary() const = 0;
  virtual void add_stats(GstStructure* stats) const = 0;
};

using OpenQueryServer = Result<std::shared_ptr<QueryServer>> (*)(const ServersrcSettings& settings,
                                                                 const std::string& default_name);

// The protocols of other plug-ins, set when such a plug-in is loaded.
struct QueryProtocols {
  std::atomic<OpenQueryServer> oip{nullptr};
};
inline QueryProtocols& query_protocols() {
  return process::object<QueryProtocols>("query-protocols");
}

}  // namespace weir
