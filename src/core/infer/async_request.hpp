// Requests to an engine that answers asynchronously: what stands behind weir_request.
//
// What the host keeps to, and what it asks of an engine:
//  * The frame given to submit() and what it points to live until the request ends with more = 0,
//  or
//    until session_free() returns. Outputs are in memory of the engine (host->allocate), with
//    release; what has no release is copied before complete() returns.
//  * complete() with status 0 and a frame is an output, with NULL it is none; status > 0 is an
//    output that is dropped; status < 0 is a failure: no output of the request counts from then on.
//    A request ends with more = 0, and only then it is no longer in flight. Calls for one request
//    come one after the other; those of several may come from several threads, and from submit().
//  * A call for a request that has ended, or whose session is freed, does nothing but release the
//    frame's memory: a weir_request is a number that is never used again, and is never followed.
//  * After a flush the host cancels what is in flight and takes no output of it. An engine that
//  does
//    not hear of cancel() keeps its places until it ends the requests; new ones wait, interrupted
//    by the next flush or the end. cancel() may come for a request that has just ended.
//  * submit() and cancel() take no turn with other sessions of the model, and may be called while
//    requests are in flight: an engine with submit() guards what they share.
//  * session_free() ends the work of a session, as long as that takes; what has not ended then is
//    given up. Nobody waits for an engine that never answers but those who need its answer.
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

class Session;

// Hears what becomes of a request, on threads of the engine.
class RequestReceiver {
 public:
  virtual ~RequestReceiver() = default;
  // An output. Tensors that it takes over get their release set to null; the rest is released.
  virtual void output(weir_frame& frame) noexcept = 0;
  // Once, and nothing behind it, unless the request was abandoned before.
  virtual void end(Status status) noexcept = 0;
};

// The requests of one session. Every function may be called from any thread.
class Requests {
 public:
  // `most` in flight, at least 1.
  explicit Requests(size_t most) : state_(std::make_shared<State>(most)) {}
  // What has not ended is given up: the session is freed.
  ~Requests();
  Requests(const Requests&) = delete;
  Requests& operator=(const Requests&) = delete;

  // Waits until one more may be in flight; those that were abandoned count. False from an abandon()
  // to resume().
  bool wait_for_room();
  // A request that begins now; it keeps its receiver, and so what that holds, until it ends. Null
  // from an abandon() to resume().
  weir_request* open(std::shared_ptr<RequestReceiver> receiver);
  // The engine knows of it. True when it was abandoned meanwhile: it is to be cancelled now.
  bool begun(weir_request* request);
  // The engine refused it. False when it has ended or was abandoned.
  bool withdraw(weir_request* request);
  // Their receivers hear of no request any more; each is among what is returned, once. `cancel`:
  // those that the engine knows of and has not ended.
  struct Abandoned {
    size_t count = 0;
    std::vector<weir_request*> cancel;
  };
  Abandoned abandon();
  // Somebody waits for the engine's word: a receiver, or a call of wait_for_...().
  bool owes() const;
  // Ends every request with `error`, which its receiver hears here, and refuses as abandon() does,
  // which is still to come: the engine is asked for nothing.
  void fail(const Error& error);
  void resume();
  // Waits until no other thread calls a receiver.
  void wait_until_quiet();
  // Waits until none is in flight; false from an abandon() to resume().
  bool wait_until_idle();
  size_t in_flight() const;

  struct Request;
  struct State {
    explicit State(size_t count) : most(count) {}
    mutable std::mutex mutex;  // guards the rest and the requests
    std::condition_variable changed;
    const size_t most;
    std::map<uintptr_t, std::shared_ptr<Request>> requests;
    std::vector<std::thread::id> callers;  // of receivers, now
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
// Null when the request has ended.
weir_error* error_of_request(weir_request* request) noexcept;
bool is_cancelled(const weir_request* request) noexcept;

// Whether the engine has submit(), and the model says that it may be used.
bool answers_asynchronously(const Session& session) noexcept;
// Gives the engine a frame. False from an abandon() to resume(): the receiver will hear nothing.
// Precondition: answers_asynchronously, and the caller waited for room.
Result<bool> submit(Session& session, const weir_frame& in,
                    std::shared_ptr<RequestReceiver> receiver);
// Abandons and cancels what is in flight; how many receivers will not hear of their end.
size_t abandon(Session& session);

}  // namespace weir::infer
