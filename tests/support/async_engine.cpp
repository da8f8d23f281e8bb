// An engine for tests that answers on its own thread, with outputs of any size.
//
// Input: float32 [-1, 4]. Output k of a frame is x + k, float32 [1, 4]; submit() produces `outputs`
// of them. Options:
//   outputs:N        number of outputs; without it, the first value of the frame
//   in-flight:N      the model's declared limit; a frame beyond it is an error
//   reverse:N        waits for N frames and answers the newest first
//   until-cancelled  answers when it is cancelled, with an output
//   never            never answers, not even to cancel()
//   inline           answers within submit()
//   fail-at:N        that frame fails after its first output
//   refuse-at:N      submit() of that frame fails
//   outcomes         frames of -1, -2 and -3 end as late, refused and lost
//   dynamic          output k has k + 1 rows of x + k; invoke() produces as many rows of x as the
//                    first value of the frame
//   empty            an output has no elements
//   wrong-size       the memory of an output is shorter than its shape
//   other-shape      outputs have two rows, which was never declared
//   no-memory        outputs without memory
//   synchronous      a model without the flag for asynchronous outputs
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "weir/abi.h"
#include "weir/module.hpp"

struct weir_model {
  std::map<std::string, long> options;
  weir_tensor_info input{}, output{};
  bool has(const char* name) const { return options.count(name) > 0; }
  long value(const char* name, long other) const {
    const auto at = options.find(name);
    return at == options.end() ? other : at->second;
  }
};

namespace async_engine {

struct Work {
  weir_request* request;
  const weir_frame* frame;
  long number;
};

struct OneOutput {
  weir_tensor tensor{};
  weir_frame frame{};
};

}  // namespace async_engine

using async_engine::OneOutput;
using async_engine::Work;
using weir::module_host;

struct weir_session {
  explicit weir_session(weir_model* given) : model(given) {}
  weir_model* model;
  std::mutex mutex;  // guards the rest
  std::condition_variable changed;
  std::deque<Work> waiting;
  std::vector<weir_request*> cancelled;
  long frames = 0, in_flight = 0, invokes = 0;
  bool stops = false;
  std::thread thread;  // last, because it uses the other members
};

