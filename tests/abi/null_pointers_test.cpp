// Calls every function of the C libraries with each of its pointers NULL: each returns an error and
// none crashes. Fails for functions in the symbol lists that this file does not call.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "null_pointers_test_support.hpp"

#include <cstdlib>
#include <fstream>

#include "library/process.h"
#include "nnstreamer-single.h"
#include "nnstreamer.h"
#include "weir/custom_condition.h"
#include "weir/custom_converter.h"
#include "weir/custom_filter.hpp"
#include "weir/model.h"
#include "weir/pipeline.h"

namespace null_pointers_test {

using weir::test::may_be_null;

const auto kError = may_be_null<weir_error**>(nullptr);
const auto kData = may_be_null<void*>(nullptr);

void check_every_function_is_called(const char* library) {
  std::ifstream list(std::string(std::getenv("WEIR_TEST_SYMBOLS")) + "/" + library + ".symbols");
  size_t count = 0;
  for (std::string line; std::getline(list, line); ++count) {
    const auto name = line.substr(0, line.find('@'));
    EXPECT_TRUE(weir::test::called_functions().contains(name)) << name << " is not in this test";
  }
  EXPECT_GT(count, 0u) << "no list of symbols";
}

void call_registrations() {
  weir_filter filter{};
  filter.struct_size = sizeof filter;
  EXPECT_NULL_REFUSED(
      weir_condition_register, "x",
      [](const weir_host*, const weir_frame*, int*, void*, weir_error*) { return 0; }, kData);
  EXPECT_NULL_REFUSED(weir_condition_unregister, "x");
  EXPECT_NULL_REFUSED(
      weir_converter_register, "x",
      [](const weir_host*, const char*, const weir_frame*, weir_frame*, void*, weir_error*) {
        return 0;
      },
      kData);
  EXPECT_NULL_REFUSED(weir_converter_unregister, "x");
  EXPECT_NULL_REFUSED(weir_filter_register, "x", &filter, kError);
  EXPECT_NULL_REFUSED(weir_filter_unregister, "x");
  EXPECT_NULL_REFUSED(
      weir_filter_class_register, "x",
      [](const weir_host*) -> const weir_module* { return nullptr; }, kError);
  EXPECT_NULL_REFUSED(weir_filter_class_unregister, "x");
}

void call_errors() {
  EXPECT_NULL_HARMLESS(weir_error_code, nullptr);
  EXPECT_NULL_REFUSED(weir_error_message, nullptr);
  for (const auto text : {weir_error_what, weir_error_offered, weir_error_needed,
                          weir_error_difference, weir_error_fix})
    EXPECT_STREQ(text(nullptr), "");
  for (const char* name : {"weir_error_what", "weir_error_offered", "weir_error_needed",
                           "weir_error_difference", "weir_error_fix", "weir_error_new"})
    weir::test::called_functions().insert(name);
  weir_error_free(weir_error_new(1, nullptr, nullptr, nullptr, nullptr, nullptr));
  EXPECT_NULL_HARMLESS(weir_error_free, nullptr);
}

TEST(NullPointers, OfLibweirAreErrors) {
  weir_model_options options = WEIR_MODEL_OPTIONS_INIT;
  options.engine = "fake";
  weir_loaded_model *model = nullptr, *other = nullptr;
  ASSERT_EQ(weir_model_open(&options, &model, nullptr), WEIR_OK);
  weir_tensor_info info{};
  const float x[4] = {1, 2, 3, 4};
  weir_tensor tensor = weir_tensor_of(x, sizeof x, WEIR_FLOAT32), out{};
  tensor.info.rank = 2;
  tensor.info.shape[0] = 1;
  tensor.info.shape[1] = 4;
  weir_results* results = nullptr;
  EXPECT_NULL_REFUSED(weir_model_open, &options, &other, kError);
  EXPECT_NULL_HARMLESS(weir_model_close, nullptr);
  EXPECT_NULL_REFUSED(weir_model_engine, model);
  EXPECT_NULL_REFUSED(weir_model_engine_version, model);
  EXPECT_NULL_REFUSED(weir_model_metadata, model);
  EXPECT_NULL_REFUSED(weir_model_input_count, model);
  EXPECT_EQ(weir_model_input_count(nullptr), 0u);
  EXPECT_NULL_REFUSED(weir_model_output_count, model);
  EXPECT_EQ(weir_model_output_count(nullptr), 0u);
  EXPECT_NULL_REFUSED(weir_model_input, model, 0u, &info);
  EXPECT_NULL_REFUSED(weir_model_output, model, 0u, &info);
  EXPECT_NULL_REFUSED(weir_model_reshape, model, &info, 1u, kError);
  EXPECT_NULL_HARMLESS(weir_model_set_timeout, model, int64_t{0});
  EXPECT_NULL_REFUSED(weir_model_invoke, model, &tensor, 1u, &results, kError);
  EXPECT_NULL_REFUSED(weir_model_invoke_into, model, &tensor, 1u, &out, 1u, kError);
  EXPECT_NULL_REFUSED(weir_model_invoke_batch, model, &tensor, 1u, 1u, &results, kError);
  ASSERT_EQ(weir_model_invoke(model, &tensor, 1, &results, nullptr), WEIR_OK);
  EXPECT_NULL_REFUSED(weir_results_count, results);
  EXPECT_EQ(weir_results_count(nullptr), 0u);
  EXPECT_NULL_REFUSED(weir_results_frames, results);
  EXPECT_EQ(weir_results_frames(nullptr), 0u);
  EXPECT_NULL_REFUSED(weir_results_tensor, results, 0u, &out);
  EXPECT_NULL_REFUSED(weir_results_frame_tensor, results, 0u, 0u, &out);
  EXPECT_NULL_HARMLESS(weir_results_free, nullptr);
  const auto make = []() -> void* { return nullptr; };
  EXPECT_NULL_REFUSED(weir_process_object, "x", size_t{1}, +make);
  weir_results_free(results);
  weir_model_close(model);
  call_errors();
  call_registrations();
  check_every_function_is_called("libweir");
}

TEST(NullPointers, OfLibweirPipelineAreErrors) {
  weir_pipeline *p = nullptr, *other = nullptr;
  weir_error* message = nullptr;
  ASSERT_EQ(
      weir_pipeline_parse("appsrc name=in ! valve name=v ! tensor_sink name=out", &p, nullptr),
      WEIR_OK);
  const auto on_frame = [](const weir_pulled*, void*, weir_error**) { return 0; };
  const auto on_element = [](const char*, const char*, int, void*) {};
  const auto on_pad = [](const char*, int, void*) {};
  const float x[1] = {1};
  weir_tensor tensor = weir_tensor_of(x, sizeof x, WEIR_FLOAT32);
  tensor.info.rank = 1;
  tensor.info.shape[0] = 1;
  weir_pulled* frame = nullptr;
  weir_source_map map{};
  char* text = nullptr;
  int32_t number = 0;
  EXPECT_NULL_REFUSED(weir_pipeline_adopt, reinterpret_cast<_GstElement*>(&number), &other, kError);
  EXPECT_NULL_REFUSED(weir_pipeline_parse, "fakesrc ! fakesink", &other, kError);
  const char* allowed[] = {"fakesrc", "fakesink", nullptr};
  EXPECT_NULL_REFUSED(weir_pipeline_parse_allowed, "fakesrc ! fakesink", allowed, 2u, &other,
                      kError);
  EXPECT_LT(weir_pipeline_parse_allowed("fakesrc ! fakesink", allowed, 3, &other, nullptr), 0);
  EXPECT_NULL_HARMLESS(weir_pipeline_free, nullptr);
  EXPECT_NULL_REFUSED(weir_pipeline_start, p, kError);
  EXPECT_NULL_REFUSED(weir_pipeline_pause, p, kError);
  EXPECT_NULL_REFUSED(weir_pipeline_stop, p, kError);
  EXPECT_NULL_REFUSED(weir_pipeline_get_state, p);
  EXPECT_NULL_REFUSED(weir_pipeline_wait, p, int64_t{0}, kError);
  EXPECT_NULL_REFUSED(weir_pipeline_read_message, p, &message, kError);
  EXPECT_NULL_REFUSED(weir_pipeline_push, p, "in", &tensor, 1u, int64_t{-1}, int64_t{-1}, kError);
  EXPECT_NULL_REFUSED(weir_pipeline_end, p, "in", kError);
  weir_tensor_info needed{};
  EXPECT_NULL_REFUSED(weir_pipeline_source_tensors, p, "in", &needed, 1u, kError);
  EXPECT_NULL_HARMLESS(weir_pipeline_get_element, p, may_be_null<const char*>("nosuch"));
  EXPECT_NULL_REFUSED(weir_pipeline_pull, p, "out", int64_t{0}, &frame, kError);
  EXPECT_NULL_REFUSED(weir_pipeline_ended, p, "out", kError);
  EXPECT_NULL_REFUSED(weir_pipeline_on_frame, p, "out", may_be_null(+on_frame), kData, kError);
  EXPECT_NULL_REFUSED(weir_pipeline_on_state, p, may_be_null<weir_state_function>(nullptr), kData,
                      kError);
  EXPECT_NULL_REFUSED(weir_pipeline_discard, p, "out", kError);
  EXPECT_NULL_REFUSED(weir_pipeline_on_message, p, may_be_null<weir_message_function>(nullptr),
                      kData, kError);
  EXPECT_NULL_REFUSED(weir_pipeline_set_valve, p, "v", 1, kError);
  EXPECT_NULL_REFUSED(weir_pipeline_select, p, "v", "sink_0", kError);
  EXPECT_NULL_REFUSED(weir_pipeline_set, p, "v", "drop", "true", kError);
  EXPECT_NULL_REFUSED(weir_pipeline_get, p, "v", "drop", &text, kError);
  EXPECT_NULL_REFUSED(weir_pipeline_get_json, p, "v", "drop", &text, kError);
  EXPECT_NULL_REFUSED(weir_pipeline_property_type, p, "v", "drop", kError);
  EXPECT_NULL_REFUSED(weir_pipeline_get_enum, p, "v", "drop-mode", &number, kError);
  EXPECT_NULL_REFUSED(weir_pipeline_elements, p, +on_element, kData, kError);
  EXPECT_NULL_REFUSED(weir_pipeline_pads, p, "v", +on_pad, kData, kError);
  EXPECT_NULL_HARMLESS(weir_pipeline_text_free, nullptr);
  ASSERT_EQ(weir_pipeline_start(p, nullptr), WEIR_OK);
  ASSERT_EQ(weir_pipeline_push(p, "in", &tensor, 1, -1, -1, nullptr), WEIR_OK);
  ASSERT_EQ(weir_pipeline_pull(p, "out", -1, &frame, nullptr), WEIR_PIPELINE_DONE);
  EXPECT_NULL_REFUSED(weir_pulled_count, frame);
  EXPECT_EQ(weir_pulled_count(nullptr), 0u);
  EXPECT_NULL_REFUSED(weir_pulled_tensor, frame, 0u, &tensor);
  EXPECT_NULL_REFUSED(weir_pulled_pts, frame);
  EXPECT_EQ(weir_pulled_pts(nullptr), -1);
  EXPECT_NULL_REFUSED(weir_pulled_duration, frame);
  EXPECT_EQ(weir_pulled_duration(nullptr), -1);
  EXPECT_NULL_REFUSED(weir_pulled_caps, frame);
  EXPECT_NULL_REFUSED(weir_pulled_caps_field, frame, "weir-columns");
  EXPECT_NULL_REFUSED(weir_pulled_label, frame, 0u, 0);
  EXPECT_NULL_REFUSED(weir_pulled_map_count, frame);
  EXPECT_EQ(weir_pulled_map_count(nullptr), 0u);
  EXPECT_NULL_REFUSED(weir_pulled_map, frame, 0u, &map);
  EXPECT_NULL_REFUSED(weir_pulled_keep, frame);
  EXPECT_EQ(weir_pulled_keep(nullptr), nullptr);
  EXPECT_NULL_HARMLESS(weir_pulled_free, nullptr);
  weir_pulled_free(frame);
  weir_pipeline_free(p);
  check_every_function_is_called("libweir-pipeline");
}

void call_tensors() {
  ml_tensors_info_h info = nullptr, other = nullptr;
  ml_tensors_data_h data = nullptr;
  ml_tensor_dimension dimension = {2};
  ASSERT_EQ(ml_tensors_info_create(&info), ML_ERROR_NONE);
  ml_tensors_info_set_count(info, 1);
  ml_tensors_info_set_tensor_type(info, 0, ML_TENSOR_TYPE_FLOAT32);
  ml_tensors_info_set_tensor_dimension(info, 0, dimension);
  ASSERT_EQ(ml_tensors_data_create(info, &data), ML_ERROR_NONE);
  ASSERT_EQ(ml_tensors_info_create(&other), ML_ERROR_NONE);
  bool valid = false;
  unsigned count = 0;
  char* name = nullptr;
  ml_tensor_type_e type = ML_TENSOR_TYPE_UNKNOWN;
  size_t size = 0;
  void* bytes = nullptr;
  const float values[2] = {};
  EXPECT_NULL_REFUSED(ml_tensors_info_create, &info);
  EXPECT_NULL_REFUSED(ml_tensors_info_destroy, info);
  EXPECT_NULL_REFUSED(ml_tensors_info_validate, info, &valid);
  EXPECT_NULL_REFUSED(ml_tensors_info_clone, other, info);
  EXPECT_NULL_REFUSED(ml_tensors_info_set_count, info, 1u);
  EXPECT_NULL_REFUSED(ml_tensors_info_get_count, info, &count);
  EXPECT_NULL_REFUSED(ml_tensors_info_set_tensor_name, info, 0u, may_be_null<const char*>("x"));
  EXPECT_NULL_REFUSED(ml_tensors_info_get_tensor_name, info, 0u, &name);
  EXPECT_NULL_REFUSED(ml_tensors_info_set_tensor_type, info, 0u, ML_TENSOR_TYPE_UINT8);
  EXPECT_NULL_REFUSED(ml_tensors_info_get_tensor_type, info, 0u, &type);
  EXPECT_NULL_REFUSED(ml_tensors_info_set_tensor_dimension, info, 0u, dimension);
  EXPECT_NULL_REFUSED(ml_tensors_info_get_tensor_dimension, info, 0u, dimension);
  EXPECT_NULL_REFUSED(ml_tensors_info_get_tensor_size, info, 0, &size);
  EXPECT_NULL_REFUSED(ml_tensors_data_create, info, &data);
  EXPECT_NULL_REFUSED(ml_tensors_data_destroy, data);
  EXPECT_NULL_REFUSED(ml_tensors_data_get_tensor_data, data, 0u, &bytes, &size);
  EXPECT_NULL_REFUSED(ml_tensors_data_set_tensor_data, data, 0u, values, sizeof values);
  EXPECT_NULL_REFUSED(ml_tensors_info_create_extended, &other);
  EXPECT_NULL_REFUSED(ml_tensors_data_clone, data, &data);
  EXPECT_NULL_REFUSED(ml_tensors_data_get_info, data, &other);
}

void call_options() {
  ml_option_h option = nullptr;
  void* value = nullptr;
  unsigned length = 0;
  ASSERT_EQ(ml_option_create(&option), ML_ERROR_NONE);
  EXPECT_NULL_REFUSED(ml_option_create, &value);
  EXPECT_NULL_REFUSED(ml_option_destroy, option);
  EXPECT_NULL_REFUSED(ml_option_set, option, "x", static_cast<void*>(&length),
                      may_be_null<ml_data_destroy_cb>(nullptr));
  EXPECT_NULL_REFUSED(ml_option_get, option, "x", &value);
  EXPECT_NULL_REFUSED(ml_information_get, option, "x", &value);
  EXPECT_NULL_REFUSED(ml_information_destroy, option);
  EXPECT_NULL_REFUSED(ml_information_list_length, option, &length);
  EXPECT_NULL_REFUSED(ml_information_list_get, option, 0u, &value);
  EXPECT_NULL_REFUSED(ml_information_list_destroy, option);
  EXPECT_EQ(ml_option_destroy(option), ML_ERROR_NONE);
  bool available = false;
  EXPECT_NULL_REFUSED(ml_check_element_availability, "x", &available);
  EXPECT_NULL_REFUSED(ml_check_nnfw_availability, ML_NNFW_TYPE_SNPE, ML_NNFW_HW_ANY, &available);
  EXPECT_NULL_REFUSED(ml_check_nnfw_availability_full, ML_NNFW_TYPE_SNPE, ML_NNFW_HW_ANY,
                      may_be_null<const char*>("x"), &available);
  // They need no pointers.
  weir::test::called_functions().insert({"ml_error", "ml_error_number", "ml_strerror",
                                         "ml_api_get_version", "ml_api_get_version_string"});
  ml_api_get_version(nullptr, nullptr, nullptr);
}

void call_single() {
  const auto x = weir::tensor_info("x", WEIR_FLOAT32, {2});
  const weir::RegisteredFilter filter("null-pointers", {.inputs = {x}, .outputs = {x}},
                                      [](std::span<const weir_tensor>, std::span<weir_tensor>) {});
  ml_single_h single = nullptr, other = nullptr;
  ASSERT_EQ(ml_single_open(&single, "null-pointers", nullptr, nullptr, ML_NNFW_TYPE_CUSTOM_FILTER,
                           ML_NNFW_HW_ANY),
            ML_ERROR_NONE)
      << ml_error();
  const auto no_info = may_be_null<ml_tensors_info_h>(nullptr);
  ml_tensors_info_h info = nullptr;
  ml_tensors_data_h data = nullptr;
  char* text = nullptr;
  ASSERT_EQ(ml_single_get_input_info(single, &info), ML_ERROR_NONE);
  ASSERT_EQ(ml_tensors_data_create(info, &data), ML_ERROR_NONE);
  EXPECT_NULL_REFUSED(ml_single_open, &other, "x", no_info, no_info, ML_NNFW_TYPE_ANY,
                      ML_NNFW_HW_ANY);
  EXPECT_NULL_REFUSED(ml_single_open_full, &other, "x", no_info, no_info, ML_NNFW_TYPE_ANY,
                      ML_NNFW_HW_ANY, may_be_null<const char*>(nullptr));
  ml_option_h option = nullptr;
  ASSERT_EQ(ml_option_create(&option), ML_ERROR_NONE);
  EXPECT_NULL_REFUSED(ml_single_open_with_option, &other, option);
  EXPECT_NULL_REFUSED(ml_single_close, single);
  ml_tensors_data_h out = nullptr;
  EXPECT_NULL_REFUSED(ml_single_invoke, single, data, &out);
  EXPECT_NULL_REFUSED(ml_single_invoke_fast, single, data, data);
  EXPECT_NULL_REFUSED(ml_single_invoke_dynamic, single, data, info, &out, &info);
  EXPECT_NULL_REFUSED(ml_single_get_input_info, single, &info);
  EXPECT_NULL_REFUSED(ml_single_get_output_info, single, &info);
  EXPECT_NULL_REFUSED(ml_single_set_input_info, single, info);
  EXPECT_NULL_REFUSED(ml_single_set_timeout, single, 1u);
  EXPECT_NULL_REFUSED(ml_single_set_property, single, "x", "y");
  EXPECT_NULL_REFUSED(ml_single_get_property, single, "x", &text);
  EXPECT_EQ(ml_single_close(single), ML_ERROR_NONE);
}

void call_parts(ml_pipeline_h pipe) {
  ml_pipeline_src_h src = nullptr, other_src = nullptr;
  ml_pipeline_valve_h valve = nullptr, other_valve = nullptr;
  ml_pipeline_switch_h sw = nullptr, other_switch = nullptr;
  ml_pipeline_sink_h sink = nullptr;
  ASSERT_EQ(ml_pipeline_src_get_handle(pipe, "in", &src), ML_ERROR_NONE);
  ASSERT_EQ(ml_pipeline_valve_get_handle(pipe, "v", &valve), ML_ERROR_NONE);
  ASSERT_EQ(ml_pipeline_switch_get_handle(pipe, "s", nullptr, &sw), ML_ERROR_NONE);
  char** list = nullptr;
  const auto see = [](const ml_tensors_data_h, const ml_tensors_info_h, void*) {};
  EXPECT_NULL_REFUSED(ml_pipeline_sink_register, pipe, "out", +see, kData, &sink);
  EXPECT_NULL_REFUSED(ml_pipeline_sink_unregister, sink);
  EXPECT_NULL_REFUSED(ml_pipeline_src_get_handle, pipe, "in", &other_src);
  EXPECT_NULL_REFUSED(ml_pipeline_src_release_handle, src);
  EXPECT_NULL_REFUSED(ml_pipeline_src_input_data, src, ml_tensors_data_h{},
                      ML_PIPELINE_BUF_POLICY_DO_NOT_FREE);
  EXPECT_NULL_REFUSED(ml_pipeline_src_input_data_eos, src);
  ml_tensors_info_h info = nullptr;
  ml_pipeline_src_callbacks_s callbacks{};
  EXPECT_NULL_REFUSED(ml_pipeline_src_get_tensors_info, src, &info);
  EXPECT_NULL_REFUSED(ml_pipeline_src_set_event_cb, src, &callbacks, kData);
  EXPECT_NULL_REFUSED(ml_pipeline_switch_get_handle, pipe, "s",
                      may_be_null<ml_pipeline_switch_e*>(nullptr), &other_switch);
  EXPECT_NULL_REFUSED(ml_pipeline_switch_release_handle, sw);
  EXPECT_NULL_REFUSED(ml_pipeline_switch_select, sw, "sink_0");
  EXPECT_NULL_REFUSED(ml_pipeline_switch_get_pad_list, sw, &list);
  EXPECT_NULL_REFUSED(ml_pipeline_valve_get_handle, pipe, "v", &other_valve);
  EXPECT_NULL_REFUSED(ml_pipeline_valve_release_handle, valve);
  EXPECT_NULL_REFUSED(ml_pipeline_valve_set_open, valve, true);
}

void call_elements(ml_pipeline_h pipe) {
  ml_pipeline_element_h v = nullptr, other = nullptr;
  ASSERT_EQ(ml_pipeline_element_get_handle(pipe, "v", &v), ML_ERROR_NONE);
  int32_t i32 = 0;
  int64_t i64 = 0;
  uint32_t u32 = 0;
  uint64_t u64 = 0;
  double f64 = 0;
  char* text = nullptr;
  EXPECT_NULL_REFUSED(ml_pipeline_element_get_handle, pipe, "v", &other);
  EXPECT_NULL_REFUSED(ml_pipeline_element_release_handle, v);
  EXPECT_NULL_REFUSED(ml_pipeline_element_set_property_bool, v, "drop", 1);
  EXPECT_NULL_REFUSED(ml_pipeline_element_set_property_string, v, "name", "w");
  EXPECT_NULL_REFUSED(ml_pipeline_element_set_property_int32, v, "drop", 1);
  EXPECT_NULL_REFUSED(ml_pipeline_element_set_property_int64, v, "drop", int64_t{1});
  EXPECT_NULL_REFUSED(ml_pipeline_element_set_property_uint32, v, "drop", 1u);
  EXPECT_NULL_REFUSED(ml_pipeline_element_set_property_uint64, v, "drop", uint64_t{1});
  EXPECT_NULL_REFUSED(ml_pipeline_element_set_property_double, v, "drop", 1.0);
  EXPECT_NULL_REFUSED(ml_pipeline_element_set_property_enum, v, "drop-mode", 1u);
  EXPECT_NULL_REFUSED(ml_pipeline_element_get_property_bool, v, "drop", &i32);
  EXPECT_NULL_REFUSED(ml_pipeline_element_get_property_string, v, "name", &text);
  EXPECT_NULL_REFUSED(ml_pipeline_element_get_property_int32, v, "drop", &i32);
  EXPECT_NULL_REFUSED(ml_pipeline_element_get_property_int64, v, "drop", &i64);
  EXPECT_NULL_REFUSED(ml_pipeline_element_get_property_uint32, v, "drop", &u32);
  EXPECT_NULL_REFUSED(ml_pipeline_element_get_property_uint64, v, "drop", &u64);
  EXPECT_NULL_REFUSED(ml_pipeline_element_get_property_double, v, "drop", &f64);
  EXPECT_NULL_REFUSED(ml_pipeline_element_get_property_enum, v, "drop-mode", &u32);
}

void call_callbacks() {
  ml_tensors_info_h info = nullptr;
  ml_tensors_info_create(&info);
  ml_custom_easy_filter_h filter = nullptr;
  ml_pipeline_if_h condition = nullptr;
  const auto invoke = [](const ml_tensors_data_h, ml_tensors_data_h, void*) { return 0; };
  const auto decide = [](const ml_tensors_data_h, const ml_tensors_info_h, int*, void*) {
    return 0;
  };
  EXPECT_NULL_REFUSED(ml_pipeline_custom_easy_filter_register, "x", info, info, +invoke, kData,
                      &filter);
  EXPECT_NULL_REFUSED(ml_pipeline_custom_easy_filter_unregister, filter);
  EXPECT_NULL_REFUSED(ml_pipeline_tensor_if_custom_register, "x", +decide, kData, &condition);
  EXPECT_NULL_REFUSED(ml_pipeline_tensor_if_custom_unregister, condition);
}

TEST(NullPointers, OfTheApplicationApiAreErrors) {
  ml_pipeline_h pipe = nullptr, other = nullptr;
  ASSERT_EQ(ml_pipeline_construct("appsrc name=in ! valve name=v ! input-selector name=s ! "
                                  "tensor_sink name=out",
                                  nullptr, nullptr, &pipe),
            ML_ERROR_NONE);
  ml_pipeline_state_e state = ML_PIPELINE_STATE_UNKNOWN;
  EXPECT_NULL_REFUSED(ml_pipeline_construct, "fakesrc ! fakesink",
                      may_be_null<ml_pipeline_state_cb>(nullptr), kData, &other);
  EXPECT_NULL_REFUSED(ml_pipeline_destroy, pipe);
  EXPECT_NULL_REFUSED(ml_pipeline_start, pipe);
  EXPECT_NULL_REFUSED(ml_pipeline_stop, pipe);
  EXPECT_NULL_REFUSED(ml_pipeline_get_state, pipe, &state);
  EXPECT_NULL_REFUSED(ml_pipeline_flush, pipe, false);
  call_tensors();
  call_options();
  call_single();
  call_parts(pipe);
  call_elements(pipe);
  call_callbacks();
  EXPECT_EQ(ml_pipeline_destroy(pipe), ML_ERROR_NONE);
  check_every_function_is_called("libcapi-nnstreamer");
}

}  // namespace null_pointers_test
