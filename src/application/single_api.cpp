// ml_single_*.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>
#include <utility>

#include "core/text/text.hpp"
#include "ml_error.hpp"
#include "nnfw.hpp"
#include "option.hpp"
#include "single.hpp"

namespace {

using namespace weir;
using namespace weir::application;

template <class T>
Result<std::shared_ptr<T>> find(void* handle, const char* what) {
  return Handles::all().find<T>(handle, what);
}

Error closing() {
  return Error{.code = Code::CANCELLED, .what = "the model is being closed on another thread"};
}

// Runs `body`, which returns an ml_error_e, with the Single.
template <class Body>
int with(ml_single_h single, Body&& body) {
  return guarded([&] {
    const auto found = find<Single>(single, "single");
    if (!found) return fail(found.error());
    const infer::CallGate::Visit visit((*found)->gate());
    return visit ? body(**found) : fail(Refusal{ML_ERROR_STREAMS_PIPE, closing()});
  });
}

int hand_over(TensorSpecs tensors, ml_tensors_info_h* info) {
  *info = new_info(std::move(tensors));
  return ML_ERROR_NONE;
}

// Runs `body` with the value of an outcome.
template <class T, class Body>
int finish(Single::Outcome<T> outcome, Body&& body) {
  if (const auto* refused = std::get_if<Refusal>(&outcome)) return fail(*refused);
  body(std::get<T>(std::move(outcome)));
  return ML_ERROR_NONE;
}

int finish(Single::Outcome<Single::Done> outcome) {
  return finish<Single::Done>(std::move(outcome), [](Single::Done) {});
}

Status read_infos(ml_tensors_info_h input_info, ml_tensors_info_h output_info,
                  SingleRequest* request) {
  auto inputs = tensors_or_none(input_info, "input_info");
  if (!inputs) return inputs.error();
  auto outputs = tensors_or_none(output_info, "output_info");
  if (!outputs) return outputs.error();
  request->inputs = *std::move(inputs);
  request->outputs = *std::move(outputs);
  return ok();
}

int open(ml_single_h* single, SingleRequest request) {
  return finish<std::shared_ptr<Single>>(Single::open(std::move(request)), [&](auto opened) {
    *single = Handles::all().add(std::move(opened));
  });
}

// The outputs of an invoke, for the program or its callback of invoke_async.
int deliver(const Single& single, std::shared_ptr<TensorsData> data, ml_tensors_data_h* output) {
  const auto& request = single.request();
  if (!request.callback) {
    *output = Handles::all().add(std::move(data));
    return ML_ERROR_NONE;
  }
  *output = nullptr;
  const LentHandle lent(std::move(data));
  const int result = request.callback(lent.get(), request.callback_data);
  if (result == 0) return ML_ERROR_NONE;
  return fail(Error{.code = Code::CALLBACK_FAILED,
                    .what = "async_callback returned " + std::to_string(result)});
}

const char* text(const Option& option, const char* key) {
  return static_cast<const char*>(option.get(key));
}

bool is_true(const Option& option, const char* key) {
  const char* const value = text(option, key);
  return value && equal_ignoring_case(value, "true");
}

// Reads the values that ml_single_open_with_option documents.
Result<SingleRequest> read_options(const Option& option) {
  SingleRequest request;
  const char* const model = text(option, "models");
  if (!model)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "the option names no model",
                 .needed = "the key models",
                 .fix = "ml_option_set(option, \"models\", path, NULL)"};
  request.model = model;
  if (const char* custom = text(option, "custom")) request.custom = custom;
  if (auto status = read_infos(option.get("input_info"), option.get("output_info"), &request);
      !status)
    return status.error();
  if (const void* type = option.get("nnfw"))
    request.type = *static_cast<const ml_nnfw_type_e*>(type);
  auto framework = framework_name(request.type);
  if (!framework) return framework.error();
  request.framework = *std::move(framework);
  if (const void* hw = option.get("hw"))
    request.accelerator = accelerator_name(*static_cast<const ml_nnfw_hw_e*>(hw));
  for (const char* key : {"framework", "framework_name"})
    if (const char* name = text(option, key)) {
      request.framework = equal_ignoring_case(name, "auto") ? "" : name;
      request.type = framework_number(request.framework);
    }
  if (!is_true(option, "invoke_async")) return request;
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): the program passes a function
  request.callback = reinterpret_cast<DataCallback>(option.get("async_callback"));
  request.callback_data = option.get("async_data");
  if (request.callback) return request;
  return Error{.code = Code::OPTION_VALUE,
               .what = "invoke_async needs a function",
               .needed = "the key async_callback"};
}

}  // namespace

