// The C API of models: checks pointers and sizes and calls core/direct.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "weir/model.h"

#include <cstring>
#include <memory>
#include <vector>

#include "core/direct/direct_model.hpp"
#include "core/text/text.hpp"
#include "guard.hpp"

struct weir_loaded_model {
  std::unique_ptr<weir::direct::DirectModel> model;
};
struct weir_results {
  weir::direct::Results results;
};

namespace {

using namespace weir;
using library::guarded;
using library::keep;
using library::null_pointer;
using Limit = direct::DirectModel::Limit;

template <class T>
std::span<T> list(T* first, uint32_t count) {
  return {first, first ? count : 0};
}

// A copy of the members that are entirely within struct_size; the others are 0, as abi.h requires.
Result<weir_model_options> complete(const weir_model_options& given) {
  constexpr size_t kEnds[] = {
      offsetof(weir_model_options, engine),
      offsetof(weir_model_options, accelerator),
      offsetof(weir_model_options, options),
      offsetof(weir_model_options, n_options),
      offsetof(weir_model_options, threads),
      offsetof(weir_model_options, timeout_ns),
      offsetof(weir_model_options, declared),
      offsetof(weir_model_options, n_declared),
      offsetof(weir_model_options, n_declared) + sizeof given.n_declared,
  };
  size_t bytes = 0;
  for (const size_t end : kEnds)
    if (end <= given.struct_size) bytes = end;
  if (bytes == 0)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "weir_model_options has no struct_size",
                 .offered = std::to_string(given.struct_size),
                 .needed = "at least " + std::to_string(kEnds[0]) + " bytes",
                 .fix = "weir_model_options options = WEIR_MODEL_OPTIONS_INIT;"};
  weir_model_options out{};
  std::memcpy(&out, &given, bytes);
  return out;
}

Result<std::unique_ptr<direct::DirectModel>> open(const weir_model_options& given) {
  const auto options = complete(given);
  if (!options) return options.error();
  infer::OpenOptions request;
  for (const char* path : list(options->paths, options->n_paths)) {
    if (!path) return null_pointer("a path");
    request.paths.emplace_back(path);
  }
  for (const auto& option : list(options->options, options->n_options)) {
    if (!option.key) return null_pointer("the key of an option");
    request.options.emplace_back(option.key, or_empty(option.value));
  }
  for (const auto& option : list(options->declared, options->n_declared)) {
    if (!option.key) return null_pointer("the key of an option");
    request.declared.emplace_back(option.key, or_empty(option.value));
  }
  request.accelerator = or_empty(options->accelerator);
  request.threads = options->threads;
  const auto engine = direct::engine_for(or_empty(options->engine), request.paths);
  if (!engine) return engine.error();
  auto model = direct::DirectModel::open(**engine, request);
  if (model && options->timeout_ns > 0) (*model)->set_limit(Limit(options->timeout_ns));
  return model;
}

int describe(const std::vector<weir_tensor_info>& infos, uint32_t index, weir_tensor_info* info) {
  if (!info || index >= infos.size()) return -WEIR_OPTION_VALUE;
  *info = infos[index];
  return WEIR_OK;
}

int hand_over(Result<direct::DirectModel::Outcome> outcome, weir_results** results,
              weir_error** error) {
  if (!outcome) return keep(error, outcome.error());
  if (outcome->dropped) return 1;
  *results = std::make_unique<weir_results>(weir_results{std::move(outcome->results)}).release();
  return WEIR_OK;
}

}  // namespace

int weir_model_open(const weir_model_options* options, weir_loaded_model** model,
                    weir_error** error) {
  return guarded(error, [&] {
    if (!options || !model) return keep(error, null_pointer("options or model"));
    *model = nullptr;
    auto opened = open(*options);
    if (!opened) return keep(error, opened.error());
    *model = std::make_unique<weir_loaded_model>(weir_loaded_model{*std::move(opened)}).release();
    return static_cast<int>(WEIR_OK);
  });
}

void weir_model_close(weir_loaded_model* model) {
  delete model;
}

const char* weir_model_engine(const weir_loaded_model* model) {
  return model ? model->model->model().engine().name : "";
}

