// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/server/served_model.hpp"

#include <algorithm>

#include "net/protocol/oip_contents.hpp"
#include "net/protocol/oip_types.hpp"
#include "weir/module.hpp"

namespace weir::net {
namespace {

void add(Duration* to, Call::Clock::duration took) {
  ++to->count;
  to->ns += static_cast<uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::max(took, took.zero())).count());
}

// Which input of the request each input of the model is.
Result<std::vector<size_t>> order_of_inputs(const Call& call, const InferRequest& request,
                                            const ModelMetadata& model) {
  auto order = match_inputs(request, model);
  if (!order) return order;
  for (size_t i = 0; i < order->size(); ++i) {
    if (model.inputs[i].datatype != "BYTES") continue;
    if (const auto bytes =
            only_element(call.request(), request.inputs[(*order)[i]], Sender::Client);
        !bytes)
      return bytes.error();
  }
  return order;
}

std::string list(const std::vector<TensorText>& tensors) {
  std::string out;
  for (const auto& tensor : tensors) out += (out.empty() ? "" : ", ") + describe(tensor);
  return out.empty() ? "none" : out;
}

Error mismatch(const ModelMetadata& model, std::string offered, std::string needed) {
  return {.code = Code::SPEC_MISMATCH,
          .what = "the request does not fit the model " + model.name,
          .offered = std::move(offered),
          .needed = std::move(needed),
          .fix = "compare the request with the answer to ModelMetadata"};
}

std::span<const int64_t> without_outer_ones(std::span<const int64_t> shape) {
  while (!shape.empty() && shape.front() == 1) shape = shape.subspan(1);
  return shape;
}

bool same_shape(const TensorText& offered, const TensorText& needed) {
  const auto one = without_outer_ones(offered.shape), other = without_outer_ones(needed.shape);
  return std::equal(one.begin(), one.end(), other.begin(), other.end());
}

bool same_type(const TensorText& offered, const TensorText& needed) {
  return offered.datatype == needed.datatype ||
         (offered.datatype == "BOOL" && needed.datatype == "UINT8");
}

// The bytes of a tensor of the model, whose shape has no open dimension.
size_t count_bytes(const TensorText& tensor) {
  const auto* type = oip_type(tensor.datatype);
  size_t out = type ? element_bytes(type->type) : 0;
  for (const int64_t extent : tensor.shape) out *= static_cast<size_t>(extent);
  return out;
}

Status check_raw(const InferTensor& input, const TensorText& needed, const ModelMetadata& model) {
  if (!input.raw || needed.datatype == "BYTES") return ok();
  const size_t offered = input.raw->size(), bytes = count_bytes(needed);
  if (offered == bytes) return ok();
  return mismatch(model, std::to_string(offered) + " bytes for " + describe(input),
                  std::to_string(bytes) + " bytes for " + describe(needed));
}

}  // namespace

Result<std::vector<size_t>> match_inputs(const InferRequest& request, const ModelMetadata& model) {
  std::vector<size_t> out;
  if (request.inputs.size() != model.inputs.size())
    return mismatch(model, std::to_string(request.inputs.size()) + " inputs",
                    std::to_string(model.inputs.size()) + ": " + list(model.inputs));
  for (const auto& needed : model.inputs) {
    const auto found =
        std::find_if(request.inputs.begin(), request.inputs.end(),
                     [&](const auto& offered) { return offered.name == needed.name; });
    if (found == request.inputs.end())
      return mismatch(model, "no input with the name " + needed.name, list(model.inputs));
    if (!same_type(*found, needed) || !same_shape(*found, needed))
      return mismatch(model, describe(*found), describe(needed));
    if (auto status = check_raw(*found, needed, model); !status) return status.error();
    out.push_back(static_cast<size_t>(found - request.inputs.begin()));
  }
  return out;
}

