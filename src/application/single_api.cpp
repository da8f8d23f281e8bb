// ml_single_*.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>

#include "ml_error.hpp"
#include "single.hpp"

namespace {

using namespace weir;
using namespace weir::application;

template <class T>
Result<std::shared_ptr<T>> find(void* handle, const char* what) {
  return Handles::all().find<T>(handle, what);
}

// Runs `body`, which returns an ml_error_e, with the Single.
template <class Body>
int with(ml_single_h single, Body&& body) {
  return guarded([&] {
    const auto found = find<Single>(single, "single");
    return found ? body(**found) : fail(found.error());
  });
}

int hand_over(TensorSpecs tensors, ml_tensors_info_h* info) {
  *info = new_info(std::move(tensors));
  return ML_ERROR_NONE;
}

}  // namespace

int ml_single_open_full(ml_single_h* single, const char* model, const ml_tensors_info_h input_info,
                        const ml_tensors_info_h output_info, ml_nnfw_type_e nnfw, ml_nnfw_hw_e hw,
                        const char* custom_option) {
  return guarded([&] {
    if (!single) return fail(null_pointer("single"));
    *single = nullptr;
    if (!model) return fail(null_pointer("model"));
    const auto inputs = tensors_or_none(input_info, "input_info");
    const auto outputs = tensors_or_none(output_info, "output_info");
    if (!inputs) return fail(inputs.error());
    if (!outputs) return fail(outputs.error());
    auto opened =
        Single::open({model, custom_option ? custom_option : "", *inputs, *outputs, nnfw, hw});
    if (!opened) return fail(opened.error());
    *single = Handles::all().add(*std::move(opened));
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_single_open(ml_single_h* single, const char* model, const ml_tensors_info_h input_info,
                   const ml_tensors_info_h output_info, ml_nnfw_type_e nnfw, ml_nnfw_hw_e hw) {
  return ml_single_open_full(single, model, input_info, output_info, nnfw, hw, nullptr);
}

int ml_single_close(ml_single_h single) {
  return guarded([&] {
    const auto taken = Handles::all().take<Single>(single, "single");
    return taken ? static_cast<int>(ML_ERROR_NONE) : fail(taken.error());
  });
}

int ml_single_invoke(ml_single_h single, const ml_tensors_data_h input, ml_tensors_data_h* output) {
  return with(single, [&](Single& s) {
    if (!output) return fail(null_pointer("output"));
    *output = nullptr;
    const auto in = find<TensorsData>(input, "input");
    if (!in) return fail(in.error());
    auto out = s.invoke(**in);
    if (!out) return fail(out.error());
    *output = Handles::all().add(*std::move(out));
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_single_invoke_fast(ml_single_h single, const ml_tensors_data_h input,
                          ml_tensors_data_h output) {
  return with(single, [&](Single& s) {
    const auto in = find<TensorsData>(input, "input");
    const auto out = find<TensorsData>(output, "output");
    if (!in) return fail(in.error());
    if (!out) return fail(out.error());
    return to_ml_error(s.invoke_into(**in, **out));
  });
}

int ml_single_invoke_dynamic(ml_single_h single, const ml_tensors_data_h input,
                             const ml_tensors_info_h in_info, ml_tensors_data_h* output,
                             ml_tensors_info_h* out_info) {
  return with(single, [&](Single& s) {
    if (!output || !out_info) return fail(null_pointer("output or out_info"));
    *output = *out_info = nullptr;
    if (!in_info) return fail(null_pointer("in_info"));
    const auto in = find<TensorsData>(input, "input");
    if (!in) return fail(in.error());
    const auto shapes = tensors_or_none(in_info, "in_info");
    if (!shapes) return fail(shapes.error());
    if (auto status = check_same("the input differs from in_info", (*in)->tensors(), *shapes);
        !status)
      return fail(status.error());
    auto out = s.invoke(**in, *shapes);
    if (!out) return fail(out.error());
    *out_info = new_info((*out)->tensors());
    *output = Handles::all().add(*std::move(out));
    return static_cast<int>(ML_ERROR_NONE);
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
    return wanted ? to_ml_error(s.set_inputs(*wanted)) : fail(wanted.error());
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
    return to_ml_error(s.set_property(name, value));
  });
}

int ml_single_get_property(ml_single_h single, const char* name, char** value) {
  return with(single, [&](const Single& s) {
    if (!name || !value) return fail(null_pointer("name or value"));
    *value = nullptr;
    const auto text = s.property(name);
    if (!text) return fail(text.error());
    *value = strdup(text->c_str());
    if (!*value) throw std::bad_alloc();
    return static_cast<int>(ML_ERROR_NONE);
  });
}