const char* weir_model_engine_version(const weir_loaded_model* model) {
  const char* version = model ? model->model->model().engine().version : nullptr;
  return version ? version : "";
}

const char* weir_model_metadata(const weir_loaded_model* model) {
  return model ? model->model->model().info().metadata_json : nullptr;
}

uint32_t weir_model_input_count(const weir_loaded_model* model) {
  return model ? static_cast<uint32_t>(model->model->model().inputs().size()) : 0;
}

uint32_t weir_model_output_count(const weir_loaded_model* model) {
  return model ? static_cast<uint32_t>(model->model->model().outputs().size()) : 0;
}

int weir_model_input(const weir_loaded_model* model, uint32_t index, weir_tensor_info* info) {
  if (!model) return -WEIR_OPTION_VALUE;
  return guarded(nullptr, [&] { return describe(model->model->inputs(), index, info); });
}

int weir_model_output(const weir_loaded_model* model, uint32_t index, weir_tensor_info* info) {
  if (!model) return -WEIR_OPTION_VALUE;
  return guarded(nullptr, [&] { return describe(model->model->outputs(), index, info); });
}

int weir_model_reshape(weir_loaded_model* model, const weir_tensor_info* inputs, uint32_t n_inputs,
                       weir_error** error) {
  return guarded(error, [&] {
    if (!model) return keep(error, null_pointer("model"));
    const auto wanted = list(inputs, n_inputs);
    const auto status = model->model->reshape({wanted.begin(), wanted.end()});
    return status ? static_cast<int>(WEIR_OK) : keep(error, status.error());
  });
}

void weir_model_set_timeout(weir_loaded_model* model, int64_t timeout_ns) {
  if (model) model->model->set_limit(Limit(timeout_ns > 0 ? timeout_ns : 0));
}

int weir_model_invoke(weir_loaded_model* model, const weir_tensor* inputs, uint32_t n_inputs,
                      weir_results** results, weir_error** error) {
  return guarded(error, [&] {
    if (!model || !results) return keep(error, null_pointer("model or results"));
    *results = nullptr;
    return hand_over(model->model->invoke(list(inputs, n_inputs)), results, error);
  });
}

int weir_model_invoke_into(weir_loaded_model* model, const weir_tensor* inputs, uint32_t n_inputs,
                           weir_tensor* outputs, uint32_t n_outputs, weir_error** error) {
  return guarded(error, [&] {
    if (!model || (!outputs && n_outputs > 0)) return keep(error, null_pointer("model or outputs"));
    auto outcome = model->model->invoke(list(inputs, n_inputs), list(outputs, n_outputs));
    if (!outcome) return keep(error, outcome.error());
    return outcome->dropped ? 1 : 0;
  });
}

int weir_model_invoke_batch(weir_loaded_model* model, const weir_tensor* inputs, uint32_t n_inputs,
                            uint32_t n_frames, weir_results** results, weir_error** error) {
  return guarded(error, [&] {
    if (!model || !results) return keep(error, null_pointer("model or results"));
    *results = nullptr;
    return hand_over(model->model->invoke_batch(list(inputs, n_inputs), n_frames), results, error);
  });
}

uint32_t weir_results_count(const weir_results* results) {
  return results ? static_cast<uint32_t>(results->results.tensors().size()) : 0;
}

uint32_t weir_results_frames(const weir_results* results) {
  return results ? results->results.frames() : 0;
}

int weir_results_tensor(const weir_results* results, uint32_t index, weir_tensor* tensor) {
  if (!tensor || index >= weir_results_count(results)) return -WEIR_OPTION_VALUE;
  *tensor = results->results.tensors()[index];
  tensor->release = nullptr;
  tensor->owner = nullptr;
  return WEIR_OK;
}

int weir_results_frame_tensor(const weir_results* results, uint32_t frame, uint32_t index,
                              weir_tensor* tensor) {
  if (!tensor || index >= weir_results_count(results) || frame >= weir_results_frames(results))
    return -WEIR_OPTION_VALUE;
  *tensor = results->results.of_frame(frame, index);
  return WEIR_OK;
}

void weir_results_free(weir_results* results) {
  delete results;
}
