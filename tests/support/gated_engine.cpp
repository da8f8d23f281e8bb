// An engine for tests: y = x + 1 on float32 [-1, 4], once the gate releases the frame. Options:
// max-sessions:N, thread-safe, stateful; fail:V and drop:V for the frame whose first value is V;
// takes:US microseconds per invoke, without the gate.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string_view>
#include <thread>

#include "gate.hpp"
#include "weir/abi.h"

struct weir_model {
  weir_tensor_info input{}, output{};
  weir_model_info info{};
  float fail = NAN, drop = NAN;  // equal to no value
  std::chrono::microseconds takes{0};
};
struct weir_session {
  weir_model* model;
  int invokes = 0;  // concurrent; guarded by the gate
};

namespace {

using weir::test::Gate;

const weir_host* host;

int open_model(const weir_open* request, weir_model** out, weir_error*) {
  auto model = std::make_unique<weir_model>();
  for (uint32_t i = 0; i < request->n_options; ++i) {
    const std::string_view key = request->options[i].key;
    const char* value = request->options[i].value;
    if (key == "max-sessions") model->info.max_sessions = static_cast<uint32_t>(std::atoi(value));
    if (key == "thread-safe") model->info.flags |= WEIR_MODEL_THREAD_SAFE;
    if (key == "stateful") model->info.flags |= WEIR_MODEL_STATEFUL;
    if (key == "fail") model->fail = std::strtof(value, nullptr);
    if (key == "takes") model->takes = std::chrono::microseconds(std::atoi(value));
    if (key == "drop") model->drop = std::strtof(value, nullptr);
  }
  model->input.type = WEIR_FLOAT32;
  model->input.rank = 2;
  model->input.shape[0] = -1;
  model->input.shape[1] = 4;
  model->input.name = "x";
  model->input.batch_axis = WEIR_NO_BATCH_AXIS;
  model->output = model->input;
  model->output.name = "y";
  Gate::of_process().opened(request->threads);
  *out = model.release();
  return WEIR_OK;
}

void close_model(weir_model* model) {
  Gate::of_process().closed();
  delete model;
}

int info(weir_model* model, weir_model_info* out, weir_error*) {
  *out = model->info;
  out->struct_size = sizeof *out;
  out->n_inputs = out->n_outputs = 1;
  out->inputs = &model->input;
  out->outputs = &model->output;
  return WEIR_OK;
}

int session_new(weir_model* model, const weir_option*, uint32_t, weir_session** out, weir_error*) {
  *out = new weir_session{model};
  Gate::of_process().session(1);
  return WEIR_OK;
}
void session_free(weir_session* session) {
  Gate::of_process().session(-1);
  delete session;
}

int resolve(weir_session*, const weir_tensor_info* in, uint32_t, weir_tensor_info* out, uint32_t,
            weir_error*) {
  out->shape[0] = in->shape[0];
  return WEIR_OK;
}

int invoke(weir_session* session, const weir_frame* in, weir_frame* out, weir_error* error) {
  const auto* x = static_cast<const float*>(in->tensors[0].data);
  auto* y = static_cast<float*>(out->tensors[0].data);
  if (session->model->takes.count() > 0)
    std::this_thread::sleep_for(session->model->takes);
  else
    Gate::of_process().enter(x[0], &session->invokes);
  if (x[0] == session->model->fail)
    return host->fail(error, WEIR_INVOKE_FAILED, "ordered to fail", nullptr, nullptr, nullptr,
                      nullptr);
  if (x[0] == session->model->drop) return 1;
  for (uint64_t i = 0; i < in->tensors[0].bytes / sizeof *x; ++i) y[i] = x[i] + 1;
  return WEIR_OK;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) const weir_module* weir_module_entry(
    const weir_host* given) {
  host = given;
  static weir_engine engine{};
  engine.struct_size = sizeof engine;
  engine.abi_major = WEIR_ABI_MAJOR;
  engine.abi_minor = WEIR_ABI_MINOR;
  engine.name = "gated";
  engine.version = "1";
  engine.open = open_model;
  engine.close = close_model;
  engine.info = info;
  engine.session_new = session_new;
  engine.session_free = session_free;
  engine.resolve = resolve;
  engine.invoke = invoke;
  static const weir_engine* const engines[] = {&engine, nullptr};
  static weir_module module{};
  module.struct_size = sizeof module;
  module.abi_major = WEIR_ABI_MAJOR;
  module.abi_minor = WEIR_ABI_MINOR;
  module.engines = engines;
  return &module;
}
