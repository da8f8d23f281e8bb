// Test support for asynchronous requests: an engine whose requests the test ends, a recording
// receiver, outputs that count their releases.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/infer/model/model.hpp"
#include "core/infer/module/async_request.hpp"
#include "core/infer/module/engine_objects_test_support.hpp"
#include "core/infer/module/host.hpp"

namespace weir::infer::async_test {

inline weir_model the_model{};
inline weir_session the_session{};
inline std::vector<weir_request*> submitted, cancelled;
inline std::function<int(weir_request*, weir_error*)> on_submit;
inline bool freed;
inline uint32_t max_in_flight, flags;

inline weir_engine make_engine() {
  weir_engine e{};
  e.struct_size = sizeof e;
  e.name = "test";
  e.open = [](const weir_open*, weir_model** out, weir_error*) {
    *out = &the_model;
    return 0;
  };
  e.close = [](weir_model*) {};
  e.info = [](weir_model*, weir_model_info* out, weir_error*) {
    out->flags = flags;
    out->max_in_flight = max_in_flight;
    return 0;
  };
  e.session_new = [](weir_model*, const weir_option*, uint32_t, weir_session** out, weir_error*) {
    *out = &the_session;
    return 0;
  };
  e.session_free = [](weir_session*) { freed = true; };
  e.invoke = [](weir_session*, const weir_frame*, weir_frame*, weir_error*) { return 0; };
  e.submit = [](weir_session*, const weir_frame*, weir_request* request, weir_error* error) {
    submitted.push_back(request);
    return on_submit ? on_submit(request, error) : 0;
  };
  e.cancel = [](weir_session*, weir_request* request) { cancelled.push_back(request); };
  return e;
}

// The calls of a receiver: the number in each output, then how the request ended.
struct Received {
  std::vector<int> outputs;
  std::vector<std::string> ends;
};
class Receiver final : public RequestReceiver {
 public:
  explicit Receiver(Received* received, bool takes_over = false)
      : received_(received), takes_over_(takes_over) {}
  void output(weir_frame& frame) noexcept override {
    received_->outputs.push_back(*static_cast<int*>(frame.tensors[0].data));
    if (takes_over_) frame.tensors[0].release = nullptr;
  }
  void end(const Result<int>& ended) noexcept override {
    const std::string reason = ended && *ended > 0 ? std::to_string(*ended) : "";
    received_->ends.push_back(ended ? reason : ended.error().message());
  }

 private:
  Received* received_;
  bool takes_over_;
};

// A frame of one tensor whose memory counts its releases.
struct Output {
  explicit Output(int number) : value(number) {
    tensor.data = &value;
    tensor.bytes = sizeof value;
    tensor.owner = this;
    tensor.release = [](void* owner) { ++static_cast<Output*>(owner)->released; };
    frame.struct_size = sizeof frame;
    frame.n_tensors = 1;
    frame.tensors = &tensor;
  }
  Output(const Output&) = delete;
  int value, released = 0;
  weir_tensor tensor{};
  weir_frame frame{};
};

class AsyncRequest : public ::testing::Test {
 protected:
  void SetUp() override {
    submitted.clear();
    cancelled.clear();
    on_submit = nullptr;
    freed = false;
    max_in_flight = 2;
    flags = WEIR_MODEL_ASYNC;
  }
  std::unique_ptr<Session> open() { return *Session::create(*Model::open(engine_, {})); }
  Result<bool> submit(Session& session, Received* received, bool takes_over = false) {
    auto receiver = std::make_shared<Receiver>(received, takes_over);
    last_ = receiver;
    return session.submit(in_, std::move(receiver));
  }
  static void complete(weir_request* request, Output* output, bool more, int status = 0) {
    host().complete(request, status, output ? &output->frame : nullptr, more);
  }

  weir_engine engine_ = make_engine();
  weir_frame in_{};
  std::weak_ptr<RequestReceiver> last_;
};

}  // namespace weir::infer::async_test