Result<std::vector<size_t>> match_outputs(const InferRequest& request, const ModelMetadata& model) {
  std::vector<size_t> out;
  for (const auto& name : request.outputs) {
    const auto found = std::find_if(model.outputs.begin(), model.outputs.end(),
                                    [&](const auto& known) { return known.name == name; });
    if (found == model.outputs.end())
      return mismatch(model, "a request for the output " + name, list(model.outputs));
    out.push_back(static_cast<size_t>(found - model.outputs.begin()));
  }
  for (size_t i = 0; request.outputs.empty() && i < model.outputs.size(); ++i) out.push_back(i);
  return out;
}

ServedRequest::ServedRequest(std::shared_ptr<ServedModel> model, std::shared_ptr<Call> call,
                             InferRequest request, std::vector<size_t> order)
    : model_(std::move(model)),
      call_(std::move(call)),
      request_(std::move(request)),
      order_(std::move(order)) {}

ServedRequest::~ServedRequest() {
  if (ended_) return;
  const char* element = last_element_;
  if (!model_->is_running())  // elements drop what they hold when they stop
    fail_as(End::Aborted, CallStatus::Unavailable, model_->stopped_text());
  else
    fail_as(
        End::Aborted, CallStatus::Aborted,
        element ? std::string("dropped by ") + element : "dropped before it entered the pipeline");
}

Status ServedRequest::read_input(size_t index, std::span<std::byte> to) const {
  return read_elements(call_->request(), request_.inputs[order_[index]], to, Sender::Client);
}

size_t ServedRequest::size_of_bytes(size_t index) const {
  const auto range = only_element(call_->request(), request_.inputs[order_[index]], Sender::Client);
  return range ? range->size() : 0;  // take() has refused others
}

void ServedRequest::copy_bytes(size_t index, std::span<std::byte> to) const {
  const auto range = only_element(call_->request(), request_.inputs[order_[index]], Sender::Client);
  if (range && range->size() == to.size()) call_->request().copy(*range, to.data());
}

bool ServedRequest::end_if_inputs_changed() {
  auto order = order_of_inputs(*call_, request_, model_->metadata());
  if (order) {
    order_ = *std::move(order);
    return false;
  }
  Error error = order.error();
  error.what =
      "the inputs of the model " + model_->model().name + " changed while the request waited";
  fail(CallStatus::InvalidArgument, error.message());
  return true;
}

bool ServedRequest::end_if_expired() {
  if (ended_) return true;
  if (!call_->expired()) return false;
  if (call_->cancelled())
    fail_as(End::Expired, CallStatus::Cancelled, "the client cancelled the call");
  else
    fail_as(End::Expired, CallStatus::DeadlineExceeded, "the deadline passed before the invoke");
  return true;
}

bool ServedRequest::respond(const std::vector<RequestTensor>& outputs,
                            const std::shared_ptr<const void>& memory) {
  ModelMetadata model{model_->model().name, "", {}, {}};
  for (const auto& output : outputs)
    model.outputs.push_back({std::string(output.name), std::string(output.datatype),
                             std::vector<int64_t>(output.shape.begin(), output.shape.end())});
  const auto chosen = match_outputs(request_, model);
  if (!chosen) return fail_as(End::Refused, CallStatus::InvalidArgument, chosen.error().message());
  std::vector<RequestTensor> sent;
  for (const size_t index : *chosen) sent.push_back(outputs[index]);
  if (ended_.exchange(true)) return false;
  model_->count(this, call_->expired() ? End::Expired : End::Answered);
  const ServerTimes measured = times();
  call_->respond(encode_infer_response(model_->model(), request_.id, sent,
                                       request_.wants_times ? &measured : nullptr),
                 memory);
  return true;
}

ServerTimes ServedRequest::times() const {
  using std::chrono::duration_cast, std::chrono::nanoseconds, std::chrono::microseconds;
  const auto now = Clock::now();
  const int64_t wall =
      duration_cast<nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
  return {.received_ns = wall - duration_cast<nanoseconds>(now - received_).count(),
          .answered_ns = wall,
          .queue_us = duration_cast<microseconds>(taken_ - received_).count(),
          .compute_us = duration_cast<microseconds>(now - pushed_).count()};
}

