// ServedModel: a model that is served to clients: its description, the requests that wait, and what
// became of all requests. ServedRequest: one request on its way.
//
//   gRPC's threads:          model->receive(call, request)      queued, or refused at once
//   the streaming thread:    request = model->take()            waits for the next
//   wherever its result is:  request->respond(outputs, memory)
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "net/protocol/oip_service_messages.hpp"
#include "net/server/call.hpp"

namespace weir::net {

// Returns for each input of the model the index of its tensor in the request. Names decide; a
// tensor may have more or fewer outer dimensions of 1, and BOOL is accepted for UINT8.
// SPEC_MISMATCH with both sides, before anything is copied.
Result<std::vector<size_t>> match_inputs(const InferRequest& request, const ModelMetadata& model);
// Returns the indices of the outputs that the request asks for, in its order; all if it asks for
// none. SPEC_MISMATCH for a name that the model does not have.
Result<std::vector<size_t>> match_outputs(const InferRequest& request, const ModelMetadata& model);

class ServedModel;

// Thread-safe. A request whose last reference goes without an end ends as ABORTED, which names the
// element that it entered last; as UNAVAILABLE while the pipeline does not run.
class ServedRequest {
 public:
  using Clock = Call::Clock;
  ServedRequest(std::shared_ptr<ServedModel> model, std::shared_ptr<Call> call,
                InferRequest request, std::vector<size_t> order);
  ~ServedRequest();
  ServedRequest(const ServedRequest&) = delete;
  ServedRequest& operator=(const ServedRequest&) = delete;

  const std::string& peer() const noexcept { return call_->peer(); }
  const std::string& trace_parent() const noexcept { return call_->trace_parent(); }
  // Copies the elements of the model's input `index` to `to`, whose size is the tensor's.
  Status read_input(size_t index, std::span<std::byte> to) const;
  // Return the number of bytes of an input of type BYTES, which has one element, and copy them.
  size_t size_of_bytes(size_t index) const;
  void copy_bytes(size_t index, std::span<std::byte> to) const;
  // Ends the request if its client no longer waits for the response: true when it has ended.
  bool end_if_expired();
  // `element`: a text that lives as long as the process.
  void entered(const char* element) noexcept { last_element_ = element; }
  void pushed() noexcept { pushed_ = Clock::now(); }

  // Both return false, and do nothing, when the request has ended before. The outputs that the
  // client asked for are sent; `memory` keeps their bytes.
  bool respond(const std::vector<RequestTensor>& outputs,
               const std::shared_ptr<const void>& memory);
  bool fail(CallStatus status, const std::string& message);

 private:
  friend class ServedModel;
  // How a request ends, for the counts.
  enum class End { Answered, Refused, Expired, Aborted };
  // Checks a request that is taken: it may have waited since before set_inputs().
  bool end_if_inputs_changed();
  ServerTimes times() const;
  bool fail_as(End end, CallStatus status, const std::string& message);

  const std::shared_ptr<ServedModel> model_;
  const std::shared_ptr<Call> call_;
  const InferRequest request_;
  std::vector<size_t> order_;  // of the model's inputs in the request
  std::atomic<bool> ended_{false};
  std::atomic<const char*> last_element_{nullptr};
  const Clock::time_point received_ = Clock::now();
  Clock::time_point taken_ = received_, pushed_ = received_;  // streaming thread, before its push
};

// received = answered + refused + expired + aborted + in_flight.
struct ServedCounts {
  uint64_t received = 0, answered = 0, refused = 0, expired = 0, aborted = 0, in_flight = 0;
};

// Thread-safe.
class ServedModel : public std::enable_shared_from_this<ServedModel> {
 public:
  // `max_waiting`: requests that wait for take(); more are refused at once.
  ServedModel(ModelRequest model, std::string platform, size_t max_waiting);

  const ModelRequest& model() const noexcept { return model_; }
  void set_inputs(std::vector<TensorText> inputs);
  void set_outputs(std::vector<TensorText> outputs);
  // The outputs as far as they are known before the first request; none if that decides. Has no
  // effect after set_outputs().
  void expect_outputs(std::vector<TensorText> outputs);
  // Whether inputs are known and outputs set or expected, and it is loaded and not stopped.
  bool ready() const;
  ModelMetadata metadata() const;

  // Called, on any thread, when ready() may have changed.
  void set_observer(std::function<void()> observer);
  // An unloaded model refuses requests with UNAVAILABLE; those that it has are answered.
  void set_loaded(bool loaded);
  bool is_loaded() const;
  void receive(std::shared_ptr<Call> call, InferRequest request);
  // Waits for a request that fits the inputs and whose client still waits. Null after interrupt(),
  // until resume().
  std::shared_ptr<ServedRequest> take();
  void interrupt();
  void resume();
  // Whether frames flow. While they do not, a request that an element drops ends as UNAVAILABLE.
  void set_running(bool running);
  // Refuses the requests that come, and ends those that wait, with UNAVAILABLE. Those that were
  // taken can still be answered.
  void close();
  // Ends all requests with UNAVAILABLE, and refuses those that come. Call before the last reference
  // goes: requests that wait keep the model.
  void stop();

  ServedCounts counts() const;
  ModelStatistics statistics() const;

 private:
  friend class ServedRequest;
  void count(ServedRequest* request, ServedRequest::End end);
  std::shared_ptr<ServedRequest> next();
  bool enqueue(const std::shared_ptr<ServedRequest>& request);
  bool is_running() const;
  void end_as_stopped(const std::deque<std::shared_ptr<ServedRequest>>& requests) const;
  std::string stopped_text() const;
  void notify() const;

  const ModelRequest model_;
  const std::string platform_;
  const size_t max_waiting_;
  mutable std::mutex mutex_;  // guards the rest
  std::condition_variable arrived_;
  bool loaded_ = true, interrupted_ = false, running_ = true, stopped_ = false,
       knows_inputs_ = false, knows_outputs_ = false, expects_outputs_ = false;
  std::vector<TensorText> inputs_, outputs_;
  std::function<void()> observer_;
  std::deque<std::shared_ptr<ServedRequest>> waiting_;
  std::unordered_map<ServedRequest*, std::weak_ptr<ServedRequest>> in_flight_;
  ServedCounts counts_;
  ModelStatistics statistics_;
};

}  // namespace weir::net
