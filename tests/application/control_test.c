/* Tests of ml_pipeline_switch_*, _valve_* and _element_*. */
/* SPDX-License-Identifier: LGPL-2.1-or-later */
#include "check_test_support.h"
#include "nnstreamer.h"
#include "wait_test_support.h"

static ml_pipeline_h construct(const char* text) {
  ml_pipeline_h pipe = NULL;
  OK(ml_pipeline_construct(text, NULL, NULL, &pipe));
  return pipe;
}

static void count_frame(const ml_tensors_data_h data, const ml_tensors_info_h info, void* counter) {
  (void)data, (void)info;
  raise_count(counter);
}

static void push(ml_pipeline_h pipe, const char* name) {
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_UINT8, 1, 0);
  ml_tensors_data_h data = NULL;
  ml_pipeline_src_h src = NULL;
  OK(ml_tensors_data_create(info, &data));
  OK(ml_pipeline_src_get_handle(pipe, name, &src));
  OK(ml_pipeline_src_input_data(src, data, ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  OK(ml_pipeline_src_release_handle(src));
  OK(ml_tensors_info_destroy(info));
}

static void a_valve_opens_and_closes(void) {
  Counter frames = COUNTER;
  ml_pipeline_h pipe = construct(
      "appsrc name=in ! identity name=passed ! valve name=v drop=true ! tensor_sink name=out "
      "sync=false");
  ml_pipeline_valve_h valve = NULL;
  ml_pipeline_sink_h sink = NULL;
  ml_pipeline_src_h src = NULL;
  ml_pipeline_element_h element = NULL;
  int32_t drop = 0;
  OK(ml_pipeline_sink_register(pipe, "out", count_frame, &frames, &sink));
  OK(ml_pipeline_valve_get_handle(pipe, "v", &valve));
  OK(ml_pipeline_element_get_handle(pipe, "v", &element));
  OK(ml_pipeline_element_get_property_bool(element, "drop", &drop));
  CHECK(drop == 1);
  OK(ml_pipeline_valve_set_open(valve, true));
  OK(ml_pipeline_element_get_property_bool(element, "drop", &drop));
  CHECK(drop == 0);
  OK(ml_pipeline_start(pipe));
  push(pipe, "in");
  wait_for(&frames, 1);
  OK(ml_pipeline_valve_set_open(valve, false));
  OK(ml_pipeline_element_get_property_bool(element, "drop", &drop));
  CHECK(drop == 1);
  CHECK_REFUSED(ml_pipeline_valve_get_handle(pipe, "out", &src), ML_ERROR_INVALID_PARAMETER,
                "offered: tensor_sink\n  needed: valve");
  CHECK_REFUSED(ml_pipeline_valve_set_open(element, true), ML_ERROR_INVALID_PARAMETER,
                "valve_handle is a handle of a different type");
  CHECK_REFUSED(ml_pipeline_valve_set_open(NULL, true), ML_ERROR_INVALID_PARAMETER,
                "valve_handle is a null pointer");
  OK(ml_pipeline_destroy(pipe));
  CHECK_REFUSED(ml_pipeline_valve_set_open(valve, true), ML_ERROR_INVALID_PARAMETER,
                "valve_handle is a handle that was destroyed or released");
  CHECK_REFUSED(ml_pipeline_valve_release_handle(valve), ML_ERROR_INVALID_PARAMETER,
                "was destroyed");
  CHECK_REFUSED(ml_pipeline_element_release_handle(element), ML_ERROR_INVALID_PARAMETER,
                "was destroyed");
  CHECK_REFUSED(ml_pipeline_sink_unregister(sink), ML_ERROR_INVALID_PARAMETER, "was destroyed");
}

static void a_switch_selects(void) {
  Counter frames = COUNTER;
  ml_pipeline_h pipe = construct(
      "input-selector name=s sync-streams=false ! tensor_sink name=out sync=false "
      "appsrc name=a ! s.sink_0 appsrc name=b ! s.sink_1");
  ml_pipeline_switch_h selector = NULL;
  ml_pipeline_switch_e type = ML_PIPELINE_SWITCH_OUTPUT_SELECTOR;
  ml_pipeline_sink_h sink = NULL;
  char** pads = NULL;
  OK(ml_pipeline_sink_register(pipe, "out", count_frame, &frames, &sink));
  OK(ml_pipeline_switch_get_handle(pipe, "s", &type, &selector));
  CHECK(type == ML_PIPELINE_SWITCH_INPUT_SELECTOR);
  OK(ml_pipeline_switch_get_pad_list(selector, &pads));
  CHECK(pads && pads[0] && pads[1] && !pads[2]);
  if (pads && pads[0] && pads[1]) {
    CHECK(strcmp(pads[0], "sink_0") == 0 && strcmp(pads[1], "sink_1") == 0);
    free(pads[0]);
    free(pads[1]);
  }
  free(pads);
  OK(ml_pipeline_switch_select(selector, "sink_1"));
  OK(ml_pipeline_start(pipe));
  push(pipe, "b");
  wait_for(&frames, 1);
  CHECK_REFUSED(ml_pipeline_switch_select(selector, "sink_7"), ML_ERROR_INVALID_PARAMETER,
                "input-selector has no such pad\n  offered: sink_7");
  CHECK_REFUSED(ml_pipeline_switch_select(selector, NULL), ML_ERROR_INVALID_PARAMETER,
                "null pointer");
  CHECK_REFUSED(ml_pipeline_switch_get_handle(pipe, "a", NULL, &selector),
                ML_ERROR_INVALID_PARAMETER, "needed: input-selector or output-selector");
  OK(ml_pipeline_switch_get_handle(pipe, "s", NULL, &selector));
  OK(ml_pipeline_switch_release_handle(selector));
  OK(ml_pipeline_destroy(pipe));
}

static void outputs_are_switched_too(void) {
  ml_pipeline_h pipe =
      construct("videotestsrc ! output-selector name=s s.src_0 ! fakesink s.src_1 ! fakesink");
  ml_pipeline_switch_h selector = NULL;
  ml_pipeline_switch_e type = ML_PIPELINE_SWITCH_INPUT_SELECTOR;
  char** pads = NULL;
  size_t i;
  OK(ml_pipeline_switch_get_handle(pipe, "s", &type, &selector));
  CHECK(type == ML_PIPELINE_SWITCH_OUTPUT_SELECTOR);
  OK(ml_pipeline_switch_get_pad_list(selector, &pads));
  for (i = 0; pads && pads[i]; ++i) {
    CHECK(strncmp(pads[i], "src_", 4) == 0);
    free(pads[i]);
  }
  CHECK(i == 2);
  free(pads);
  OK(ml_pipeline_switch_select(selector, "src_1"));
  OK(ml_pipeline_switch_release_handle(selector));
  OK(ml_pipeline_destroy(pipe));
}

static void properties_have_their_types(void) {
  ml_pipeline_h pipe = construct(
      "videotestsrc name=v ! identity name=i ! tensor_converter ! "
      "tensor_transform name=t mode=typecast option=float32 ! fakesink name=f");
  ml_pipeline_element_h v = NULL, i = NULL, t = NULL, f = NULL;
  int32_t int32 = 0, yes = 0;
  int64_t int64 = 0;
  uint32_t uint32 = 0;
  uint64_t uint64 = 0;
  double real = 0;
  char* text = NULL;
  OK(ml_pipeline_element_get_handle(pipe, "v", &v));
  OK(ml_pipeline_element_get_handle(pipe, "i", &i));
  OK(ml_pipeline_element_get_handle(pipe, "t", &t));
  OK(ml_pipeline_element_get_handle(pipe, "f", &f));
  OK(ml_pipeline_element_set_property_bool(v, "is-live", 1));
  OK(ml_pipeline_element_get_property_bool(v, "is-live", &yes));
  CHECK(yes == 1);
  OK(ml_pipeline_element_set_property_int32(v, "num-buffers", -1));
  OK(ml_pipeline_element_get_property_int32(v, "num-buffers", &int32));
  CHECK(int32 == -1);
  OK(ml_pipeline_element_set_property_int64(v, "timestamp-offset", INT64_C(5000000000)));
  OK(ml_pipeline_element_get_property_int64(v, "timestamp-offset", &int64));
  CHECK(int64 == INT64_C(5000000000));
  OK(ml_pipeline_element_set_property_uint32(v, "foreground-color", UINT32_C(4000000000)));
  OK(ml_pipeline_element_get_property_uint32(v, "foreground-color", &uint32));
  CHECK(uint32 == UINT32_C(4000000000));
  OK(ml_pipeline_element_set_property_uint64(f, "processing-deadline", UINT64_C(6000000000)));
  OK(ml_pipeline_element_get_property_uint64(f, "processing-deadline", &uint64));
  CHECK(uint64 == UINT64_C(6000000000));
  OK(ml_pipeline_element_set_property_enum(v, "pattern", 18));
  OK(ml_pipeline_element_get_property_enum(v, "pattern", &uint32));
  CHECK(uint32 == 18);
  OK(ml_pipeline_element_get_property_int32(v, "pattern", &int32));
  CHECK(int32 == 18);
  OK(ml_pipeline_element_set_property_int32(v, "pattern", 17));
  OK(ml_pipeline_element_get_property_uint32(v, "pattern", &uint32));
  CHECK(uint32 == 17);
  OK(ml_pipeline_element_set_property_uint32(v, "pattern", 0));
  OK(ml_pipeline_element_get_property_enum(v, "pattern", &uint32));
  CHECK(uint32 == 0);
  OK(ml_pipeline_element_set_property_double(i, "drop-probability", 0.125));
  OK(ml_pipeline_element_get_property_double(i, "drop-probability", &real));
  CHECK(real > 0.1249 && real < 0.1251);
  OK(ml_pipeline_element_set_property_string(t, "option", "uint8"));
  OK(ml_pipeline_element_get_property_string(t, "option", &text));
  CHECK(text && strcmp(text, "uint8") == 0);
  free(text);

  CHECK_REFUSED(
      ml_pipeline_element_set_property_int32(t, "option", 1), ML_ERROR_INVALID_PARAMETER,
      "the property option of t has a different type\n  offered: int32\n  needed: string\n"
      "  fix: ml_pipeline_element_set_property_string() or "
      "ml_pipeline_element_get_property_string()");
  CHECK_REFUSED(ml_pipeline_element_set_property_bool(v, "is-live", 5), ML_ERROR_INVALID_PARAMETER,
                "value is not a boolean\n  offered: 5");
  CHECK_REFUSED(ml_pipeline_element_set_property_string(v, "pattern", "ball"),
                ML_ERROR_INVALID_PARAMETER, "needed: enum");
  CHECK_REFUSED(ml_pipeline_element_get_property_int64(v, "pattern", &int64),
                ML_ERROR_INVALID_PARAMETER, "needed: enum");
  CHECK_REFUSED(ml_pipeline_element_get_property_uint32(v, "num-buffers", &uint32),
                ML_ERROR_INVALID_PARAMETER, "needed: int32");
  CHECK_REFUSED(ml_pipeline_element_get_property_enum(v, "num-buffers", &uint32),
                ML_ERROR_INVALID_PARAMETER, "offered: enum");
  CHECK_REFUSED(ml_pipeline_element_set_property_int32(v, "num-bufers", 1),
                ML_ERROR_INVALID_PARAMETER, "did you mean num-buffers?");
  CHECK_REFUSED(ml_pipeline_element_set_property_int32(v, "num-buffers", -7),
                ML_ERROR_INVALID_PARAMETER, "a value in its range");
  CHECK_REFUSED(ml_pipeline_element_set_property_enum(v, "pattern", 4711),
                ML_ERROR_INVALID_PARAMETER, "videotestsrc does not accept this value for pattern");
  CHECK_REFUSED(ml_pipeline_element_set_property_string(t, "option", NULL),
                ML_ERROR_INVALID_PARAMETER, "value is a null pointer");
  CHECK_REFUSED(ml_pipeline_element_get_property_string(t, NULL, &text), ML_ERROR_INVALID_PARAMETER,
                "null pointer");
  CHECK_REFUSED(ml_pipeline_element_get_property_string(pipe, "option", &text),
                ML_ERROR_INVALID_PARAMETER, "elem_h is a handle of a different type");
  CHECK_REFUSED(ml_pipeline_element_get_handle(pipe, "w", &t), ML_ERROR_INVALID_PARAMETER,
                "no element of the pipeline has this name");
  OK(ml_pipeline_destroy(pipe));
  CHECK_REFUSED(ml_pipeline_element_get_property_int32(v, "num-buffers", &int32),
                ML_ERROR_INVALID_PARAMETER, "elem_h is a handle that was destroyed or released");
}

static void an_enum_below_zero_is_a_number_too(void) {
  ml_pipeline_h pipe = construct("videotestsrc ! filesink name=f location=/dev/null");
  ml_pipeline_element_h f = NULL;
  int32_t int32 = 0;
  uint32_t uint32 = 0;
  OK(ml_pipeline_element_get_handle(pipe, "f", &f));
  OK(ml_pipeline_element_get_property_int32(f, "buffer-mode", &int32));
  CHECK(int32 == -1);
  OK(ml_pipeline_element_get_property_uint32(f, "buffer-mode", &uint32));
  CHECK(uint32 == UINT32_MAX);
  OK(ml_pipeline_element_set_property_uint32(f, "buffer-mode", 2));
  OK(ml_pipeline_element_get_property_enum(f, "buffer-mode", &uint32));
  CHECK(uint32 == 2);
  OK(ml_pipeline_element_set_property_uint32(f, "buffer-mode", UINT32_MAX));
  OK(ml_pipeline_element_get_property_int32(f, "buffer-mode", &int32));
  CHECK(int32 == -1);
  OK(ml_pipeline_destroy(pipe));
}

int main(void) {
  a_valve_opens_and_closes();
  a_switch_selects();
  outputs_are_switched_too();
  properties_have_their_types();
  an_enum_below_zero_is_a_number_too();
  return result_of_checks();
}