bool ServedRequest::fail(CallStatus status, const std::string& message) {
  return fail_as(status == CallStatus::Aborted ? End::Aborted : End::Refused, status, message);
}

bool ServedRequest::fail_as(End end, CallStatus status, const std::string& message) {
  if (ended_.exchange(true)) return false;
  model_->count(this, end);
  call_->fail(status, message);
  return true;
}

ServedModel::ServedModel(ModelRequest model, std::string platform, size_t max_waiting)
    : model_(std::move(model)), platform_(std::move(platform)), max_waiting_(max_waiting) {
  statistics_.model = model_;
}

void ServedModel::set_inputs(std::vector<TensorText> inputs) {
  {
    std::lock_guard lock(mutex_);
    inputs_ = std::move(inputs);
    knows_inputs_ = true;
  }
  notify();
}

void ServedModel::set_outputs(std::vector<TensorText> outputs) {
  {
    std::lock_guard lock(mutex_);
    outputs_ = std::move(outputs);
    knows_outputs_ = true;
  }
  notify();
}

void ServedModel::expect_outputs(std::vector<TensorText> outputs) {
  {
    std::lock_guard lock(mutex_);
    if (knows_outputs_) return;
    outputs_ = std::move(outputs);
    expects_outputs_ = true;
  }
  notify();
}

void ServedModel::set_observer(std::function<void()> observer) {
  std::lock_guard lock(mutex_);
  observer_ = std::move(observer);
}

void ServedModel::notify() const {
  std::function<void()> observer;
  {
    std::lock_guard lock(mutex_);
    observer = observer_;
  }
  if (observer) observer();
}

void ServedModel::set_loaded(bool loaded) {
  {
    std::lock_guard lock(mutex_);
    if (std::exchange(loaded_, loaded) == loaded) return;
  }
  notify();
}

bool ServedModel::is_loaded() const {
  std::lock_guard lock(mutex_);
  return loaded_;
}

bool ServedModel::ready() const {
  std::lock_guard lock(mutex_);
  return loaded_ && knows_inputs_ && (knows_outputs_ || expects_outputs_) && !stopped_;
}

ModelMetadata ServedModel::metadata() const {
  std::lock_guard lock(mutex_);
  return {model_.name, platform_, inputs_, outputs_};
}

void ServedModel::receive(std::shared_ptr<Call> call, InferRequest request) {
  const auto refuse = [&](CallStatus status, const std::string& message) {
    {
      std::lock_guard lock(mutex_);
      ++counts_.received;
      ++counts_.refused;
    }
    call->fail(status, message);
  };
  const ModelMetadata described = metadata();
  {
    std::unique_lock lock(mutex_);
    if (!knows_inputs_ || stopped_ || !loaded_) {
      const bool loaded = loaded_;
      lock.unlock();
      return refuse(CallStatus::Unavailable,
                    loaded ? "the pipeline of the model " + model_.name + " does not run"
                           : "the model " + model_.name + " is unloaded");
    }
  }
  auto order = order_of_inputs(*call, request, described);
  if (!order) return refuse(CallStatus::InvalidArgument, order.error().message());
  if (!described.outputs.empty())
    if (const auto chosen = match_outputs(request, described); !chosen)
      return refuse(CallStatus::InvalidArgument, chosen.error().message());
  auto queued = std::make_shared<ServedRequest>(shared_from_this(), std::move(call),
                                                std::move(request), *std::move(order));
  if (enqueue(queued)) return;
  queued->fail(
      CallStatus::ResourceExhausted,
      std::to_string(max_waiting_) + " requests wait for the model " + model_.name + " (queue)");
}