namespace {

void describe(weir_tensor_info* info, const char* name, int64_t rows) {
  info->type = WEIR_FLOAT32;
  info->rank = 2;
  info->shape[0] = rows;
  info->shape[1] = 4;
  info->name = name;
  info->batch_axis = WEIR_NO_BATCH_AXIS;
}

// Allocates host memory with `rows` rows of x + k.
int fill(const weir_model& model, const float* x, long k, int64_t rows, weir_tensor* out) {
  const uint64_t bytes = static_cast<uint64_t>(rows) * 4 * sizeof(float);
  describe(&out->info, "y", rows);
  if (model.has("no-memory")) {
    out->bytes = bytes;
    return WEIR_OK;
  }
  if (const int result = module_host->allocate(nullptr, WEIR_MEMORY_HOST, bytes, 64, out))
    return result;
  auto* y = static_cast<float*>(out->data);
  for (int64_t i = 0; i < rows * 4; ++i) y[i] = x[i % 4] + static_cast<float>(k);
  if (model.has("wrong-size")) out->bytes -= 1;
  if (model.has("empty")) out->info.shape[0] = 0, out->bytes = 0;
  return WEIR_OK;
}

// How a frame of this first value ends.
int find_result(const weir_model& model, float x) {
  if (!model.has("outcomes")) return WEIR_OK;
  if (x == -1) return WEIR_RESULT_LATE;
  if (x == -2) return WEIR_RESULT_REFUSED;
  return x == -3 ? int{WEIR_RESULT_LOST} : WEIR_OK;
}

void finish(weir_session* session, const Work& work) {
  const auto& model = *session->model;
  const auto* x = static_cast<const float*>(work.frame->tensors[0].data);
  const int end = find_result(model, x[0]);
  const long count = model.value("outputs", static_cast<long>(x[0]));
  for (long k = 0; k < count; ++k) {
    OneOutput output;
    output.frame = *work.frame;
    output.frame.n_tensors = 1;
    output.frame.tensors = &output.tensor;
    const int64_t rows = model.has("dynamic") ? k + 1 : model.has("other-shape") ? 2 : 1;
    fill(model, x, k, rows, &output.tensor);
    module_host->complete(work.request, WEIR_OK, &output.frame, 1);
    if (work.number == model.value("fail-at", -1)) break;
  }
  {
    std::lock_guard lock(session->mutex);
    --session->in_flight;
  }
  const bool fails = work.number == model.value("fail-at", -1);
  module_host->complete(work.request, fails ? -WEIR_INVOKE_FAILED : end, nullptr, 0);
}

// Called with the lock held. Takes the next frame to answer, if any.
bool take(weir_session* session, Work* work) {
  auto& waiting = session->waiting;
  const auto& model = *session->model;
  if (waiting.empty() || model.has("never")) return false;
  if (model.has("until-cancelled")) {
    const auto at = std::find_if(waiting.begin(), waiting.end(), [&](const Work& w) {
      const auto& list = session->cancelled;
      return std::find(list.begin(), list.end(), w.request) != list.end();
    });
    if (at == waiting.end()) return false;
    *work = *at;
    waiting.erase(at);
    return true;
  }
  const auto together = static_cast<size_t>(model.value("reverse", 1));
  // Finishes what it has begun: waits for a full queue once, then empties it.
  static thread_local size_t left = 0;
  if (left == 0 && waiting.size() < together) return false;
  if (left == 0) left = together;
  --left;
  if (together > 1) {
    *work = waiting[left];
    waiting.erase(waiting.begin() + static_cast<std::ptrdiff_t>(left));
  } else {
    *work = waiting.front();
    waiting.pop_front();
  }
  return true;
}

void run(weir_session* session) {
  for (;;) {
    Work work{};
    {
      std::unique_lock lock(session->mutex);
      bool taken = false;
      session->changed.wait(lock, [&] {
        taken = !session->stops && take(session, &work);
        return session->stops || taken;
      });
      if (!taken) return;
    }
    finish(session, work);
  }
}

int open_model(const weir_open* request, weir_model** out, weir_error* error) {
  return weir::guarded(error, [&] {
    auto model = std::make_unique<weir_model>();
    for (uint32_t i = 0; i < request->n_options; ++i)
      model->options[request->options[i].key] = std::strtol(request->options[i].value, nullptr, 10);
    describe(&model->input, "x", -1);
    describe(&model->output, "y", model->has("dynamic") ? -1 : 1);
    *out = model.release();
    return WEIR_OK;
  });
}
void close_model(weir_model* model) {
  delete model;
}
int info(weir_model* model, weir_model_info* out, weir_error*) {
  out->n_inputs = out->n_outputs = 1;
  out->inputs = &model->input;
  out->outputs = &model->output;
  out->flags = WEIR_MODEL_CANCELS;
  if (!model->has("synchronous")) out->flags |= WEIR_MODEL_ASYNC;
  if (model->has("dynamic")) out->flags |= WEIR_MODEL_DYNAMIC_OUTPUT | WEIR_MODEL_ALLOCATES_OUTPUT;
  out->max_in_flight = static_cast<uint32_t>(model->value("in-flight", 1));
  return WEIR_OK;
}
int session_new(weir_model* model, const weir_option*, uint32_t, weir_session** out,
                weir_error* error) {
  return weir::guarded(error, [&] {
    auto session = std::make_unique<weir_session>(model);
    session->thread = std::thread(run, session.get());
    *out = session.release();
    return WEIR_OK;
  });
}
void session_free(weir_session* session) {
  {
    std::lock_guard lock(session->mutex);
    session->stops = true;
    session->changed.notify_all();
  }
  session->thread.join();
  delete session;
}

int invoke(weir_session* session, const weir_frame* in, weir_frame* out, weir_error* error) {
  const auto* x = static_cast<const float*>(in->tensors[0].data);
  const auto& model = *session->model;
  weir_tensor* y = &out->tensors[0];
  if (model.has("dynamic")) return fill(model, x, 0, static_cast<int64_t>(x[0]), y);
  if (model.has("other-shape")) {
    describe(&y->info, "y", 2);
    return WEIR_OK;
  }
  if (y->bytes != 4 * sizeof(float) || !y->data)
    return module_host->fail(error, WEIR_INVOKE_FAILED, "no memory to write to", nullptr, nullptr,
                             nullptr, nullptr);
  std::memcpy(y->data, x, y->bytes);
  return WEIR_OK;
}

int submit(weir_session* session, const weir_frame* in, weir_request* request, weir_error* error) {
  const auto& model = *session->model;
  Work work{request, in, 0};
  {
    std::lock_guard lock(session->mutex);
    work.number = session->frames++;
    if (work.number == model.value("refuse-at", -1))
      return module_host->fail(error, WEIR_INVOKE_FAILED, "ordered to refuse", nullptr, nullptr,
                               nullptr, nullptr);
    if (++session->in_flight > model.value("in-flight", 1))
      return module_host->fail(error, WEIR_INVOKE_FAILED, "more in flight than allowed", nullptr,
                               nullptr, nullptr, nullptr);
    if (!model.has("inline")) {
      session->waiting.push_back(work);
      session->changed.notify_all();
      return WEIR_OK;
    }
  }
  finish(session, work);
  return WEIR_OK;
}
void cancel(weir_session* session, weir_request* request) {
  std::lock_guard lock(session->mutex);
  session->cancelled.push_back(request);
  session->changed.notify_all();
}

weir_engine make_table() {
  weir_engine table{};
  table.struct_size = sizeof table;
  table.abi_major = WEIR_ABI_MAJOR;
  table.abi_minor = WEIR_ABI_MINOR;
  table.name = "fake-async";
  table.version = "1";
  table.open = open_model;
  table.close = close_model;
  table.info = info;
  table.session_new = session_new;
  table.session_free = session_free;
  table.invoke = invoke;
  table.submit = submit;
  table.cancel = cancel;
  return table;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) const weir_module* weir_module_entry(
    const weir_host* host) {
  if (!weir::accept_host(host)) return nullptr;
  static const weir_engine table = make_table();
  static const weir_engine* const tables[] = {&table, nullptr};
  static const weir_module module{sizeof(weir_module),
                                  WEIR_ABI_MAJOR,
                                  WEIR_ABI_MINOR,
                                  tables,
                                  nullptr,
                                  nullptr,
                                  nullptr,
                                  nullptr};
  return &module;
}
