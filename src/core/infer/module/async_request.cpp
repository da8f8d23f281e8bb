// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/async_request.hpp"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <shared_mutex>
#include <unordered_map>
#include <utility>

#include "core/infer/module/host.hpp"
#include "core/process/process_object.hpp"

namespace weir::infer {

struct Requests::Request {
  std::shared_ptr<State> state;
  std::shared_ptr<RequestReceiver> receiver;  // until the end, since it owns the frames' memory
  std::atomic<bool> cancelled{false};
  weir_error error;       // set by the engine between error_of() and complete()
  bool known = false;     // to the engine
  bool finished = false;  // the receiver is not called again
};

namespace {

using Request = Requests::Request;

uintptr_t to_number(const weir_request* request) {
  return reinterpret_cast<uintptr_t>(request);
}
weir_request* to_handle(uintptr_t number) {
  // NOLINTNEXTLINE(performance-no-int-to-ptr): a handle of the C ABI, never dereferenced
  return reinterpret_cast<weir_request*>(number);
}

// All requests of the process. Engines may pass any number at any time.
class Registry {
 public:
  // Shared by all copies of this code: a module only knows the host that loaded it.
  static Registry& instance() {
    static auto& registry = process::object<Registry>("requests");
    return registry;
  }
  uintptr_t add(std::shared_ptr<Request> request) {
    std::unique_lock lock(mutex_);
    requests_.emplace(++last_, std::move(request));
    return last_;
  }
  std::shared_ptr<Request> find(uintptr_t number) const {
    std::shared_lock lock(mutex_);
    const auto at = requests_.find(number);
    return at == requests_.end() ? nullptr : at->second;
  }
  void remove(uintptr_t number) {
    std::shared_ptr<Request> outlives_the_lock;
    std::unique_lock lock(mutex_);
    const auto at = requests_.find(number);
    if (at == requests_.end()) return;
    outlives_the_lock = std::move(at->second);
    requests_.erase(at);
  }