bool ServedModel::enqueue(const std::shared_ptr<ServedRequest>& request) {
  std::vector<std::shared_ptr<ServedRequest>> expired;
  {
    std::lock_guard lock(mutex_);
    ++counts_.received;
    ++counts_.in_flight;
    in_flight_.emplace(request.get(), request);
    if (waiting_.size() >= max_waiting_)
      std::erase_if(waiting_, [&](const auto& other) {
        const bool gone = other->call_->expired();
        if (gone) expired.push_back(other);
        return gone;
      });
    if (stopped_ || waiting_.size() >= max_waiting_) return false;
    waiting_.push_back(request);
  }
  arrived_.notify_one();
  for (const auto& other : expired) other->end_if_expired();
  return true;
}

std::shared_ptr<ServedRequest> ServedModel::next() {
  std::unique_lock lock(mutex_);
  arrived_.wait(lock, [this] { return interrupted_ || !waiting_.empty(); });
  if (interrupted_) return nullptr;
  auto out = std::move(waiting_.front());
  waiting_.pop_front();
  return out;
}

std::shared_ptr<ServedRequest> ServedModel::take() {
  for (;;) {
    auto request = next();
    if (!request) return nullptr;
    if (request->end_if_expired() || request->end_if_inputs_changed()) continue;
    request->taken_ = request->pushed_ = ServedRequest::Clock::now();
    return request;
  }
}

void ServedModel::interrupt() {
  {
    std::lock_guard lock(mutex_);
    interrupted_ = true;
  }
  arrived_.notify_all();
}

void ServedModel::resume() {
  std::lock_guard lock(mutex_);
  interrupted_ = false;
}

void ServedModel::set_running(bool running) {
  std::lock_guard lock(mutex_);
  running_ = running;
}

bool ServedModel::is_running() const {
  std::lock_guard lock(mutex_);
  return running_;
}

std::string ServedModel::stopped_text() const {
  return "the pipeline of the model " + model_.name + " was stopped";
}

void ServedModel::close() {
  std::deque<std::shared_ptr<ServedRequest>> waiting;
  {
    std::lock_guard lock(mutex_);
    stopped_ = true;
    waiting.swap(waiting_);
  }
  notify();
  end_as_stopped(waiting);
}

void ServedModel::stop() {
  close();
  interrupt();
  std::deque<std::shared_ptr<ServedRequest>> taken;
  {
    std::lock_guard lock(mutex_);
    for (const auto& [key, weak] : in_flight_)
      if (auto request = weak.lock()) taken.push_back(std::move(request));
  }
  end_as_stopped(taken);
}

void ServedModel::end_as_stopped(const std::deque<std::shared_ptr<ServedRequest>>& requests) const {
  for (const auto& request : requests)
    request->fail_as(ServedRequest::End::Aborted, CallStatus::Unavailable, stopped_text());
}

void ServedModel::count(ServedRequest* request, ServedRequest::End end) {
  const auto now = ServedRequest::Clock::now();
  std::lock_guard lock(mutex_);
  in_flight_.erase(request);
  --counts_.in_flight;
  if (end != ServedRequest::End::Answered) {
    ++(end == ServedRequest::End::Refused   ? counts_.refused
       : end == ServedRequest::End::Expired ? counts_.expired
                                            : counts_.aborted);
    add(&statistics_.fail, now - request->received_);
    return;
  }
  ++counts_.answered;
  ++statistics_.inferences;
  ++statistics_.executions;
  statistics_.last_inference_ms =
      static_cast<uint64_t>(std::chrono::duration_cast<std::chrono::milliseconds>(
                                std::chrono::system_clock::now().time_since_epoch())
                                .count());
  add(&statistics_.success, now - request->received_);
  add(&statistics_.queue, request->taken_ - request->received_);
  add(&statistics_.compute_input, request->pushed_ - request->taken_);
  add(&statistics_.compute_infer, now - request->pushed_);
  add(&statistics_.compute_output, {});
}

ServedCounts ServedModel::counts() const {
  std::lock_guard lock(mutex_);
  return counts_;
}

ModelStatistics ServedModel::statistics() const {
  std::lock_guard lock(mutex_);
  return statistics_;
}

}  // namespace weir::net
