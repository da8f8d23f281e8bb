// A test engine for shared and replaced models: y = x + the number in the model's file.
//
// A model file contains "ADD WIDTH": float32 [-1, WIDTH] in and out; the WIDTH 0 leaves type and
// shape open. `rules` configures the engine's limits; `seen` counts its calls.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/filter/model_fit.hpp"
#include "core/infer/model/model.hpp"
#include "weir/abi.h"

namespace weir::infer::sum_engine {

struct SumModel {
  float add = 0;
  weir_tensor_info tensor{};
};
struct SumSession {
  const SumModel* model = nullptr;
  std::atomic<bool> busy{false};
  bool asleep = false;
};
inline SumModel* of(weir_model* model) {
  return reinterpret_cast<SumModel*>(model);
}
inline SumSession* of(weir_session* session) {
  return reinterpret_cast<SumSession*>(session);
}

// A tensor description, rows first.
inline ModelTensor floats(int64_t rows, int64_t columns) {
  ModelTensor shape;
  shape.type = ElementType::Float32;
  shape.rank_known = true;
  shape.shape = {rows, columns};
  return shape;
}

struct Rules {
  uint32_t flags = 0, max_sessions = 0;
  bool can_sleep = false, has_control = true;
  int refused_add = -1;  // the model whose invokes fail
};
struct Seen {
  std::atomic<int> opened{0}, closed{0}, sessions{0}, freed{0}, warmed{0}, slept{0}, woken{0};
  std::atomic<int> working{0}, max_working{0}, clashes{0};
  std::atomic<int> open_models{0}, open_sessions{0};
};
inline Rules rules;
inline Seen seen;

inline weir_engine make_engine() {
  weir_engine e{};
  e.struct_size = sizeof e;
  e.abi_major = WEIR_ABI_MAJOR;
  e.name = "sum";
  e.open = [](const weir_open* request, weir_model** out, weir_error*) {
    auto model = std::make_unique<SumModel>();
    std::ifstream file(request->paths[0]);
    int width = 0;
    if (!(file >> model->add >> width)) return -WEIR_MODEL_INVALID;
    model->tensor.type = WEIR_FLOAT32;
    model->tensor.rank = 2;
    model->tensor.shape[0] = -1;
    model->tensor.shape[1] = width;
    model->tensor.name = "x";
    if (width == 0) model->tensor.type = WEIR_TYPE_END;
    if (width == 0) model->tensor.rank = WEIR_RANK_UNKNOWN;
    *out = reinterpret_cast<weir_model*>(model.release());
    ++seen.opened, ++seen.open_models;
    return +WEIR_OK;
  };
  e.close = [](weir_model* model) {
    ++seen.closed, --seen.open_models;
    delete of(model);
  };
  e.info = [](weir_model* model, weir_model_info* out, weir_error*) {
    out->n_inputs = out->n_outputs = 1;
    out->inputs = out->outputs = &of(model)->tensor;
    out->flags = rules.flags;
    out->max_sessions = rules.max_sessions;
    out->weight_bytes = 1000;
    return +WEIR_OK;
  };
  e.session_new = [](weir_model* model, const weir_option*, uint32_t, weir_session** out,
                     weir_error*) {
    auto session = std::make_unique<SumSession>();
    session->model = of(model);
    *out = reinterpret_cast<weir_session*>(session.release());
    ++seen.sessions, ++seen.open_sessions;
    return +WEIR_OK;
  };
  e.session_free = [](weir_session* session) {
    ++seen.freed, --seen.open_sessions;
    delete of(session);
  };
  e.resolve = [](weir_session*, const weir_tensor_info* in, uint32_t, weir_tensor_info* out,
                 uint32_t, weir_error*) {
    if (out->rank == WEIR_RANK_UNKNOWN) *out = *in;
    out->shape[0] = in->shape[0];
    return +WEIR_OK;
  };
  e.invoke = [](weir_session* handle, const weir_frame* in, weir_frame* out, weir_error*) {
    SumSession* session = of(handle);
    if (session->busy.exchange(true)) ++seen.clashes;
    const int working = ++seen.working;
    for (int max = seen.max_working; max < working;)
      if (seen.max_working.compare_exchange_weak(max, working)) break;
    const auto* x = static_cast<const float*>(in->tensors[0].data);
    auto* y = static_cast<float*>(out->tensors[0].data);
    const size_t n = in->tensors[0].bytes / sizeof *x;
    if (session->asleep) ++seen.clashes;
    for (size_t i = 0; i < n; ++i) y[i] = x[i] + session->model->add;
    --seen.working;
    session->busy = false;
    return static_cast<int>(session->model->add) == rules.refused_add ? -WEIR_INVOKE_FAILED
                                                                      : +WEIR_OK;
  };
  if (rules.has_control)
    e.control = [](weir_session* session, int op, const weir_option*, weir_error*) {
      if (op == WEIR_SUSPEND && rules.can_sleep) {
        of(session)->asleep = true;
        ++seen.slept;
        return +WEIR_OK;
      }
      if (op == WEIR_RESUME && rules.can_sleep) {
        of(session)->asleep = false;
        ++seen.woken;
        return +WEIR_OK;
      }
      return -WEIR_MODEL_UNSUPPORTED;
    };
  return e;
}

// A temporary folder of model files.
class Files {
 public:
  Files()
      : folder_(std::filesystem::temp_directory_path() /
                ("weir-sum-" +
                 std::to_string(std::hash<std::thread::id>{}(std::this_thread::get_id())) + "-" +
                 std::to_string(reinterpret_cast<uintptr_t>(this)))) {
    std::filesystem::create_directories(folder_);
  }
  ~Files() { std::filesystem::remove_all(folder_); }
  std::string write(const std::string& name, const std::string& text) const {
    const auto path = folder_ / name;
    std::ofstream(path) << text;
    return path.string();
  }

 private:
  std::filesystem::path folder_;
};

}  // namespace weir::infer::sum_engine
