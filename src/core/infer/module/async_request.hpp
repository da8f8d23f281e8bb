// Requests to asynchronous engines: the implementation of weir_request.
//
// Guarantees of the host and requirements for engines:
// - The frame passed to submit() and the memory it points to are valid until the request ends with
//   more = 0, or until session_free() returns. Outputs are in memory of the engine (host->allocate)
//   with release; memory without release is copied before complete() returns.
// - complete() with status 0 and a frame is an output, with NULL it is none; status > 0 is a
//   dropped output; status < 0 is a failure, after which outputs of the request are ignored. A
//   request ends with more = 0 and is in flight until then. Calls for one request must not overlap;
//   those for several may come from several threads and from within submit().
// - A call for a request that has ended, or whose session is freed, only releases the frame's
//   memory: a weir_request is a number that is never reused and never dereferenced.
// - After a flush the host cancels the requests in flight and ignores their outputs. An engine that
//   ignores cancel() keeps their slots until it ends them; new requests wait, interrupted by the
//   next flush or the end. cancel() may be called for a request that has just ended.
// - submit() and cancel() are not serialised with other sessions of the model and may be called
//   while requests are in flight: an engine with submit() protects shared state.
// - session_free() ends the work of a session, however long that takes, and abandons the remaining
//   requests. Only callers that need the result wait for an engine that never completes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <condition_variable>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::infer {

// Receives the results of a request, on threads of the engine.
class RequestReceiver {
 public:
  virtual ~RequestReceiver() = default;
  // An output. The receiver sets release of the tensors that it takes over to null; the caller
  // releases the others.
  virtual void output(weir_frame& frame) noexcept = 0;
  // Called once, as the last call, unless the request was abandoned before. `ended`: what the
  // engine returned, 0 or a weir_no_result, or its error.
  virtual void end(const Result<int>& ended) noexcept = 0;
};

// The requests of one session. All functions are thread-safe.
class Requests {
 public:
  // At most `max` (>= 1) requests in flight.
  explicit Requests(size_t max) : state_(std::make_shared<State>(max)) {}
  // Abandons the requests in flight: the session is freed.
  ~Requests();
  Requests(const Requests&) = delete;
  Requests& operator=(const Requests&) = delete;

  // Waits for a free slot; abandoned requests occupy theirs until they end. Returns false between
  // abandon() and resume().
  bool wait_for_room();
  // Begins a request. It owns its receiver, and thus the frame's memory, until it ends. Returns
  // null between abandon() and resume().
  weir_request* open(std::shared_ptr<RequestReceiver> receiver);
  // Marks the request as known to the engine. Returns true if it was abandoned in the meantime and
  // must be cancelled.
  bool begun(weir_request* request);
  // Call it if the engine rejected the request. Returns false if it has ended or was abandoned.
  bool withdraw(weir_request* request);
  // Abandoned requests, each counted once; their receivers are not called again. `cancel`: those
  // that the engine knows and has not ended.
  struct Abandoned {
    size_t count = 0;
    std::vector<weir_request*> cancel;
  };
  Abandoned abandon();
  // True if a receiver or a call of wait_for_...() waits for the engine.
  bool has_waiting_receivers() const;
  // Ends every request with `error`, reported to its receiver during the call, and rejects new ones
  // as abandon() does, which is still required. Does not call the engine.
  void fail(const Error& error);
  void resume();
  // Waits until no other thread is in a receiver.
  void wait_until_quiet();
  // Waits until no request is in flight; returns false between abandon() and resume().
  bool wait_until_idle();
  size_t in_flight() const;

  struct Request;
  struct State {
    explicit State(size_t count) : max(count) {}
    mutable std::mutex mutex;  // guards the rest and the requests
    std::condition_variable changed;
    const size_t max;
    std::map<uintptr_t, std::shared_ptr<Request>> requests;
    std::vector<std::thread::id> callers;  // threads that are in a receiver
    bool refuses = false;
    size_t waiting = 0;  // calls of wait_for_room() and wait_until_idle()
  };

 private:
  template <class Condition>
  bool wait_for(Condition condition);

  std::shared_ptr<State> state_;
};

// weir_host::complete, error_of and cancelled.
void complete_request(weir_request* request, int status, weir_frame* frame, bool more) noexcept;
// Null if the request has ended.
weir_error* error_of_request(weir_request* request) noexcept;
bool is_cancelled(const weir_request* request) noexcept;

}  // namespace weir::infer
