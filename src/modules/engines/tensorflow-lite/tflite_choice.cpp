// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tensorflow-lite/tflite_choice.hpp"

#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "lowering/lowered_model_info.hpp"
#include "lowering/lowering.hpp"
#include "model_bytes.hpp"
#include "tflite-file/tflite_file.hpp"
#include "weir/abi.h"
#include "weir/engine_tools.hpp"

namespace weir::engine {
namespace {

const weir_engine* own_engine = nullptr;  // set by choosing_table

struct ChosenModel {
  const weir_engine* engine = nullptr;
  weir_model* model = nullptr;
  bool lowered = false;
  std::vector<weir_tensor_info> inputs, outputs;  // of a lowered model, with their quantisation
  std::vector<PortQuantization> input_scales, output_scales;
  std::string metadata;
  std::string
      stays;  // the reason why a model stays with TensorFlow Lite although lowering was requested

  ChosenModel() = default;
  ChosenModel(const ChosenModel&) = delete;
  ChosenModel& operator=(const ChosenModel&) = delete;
  ~ChosenModel() {
    if (model) engine->close(model);
  }
};

struct ChosenSession {
  const weir_engine* engine;
  weir_session* session;
};

ChosenModel& of(weir_model* model) {
  return *reinterpret_cast<ChosenModel*>(model);
}
ChosenSession& of(weir_session* session) {
  return *reinterpret_cast<ChosenSession*>(session);
}

// ONNX Runtime must not requantise what the lowered graph computes in floats.
constexpr weir_option kAsWritten{"session.disable_quant_qdq", "1"};

struct LoweringChoice {
  bool wanted = false;
  std::vector<weir_option> others;  // options for the other engine
};

Result<LoweringChoice> lowering_choice(const weir_open& request) {
  LoweringChoice out;
  out.others.push_back(kAsWritten);
  for (uint32_t i = 0; request.options && i < request.n_options; ++i) {
    const auto key = text_or_empty(request.options[i].key);
    const auto value = text_or_empty(request.options[i].value);
    if (equals_ignoring_case(key, "Delegate")) continue;
    if (!equals_ignoring_case(key, "Lowering")) {
      out.others.push_back(request.options[i]);
      continue;
    }
    out.wanted = equals_ignoring_case(value, "onnxruntime");
    if (!out.wanted && !equals_ignoring_case(value, "None"))
      return bad_option("Lowering", value, "onnxruntime or None", "onnxruntime");
  }
  return out;
}

std::string with_reason(const char* metadata, const std::string& why) {
  auto out = nlohmann::json::parse(text_or_empty(metadata), nullptr, false);
  if (!out.is_object()) out = nlohmann::json::object();
  out["lowering"] = "none: " + why;
  return out.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

int open_own(const weir_open& request, ChosenModel* out, weir_error* error) {
  out->engine = own_engine;
  return own_engine->open(&request, &out->model, error);
}

int open_instead(const weir_open& request, const std::string& model, const std::string& why,
                 ChosenModel* out, weir_error* error) {
  log(WEIR_LOG_WARNING,
      "Lowering:onnxruntime: " + model + ": " + why + "; TensorFlow Lite runs it");
  out->stays = why;
  return open_own(request, out, error);
}

int open_lowered(const weir_open& request, const LoweringChoice& choice, ChosenModel* out,
                 weir_error* error) {
  const auto* finder =
      static_cast<const weir_engine_finder*>(module_host->extension(WEIR_FIND_ENGINE));
  if (!finder)
    return fail(error, {.code = Code::ENGINE_NOT_INSTALLED,
                        .what = "this version of Weir does not let an engine use another one",
                        .offered = "Lowering:onnxruntime",
                        .needed = "a newer Weir",
                        .fix = "custom=Lowering:None"});
  const auto file = read_model(request, {.check_head = check_tflite_head});
  if (!file) return fail(error, file.error());
  const weir_engine* other = nullptr;
  if (const int found = finder->find("onnxruntime", &other, error); found < 0) return found;
  auto lowered = lower_tflite(file->bytes);
  if (!lowered && lowered.error().code == Code::MODEL_UNSUPPORTED) {
    const auto& why = lowered.error();
    return open_instead(request, file->name(),
                        why.what + (why.offered.empty() ? "" : ": " + why.offered), out, error);
  }
  if (!lowered) {
    Error named = lowered.error();
    named.offered = file->name() + ": " + named.offered;
    return fail(error, named);
  }
  weir_open inner = request;
  inner.n_models = 0;
  inner.paths = nullptr;
  inner.bytes = lowered->onnx.data();
  inner.n_bytes = lowered->onnx.size();
  inner.options = choice.others.data();
  inner.n_options = static_cast<uint32_t>(choice.others.size());
  const int result = other->open(&inner, &out->model, error);
  const bool of_the_model = result == -static_cast<int>(Code::MODEL_INVALID) ||
                            result == -static_cast<int>(Code::MODEL_UNSUPPORTED);
  if (of_the_model)
    return open_instead(request, file->name(),
                        "ONNX Runtime rejects the lowered graph, error " + std::to_string(-result),
                        out, error);
  if (result < 0) return result;
  out->engine = other;
  out->lowered = true;
  out->input_scales = std::move(lowered->inputs);
  out->output_scales = std::move(lowered->outputs);
  out->metadata = lowered_metadata(file->bytes);
  log(WEIR_LOG_INFO, "Lowering:onnxruntime: ONNX Runtime runs " + file->name());
  return WEIR_OK;
}

int open(const weir_open* request, weir_model** out, weir_error* error) {
  *out = nullptr;
  return guarded(error, [&]() -> int {
    const auto choice = lowering_choice(*request);
    if (!choice) return fail(error, choice.error());
    auto chosen = std::make_unique<ChosenModel>();
    const int result = choice->wanted ? open_lowered(*request, *choice, chosen.get(), error)
                                      : open_own(*request, chosen.get(), error);
    if (result < 0) return result;
    *out = reinterpret_cast<weir_model*>(chosen.release());
    return WEIR_OK;
  });
}

void close(weir_model* model) {
  guarded(nullptr, [&]() -> int {
    const std::unique_ptr<ChosenModel> ended(&of(model));
    return WEIR_OK;
  });
}

int info(weir_model* model, weir_model_info* info, weir_error* error) {
  auto& chosen = of(model);
  const int result = chosen.engine->info(chosen.model, info, error);
  if (result < 0 || (!chosen.lowered && chosen.stays.empty())) return result;
  return guarded(error, [&]() -> int {
    if (!chosen.lowered) {
      if (chosen.metadata.empty()) chosen.metadata = with_reason(info->metadata_json, chosen.stays);
      info->metadata_json = chosen.metadata.c_str();
      return WEIR_OK;
    }
    if (chosen.inputs.empty() && chosen.outputs.empty()) {
      chosen.inputs.assign(info->inputs, info->inputs + info->n_inputs);
      chosen.outputs.assign(info->outputs, info->outputs + info->n_outputs);
      lay_over(chosen.input_scales, chosen.inputs);
      lay_over(chosen.output_scales, chosen.outputs);
    }
    info->inputs = chosen.inputs.data();
    info->outputs = chosen.outputs.data();
    info->metadata_json = chosen.metadata.c_str();
    return WEIR_OK;
  });
}

int session_new(weir_model* model, const weir_option* options, uint32_t n, weir_session** out,
                weir_error* error) {
  *out = nullptr;
  return guarded(error, [&]() -> int {
    auto session = std::make_unique<ChosenSession>(ChosenSession{of(model).engine, nullptr});
    const int result =
        session->engine->session_new(of(model).model, options, n, &session->session, error);
    if (result < 0) return result;
    *out = reinterpret_cast<weir_session*>(session.release());
    return WEIR_OK;
  });
}

void session_free(weir_session* session) {
  guarded(nullptr, [&]() -> int {
    const std::unique_ptr<ChosenSession> ended(&of(session));
    ended->engine->session_free(ended->session);
    return WEIR_OK;
  });
}

int resolve(weir_session* session, const weir_tensor_info* in, uint32_t n_in, weir_tensor_info* out,
            uint32_t n_out, weir_error* error) {
  return of(session).engine->resolve(of(session).session, in, n_in, out, n_out, error);
}

int invoke(weir_session* session, const weir_frame* in, weir_frame* out, weir_error* error) {
  return of(session).engine->invoke(of(session).session, in, out, error);
}

int control(weir_session* session, int op, const weir_option* option, weir_error* error) {
  return of(session).engine->control(of(session).session, op, option, error);
}

int execution(weir_model* model, weir_execution* out) {
  const auto* calls =
      static_cast<const weir_execution_calls*>(of(model).engine->extension(WEIR_EXECUTION));
  return calls ? calls->describe(of(model).model, out) : -WEIR_MODEL_UNSUPPORTED;
}

const void* extension(const char* id) {
  static constexpr weir_execution_calls calls{sizeof calls, execution};
  if (id && std::string_view(id) == WEIR_EXECUTION) return &calls;
  return own_engine->extension(id);
}

}  // namespace

weir_engine choosing_table(const weir_engine& own) {
  own_engine = &own;
  weir_engine table = own;
  table.open = open;
  table.close = close;
  table.info = info;
  table.session_new = session_new;
  table.session_free = session_free;
  table.resolve = resolve;
  table.invoke = invoke;
  table.control = control;
  table.extension = extension;
  return table;
}

}  // namespace weir::engine