int ml_single_open_full(ml_single_h* single, const char* model, const ml_tensors_info_h input_info,
                        const ml_tensors_info_h output_info, ml_nnfw_type_e nnfw, ml_nnfw_hw_e hw,
                        const char* custom_option) {
  return guarded([&] {
    if (!single) return fail(null_pointer("single"));
    if (!model) return fail(null_pointer("model"));
    SingleRequest request;
    request.model = model;
    request.custom = custom_option ? custom_option : "";
    if (auto status = read_infos(input_info, output_info, &request); !status)
      return fail(status.error());
    auto framework = framework_name(nnfw);
    if (!framework) return fail(framework.error());
    request.framework = *std::move(framework);
    request.type = nnfw;
    request.accelerator = accelerator_name(hw);
    return open(single, std::move(request));
  });
}

int ml_single_open(ml_single_h* single, const char* model, const ml_tensors_info_h input_info,
                   const ml_tensors_info_h output_info, ml_nnfw_type_e nnfw, ml_nnfw_hw_e hw) {
  return ml_single_open_full(single, model, input_info, output_info, nnfw, hw, nullptr);
}

int ml_single_open_with_option(ml_single_h* single, const ml_option_h option) {
  return guarded([&] {
    if (!single) return fail(null_pointer("single"));
    const auto found = find<Option>(option, "option");
    if (!found) return fail(found.error());
    auto request = read_options(**found);
    return request ? open(single, *std::move(request)) : fail(request.error());
  });
}

int ml_single_close(ml_single_h single) {
  return guarded([&] {
    const auto taken = Handles::all().take<Single>(single, "single");
    if (!taken) return fail(taken.error());
    (*taken)->gate().close();
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_single_invoke(ml_single_h single, const ml_tensors_data_h input, ml_tensors_data_h* output) {
  return with(single, [&](Single& s) {
    if (!output) return fail(null_pointer("output"));
    const auto in = find<TensorsData>(input, "input");
    if (!in) return fail(in.error());
    auto out = s.invoke(**in);
    if (const auto* refused = std::get_if<Refusal>(&out)) return fail(*refused);
    return deliver(s, std::get<0>(std::move(out)), output);
  });
}

int ml_single_invoke_fast(ml_single_h single, const ml_tensors_data_h input,
                          ml_tensors_data_h output) {
  return with(single, [&](Single& s) {
    const auto in = find<TensorsData>(input, "input");
    const auto out = find<TensorsData>(output, "output");
    if (!in) return fail(in.error());
    if (!out) return fail(out.error());
    return finish(s.invoke_into(**in, **out));
  });
}

int ml_single_invoke_dynamic(ml_single_h single, const ml_tensors_data_h input,
                             const ml_tensors_info_h in_info, ml_tensors_data_h* output,
                             ml_tensors_info_h* out_info) {
  return with(single, [&](Single& s) {
    if (!output || !out_info) return fail(null_pointer("output or out_info"));
    if (!in_info) return fail(null_pointer("in_info"));
    const auto in = find<TensorsData>(input, "input");
    if (!in) return fail(in.error());
    const auto shapes = tensors_or_none(in_info, "in_info");
    if (!shapes) return fail(shapes.error());
    return finish<std::shared_ptr<TensorsData>>(s.invoke_dynamic(**in, *shapes), [&](auto out) {
      *out_info = new_info(out->tensors());
      *output = Handles::all().add(std::move(out));
    });
  });
}

int ml_single_get_input_info(ml_single_h single, ml_tensors_info_h* info) {
  return with(single, [&](const Single& s) {
    return info ? hand_over(s.inputs(), info) : fail(null_pointer("info"));
  });
}

int ml_single_get_output_info(ml_single_h single, ml_tensors_info_h* info) {
  return with(single, [&](const Single& s) {
    return info ? hand_over(s.outputs(), info) : fail(null_pointer("info"));
  });
}

int ml_single_set_input_info(ml_single_h single, const ml_tensors_info_h info) {
  return with(single, [&](Single& s) {
    if (!info) return fail(null_pointer("info"));
    const auto wanted = tensors_or_none(info, "info");
    return wanted ? finish(s.set_inputs(*wanted)) : fail(wanted.error());
  });
}

int ml_single_set_timeout(ml_single_h single, unsigned int timeout) {
  return with(single, [&](Single& s) {
    s.set_timeout(timeout);
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_single_set_property(ml_single_h single, const char* name, const char* value) {
  return with(single, [&](Single& s) {
    if (!name || !value) return fail(null_pointer("name or value"));
    return finish(s.set_property(name, value));
  });
}

int ml_single_get_property(ml_single_h single, const char* name, char** value) {
  return with(single, [&](const Single& s) {
    if (!name || !value) return fail(null_pointer("name or value"));
    *value = nullptr;
    return finish<std::string>(s.property(name), [&](const std::string& found) {
      *value = strdup(found.c_str());
      if (!*value) throw std::bad_alloc();
    });
  });
}