 private:
  mutable std::shared_mutex mutex_;  // guards the rest
  std::unordered_map<uintptr_t, std::shared_ptr<Request>> requests_;
  uintptr_t last_ = 0;
};

// Whether the frame has the members that receivers read.
bool has_tensors(const weir_frame& frame) noexcept {
  return frame.struct_size >= offsetof(weir_frame, pts);
}

Error short_frame(const weir_frame& frame) {
  return Error{.code = Code::CALLBACK_FAILED,
               .what = "the engine completed a request with an incomplete weir_frame",
               .offered = "struct_size " + std::to_string(frame.struct_size),
               .needed = "at least " + std::to_string(offsetof(weir_frame, pts)),
               .fix = "frame.struct_size = sizeof frame;"};
}

void release_memory(weir_frame* frame) noexcept {
  if (!frame || !has_tensors(*frame) || !frame->tensors) return;
  for (uint32_t i = 0; i < std::min<uint32_t>(frame->n_tensors, WEIR_TENSOR_LIMIT); ++i) {
    weir_tensor& tensor = frame->tensors[i];
    if (auto* release = std::exchange(tensor.release, nullptr)) release(tensor.owner);
    tensor.data = tensor.owner = nullptr;
  }
}

// Removes a request and frees its slot. The caller releases the returned receiver.
std::shared_ptr<RequestReceiver> forget(uintptr_t number, Request& request) {
  Registry::instance().remove(number);
  std::lock_guard lock(request.state->mutex);
  request.state->requests.erase(number);
  request.state->changed.notify_all();
  return std::move(request.receiver);
}

// The receiver of a request, null if it is not called again. This thread counts as one that is in a
// receiver until leave().
std::shared_ptr<RequestReceiver> enter(Request& request, bool is_final) {
  std::lock_guard lock(request.state->mutex);
  if (request.finished) return nullptr;
  request.finished = is_final;
  request.state->callers.push_back(std::this_thread::get_id());
  return request.receiver;
}
void leave(Requests::State& state) {
  std::lock_guard lock(state.mutex);
  auto& callers = state.callers;
  callers.erase(std::find(callers.begin(), callers.end(), std::this_thread::get_id()));
  state.changed.notify_all();
}

}  // namespace

Requests::~Requests() {
  std::map<uintptr_t, std::shared_ptr<Request>> left;
  {
    std::lock_guard lock(state_->mutex);
    for (auto& [number, request] : state_->requests) request->finished = true;
    left.swap(state_->requests);
  }
  for (auto& [number, request] : left) {
    Registry::instance().remove(number);
    std::shared_ptr<RequestReceiver> receiver;  // outlives the lock
    std::lock_guard lock(state_->mutex);
    receiver = std::move(request->receiver);
  }
}

template <class Condition>
bool Requests::wait_for(Condition condition) {
  std::unique_lock lock(state_->mutex);
  ++state_->waiting;
  state_->changed.wait(lock, [&] { return state_->refuses || condition(); });
  --state_->waiting;
  return !state_->refuses;
}

bool Requests::wait_for_room() {
  return wait_for([this] { return state_->requests.size() < state_->max; });
}

weir_request* Requests::open(std::shared_ptr<RequestReceiver> receiver) {
  auto request = std::make_shared<Request>();
  request->state = state_;
  request->receiver = std::move(receiver);
  std::lock_guard lock(state_->mutex);
  if (state_->refuses) return nullptr;
  const uintptr_t number = Registry::instance().add(request);
  state_->requests.emplace(number, std::move(request));
  return to_handle(number);
}

bool Requests::begun(weir_request* handle) {
  std::lock_guard lock(state_->mutex);
  const auto at = state_->requests.find(to_number(handle));
  if (at == state_->requests.end()) return false;
  at->second->known = true;
  return at->second->cancelled;
}

bool Requests::withdraw(weir_request* handle) {
  std::shared_ptr<Request> request;
  bool waiting = false;
  {
    std::lock_guard lock(state_->mutex);
    const auto at = state_->requests.find(to_number(handle));
    if (at == state_->requests.end()) return false;
    request = at->second;
    waiting = !std::exchange(request->finished, true);
  }
  forget(to_number(handle), *request);
  return waiting;
}

Requests::Abandoned Requests::abandon() {
  Abandoned out;
  std::lock_guard lock(state_->mutex);
  state_->refuses = true;
  for (auto& [number, request] : state_->requests) {
    if (!std::exchange(request->finished, true)) ++out.count;
    if (!request->cancelled.exchange(true) && request->known)
      out.cancel.push_back(to_handle(number));
  }
  state_->changed.notify_all();
  return out;
}

bool Requests::has_waiting_receivers() const {
  std::lock_guard lock(state_->mutex);
  return state_->waiting > 0 ||
         std::any_of(state_->requests.begin(), state_->requests.end(),
                     [](const auto& entry) { return !entry.second->finished; });
}

void Requests::fail(const Error& error) {
  std::vector<std::shared_ptr<RequestReceiver>> receivers;
  std::unique_lock lock(state_->mutex);
  state_->refuses = true;
  for (auto& [number, request] : state_->requests)
    if (!std::exchange(request->finished, true)) receivers.push_back(request->receiver);
  state_->callers.push_back(std::this_thread::get_id());
  lock.unlock();
  for (const auto& receiver : receivers) receiver->end(error);
  leave(*state_);
}

void Requests::resume() {
  std::lock_guard lock(state_->mutex);
  state_->refuses = false;
}

void Requests::wait_until_quiet() {
  std::unique_lock lock(state_->mutex);
  const auto is_here = [](std::thread::id id) { return id == std::this_thread::get_id(); };
  state_->changed.wait(
      lock, [&] { return std::all_of(state_->callers.begin(), state_->callers.end(), is_here); });
}

bool Requests::wait_until_idle() {
  return wait_for([this] { return state_->requests.empty(); });
}

size_t Requests::in_flight() const {
  std::lock_guard lock(state_->mutex);
  return state_->requests.size();
}

void complete_request(weir_request* handle, int status, weir_frame* frame, bool more) noexcept {
  const auto request = Registry::instance().find(to_number(handle));
  if (!request) return release_memory(frame);
  const bool is_short = status == 0 && frame && !has_tensors(*frame);
  const bool is_final = status < 0 || !more || is_short;
  const auto receiver = enter(*request, is_final);
  if (receiver) {
    if (status == 0 && frame && !is_short) receiver->output(*frame);
    if (is_short)
      receiver->end(short_frame(*frame));
    else if (status < 0)
      receiver->end(take_error(&request->error, status, "the engine failed on a frame"));
    else if (is_final)
      receiver->end(status);
    leave(*request->state);
  }
  if (!more) forget(to_number(handle), *request);
  release_memory(frame);
}

weir_error* error_of_request(weir_request* handle) noexcept {
  const auto request = Registry::instance().find(to_number(handle));
  return request ? &request->error : nullptr;  // valid until the engine ends the request
}

bool is_cancelled(const weir_request* handle) noexcept {
  const auto request = Registry::instance().find(to_number(handle));
  return !request || request->cancelled;
}

}  // namespace weir::infer
