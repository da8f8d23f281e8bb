/* Tests of ml_single_*: the test engine's y = x + 1 on float32 with 4 columns and any number of
 * rows. */
/* SPDX-License-Identifier: LGPL-2.1-or-later */
#include <pthread.h>

#include "check_test_support.h"
#include "nnstreamer-single.h"
#include "wait_test_support.h"
#include "weir/custom_filter.h"

static int add_one(const weir_host* host, const weir_frame* in, weir_frame* out, void* data,
                   weir_error* error) {
  const float* x = (const float*)in->tensors[0].data;
  float* y = (float*)out->tensors[0].data;
  uint64_t i;
  (void)host, (void)data, (void)error;
  for (i = 0; i < in->tensors[0].bytes / sizeof *x; ++i) y[i] = x[i] + 1;
  return 0;
}

static pthread_mutex_t door = PTHREAD_MUTEX_INITIALIZER;

static int wait_at_the_door(const weir_host* host, const weir_frame* in, weir_frame* out,
                            void* data, weir_error* error) {
  pthread_mutex_lock(&door);
  pthread_mutex_unlock(&door);
  return add_one(host, in, out, data, error);
}

static int as_many_rows(const weir_host* host, const weir_tensor_info* in, uint32_t n_in,
                        weir_tensor_info* out, uint32_t n_out, void* data, weir_error* error) {
  (void)host, (void)n_in, (void)n_out, (void)data, (void)error;
  out[0].shape[0] = in[0].shape[0];
  return 0;
}

/* float32 (rows, 4) to the same; rows -1: open. */
static void register_filter(const char* name, int64_t rows, weir_filter_invoke invoke) {
  weir_tensor_info info;
  weir_filter filter;
  memset(&info, 0, sizeof info);
  memset(&filter, 0, sizeof filter);
  info.type = WEIR_FLOAT32;
  info.rank = 2;
  info.shape[0] = rows;
  info.shape[1] = 4;
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  filter.struct_size = sizeof filter;
  filter.n_inputs = filter.n_outputs = 1;
  filter.inputs = filter.outputs = &info;
  filter.invoke = invoke;
  filter.resolve = rows < 0 ? as_many_rows : NULL;
  CHECK(weir_filter_register(name, &filter, NULL) == 0);
}

static ml_tensors_data_h eight_floats(ml_tensors_info_h info) {
  static const float x[8] = {1, 2, 3, 4, 5, 6, 7, 8};
  ml_tensors_data_h data = NULL;
  OK(ml_tensors_data_create(info, &data));
  OK(ml_tensors_data_set_tensor_data(data, 0, x, sizeof x));
  return data;
}

static ml_single_h open_plus_one(void) {
  ml_single_h single = NULL;
  OK(ml_single_open(&single, "plus-one", NULL, NULL, ML_NNFW_TYPE_CUSTOM_FILTER, ML_NNFW_HW_ANY));
  return single;
}

static void a_model_is_invoked(void) {
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_FLOAT32, 4, 2);
  ml_tensors_data_h input = eight_floats(info), output = NULL, into = NULL;
  ml_single_h single = open_plus_one();
  const float *y, zero[8] = {0};
  OK(ml_single_invoke(single, input, &output));
  y = floats(output, 0, 8);
  CHECK(y && y[0] == 2 && y[7] == 9);
  /* Programs use the outputs of one invoke for the next. */
  OK(ml_tensors_data_set_tensor_data(output, 0, zero, sizeof zero));
  OK(ml_single_invoke_fast(single, input, output));
  CHECK(y && y[0] == 2 && y[7] == 9);
  OK(ml_tensors_data_create(info, &into));
  OK(ml_single_invoke_fast(single, input, into));
  y = floats(into, 0, 8);
  CHECK(y && y[0] == 2 && y[7] == 9);
  OK(ml_single_close(single));
  y = floats(output, 0, 8);
  CHECK(y && y[7] == 9);
  OK(ml_tensors_data_destroy(output));
  OK(ml_tensors_data_destroy(input));
  OK(ml_tensors_data_destroy(into));
  OK(ml_tensors_info_destroy(info));
}

static void expect_property(ml_single_h single, const char* name, const char* wanted) {
  char* text = NULL;
  OK(ml_single_get_property(single, name, &text));
  if (!text || strcmp(text, wanted) != 0) {
    REPORT("%s is %s, not %s\n", name, text ? text : "NULL", wanted);
    ++failed_checks;
  }
  free(text);
}

static void infos_are_the_models(void) {
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_FLOAT32, 4, 2), got = NULL;
  ml_tensor_dimension dimension;
  ml_tensor_type_e type;
  ml_single_h single = NULL;
  char* text = NULL;
  OK(ml_single_open(&single, "plus-one", info, info, ML_NNFW_TYPE_CUSTOM_FILTER, ML_NNFW_HW_CPU));
  OK(ml_single_get_input_info(single, &got));
  OK(ml_tensors_info_get_tensor_dimension(got, 0, dimension));
  OK(ml_tensors_info_get_tensor_type(got, 0, &type));
  CHECK(dimension[0] == 4 && dimension[1] == 2 && dimension[2] == 0);
  CHECK(type == ML_TENSOR_TYPE_FLOAT32);
  OK(ml_tensors_info_destroy(got));
  OK(ml_single_get_output_info(single, &got));
  OK(ml_tensors_info_get_tensor_dimension(got, 0, dimension));
  CHECK(dimension[0] == 4 && dimension[1] == 2);
  OK(ml_tensors_info_destroy(got));
  OK(ml_single_get_property(single, "framework", &text));
  CHECK(text && strcmp(text, "custom-easy") == 0);
  free(text);
  OK(ml_single_get_property(single, "accelerator", &text));
  CHECK(text && strcmp(text, "true:cpu") == 0);
  free(text);
  OK(ml_single_get_property(single, "inputtype", &text));
  CHECK(text && strcmp(text, "float32") == 0);
  free(text);
  OK(ml_single_close(single));
  single = open_plus_one();
  expect_property(single, "accelerator", "true:default");
  expect_property(single, "inputlayout", "ANY");
  expect_property(single, "custom", "");
  expect_property(single, "is-updatable", "false");
  OK(ml_single_set_property(single, "is-updatable", "TRUE"));
  OK(ml_single_set_property(single, "custom", "x:y"));
  expect_property(single, "custom", "");
  OK(ml_single_set_property(single, "inputtype", "FLOAT32"));
  OK(ml_single_set_property(single, "input", "4:2"));
  CHECK_REFUSED(ml_single_set_property(single, "is-updatable", "maybe"), ML_ERROR_INVALID_PARAMETER,
                "is-updatable is not a boolean");
  CHECK_REFUSED(ml_single_set_property(single, "inputtype", "uint8"), ML_ERROR_INVALID_PARAMETER,
                "uint8");
  CHECK_REFUSED(ml_single_set_property(single, "inputtype", "float"), ML_ERROR_INVALID_PARAMETER,
                "float");
  CHECK_REFUSED(ml_single_set_property(single, "input", "4:3"), ML_ERROR_NOT_SUPPORTED, "3");
  CHECK_REFUSED(ml_single_set_property(single, "nosuch", "1"), ML_ERROR_NOT_SUPPORTED,
                "no property has this name");
  expect_property(single, "input", "4:2");
  OK(ml_single_close(single));
  OK(ml_tensors_info_destroy(info));
}

static void open_dimensions_are_set(void) {
  ml_tensors_info_h three = make_info(ML_TENSOR_TYPE_FLOAT32, 4, 3), out_info = NULL;
  ml_tensors_info_h two = make_info(ML_TENSOR_TYPE_FLOAT32, 4, 2);
  ml_tensors_info_h other = make_info(ML_TENSOR_TYPE_FLOAT32, 5, 3);
  ml_tensors_data_h input = eight_floats(two), output = NULL;
  ml_tensor_dimension dimension;
  ml_single_h single = NULL;
  const float* y;
  char* text = NULL;
  OK(ml_single_open(&single, "any-rows", NULL, NULL, ML_NNFW_TYPE_CUSTOM_FILTER, ML_NNFW_HW_ANY));
  /* A dynamic invoke that fails leaves open dimensions open. */
  CHECK_REFUSED(ml_single_invoke_dynamic(single, input, three, &output, &out_info),
                ML_ERROR_INVALID_PARAMETER,
                "input 0 has a size that does not match the info of the model");
  OK(ml_single_invoke(single, input, &output));
  y = floats(output, 0, 8);
  CHECK(y && y[7] == 9);
  OK(ml_tensors_data_destroy(output));
  OK(ml_single_set_input_info(single, three));
  OK(ml_single_get_property(single, "input", &text));
  CHECK(text && strcmp(text, "4:3") == 0);
  free(text);
  OK(ml_single_set_property(single, "input", "4:7"));
  OK(ml_single_get_property(single, "input", &text));
  CHECK(text && strcmp(text, "4:7") == 0);
  free(text);
  OK(ml_single_invoke_dynamic(single, input, two, &output, &out_info));
  OK(ml_tensors_info_get_tensor_dimension(out_info, 0, dimension));
  CHECK(dimension[0] == 4 && dimension[1] == 2);
  y = floats(output, 0, 8);
  CHECK(y && y[7] == 9);
  OK(ml_tensors_data_destroy(output));
  OK(ml_tensors_info_destroy(out_info));
  CHECK_REFUSED(ml_single_set_input_info(single, other), ML_ERROR_INVALID_PARAMETER, "5");
  expect_property(single, "input", "4:2"); /* the inputs of a dynamic invoke stay */
  CHECK_REFUSED(
      ml_single_invoke_dynamic(single, input, three, &output, &out_info),
      ML_ERROR_INVALID_PARAMETER,
      "input 0 has a size that does not match the info of the model\n  offered: float32 4:2\n"
      "  needed: float32 4:3");
  expect_property(single, "input", "4:2"); /* unless it fails */
  CHECK_REFUSED(ml_single_set_property(single, "input", "4:3,4:3"), ML_ERROR_INVALID_PARAMETER,
                "the number of values differs from the number of inputs of the model");
  OK(ml_single_close(single));
  OK(ml_tensors_data_destroy(input));
  OK(ml_tensors_info_destroy(two));
  OK(ml_tensors_info_destroy(three));
  OK(ml_tensors_info_destroy(other));
}

static void wrong_models_and_words_are_refused(void) {
  ml_single_h single = NULL;
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_UINT8, 4, 2), empty = NULL;
  char* text = NULL;
  OK(ml_tensors_info_create(&empty));
  CHECK_REFUSED(ml_single_open(&single, "nosuch.so", NULL, NULL, ML_NNFW_TYPE_ANY, 0),
                ML_ERROR_INVALID_PARAMETER, "WEIR-3003");
  CHECK_REFUSED(ml_single_open(&single, "/tmp", NULL, NULL, ML_NNFW_TYPE_TENSORFLOW_LITE, 0),
                ML_ERROR_INVALID_PARAMETER, "the model is a folder");
  CHECK_REFUSED(ml_single_open(&single, "/etc/hostname", NULL, NULL, ML_NNFW_TYPE_ANY, 0),
                ML_ERROR_INVALID_PARAMETER, "hostname");
  CHECK_REFUSED(
      ml_single_open(&single, "/etc/hostname", NULL, NULL, ML_NNFW_TYPE_TENSORFLOW_LITE, 0),
      ML_ERROR_INVALID_PARAMETER, "the framework tensorflow-lite does not read this model file");
  CHECK_REFUSED(ml_single_open(&single, "nosuch", NULL, NULL, ML_NNFW_TYPE_CUSTOM_FILTER, 0),
                ML_ERROR_INVALID_PARAMETER, "nosuch");
  CHECK_REFUSED(ml_single_open(&single, "/etc/nosuch.dlc", NULL, NULL, ML_NNFW_TYPE_SNPE, 0),
                ML_ERROR_INVALID_PARAMETER, "WEIR-3003");
  CHECK_REFUSED(ml_single_open(&single, "/etc/hostname", NULL, NULL, ML_NNFW_TYPE_TVM, 0),
                ML_ERROR_NOT_SUPPORTED, "tvm");
  CHECK_REFUSED(
      ml_single_open(&single, "plus-one", NULL, NULL, ML_NNFW_TYPE_CUSTOM_FILTER, ML_NNFW_HW_NPU),
      ML_ERROR_NOT_SUPPORTED, "does not run on this hardware\n  offered: npu");
  CHECK_REFUSED(ml_single_open(&single, NULL, NULL, NULL, ML_NNFW_TYPE_ANY, 0),
                ML_ERROR_INVALID_PARAMETER, "model is a null pointer");
  CHECK_REFUSED(ml_single_open(NULL, "plus-one", NULL, NULL, ML_NNFW_TYPE_ANY, 0),
                ML_ERROR_INVALID_PARAMETER, "single is a null pointer");
  CHECK_REFUSED(ml_single_open(&single, "plus-one", NULL, NULL, (ml_nnfw_type_e)77, 0),
                ML_ERROR_INVALID_PARAMETER, "nnfw is not a value of ml_nnfw_type_e\n  offered: 77");
  CHECK_REFUSED(ml_single_open(&single, "plus-one", empty, NULL, ML_NNFW_TYPE_CUSTOM_FILTER, 0),
                ML_ERROR_INVALID_PARAMETER, "input_info describes no tensor");
  CHECK_REFUSED(ml_single_open(&single, "plus-one", info, NULL, ML_NNFW_TYPE_CUSTOM_FILTER, 0),
                ML_ERROR_INVALID_PARAMETER, "uint8");
  CHECK_REFUSED(ml_single_open(&single, "plus-one", NULL, info, ML_NNFW_TYPE_CUSTOM_FILTER, 0),
                ML_ERROR_INVALID_PARAMETER, "output_info differs from the outputs of the model");
  CHECK_REFUSED(ml_single_get_property(single, "framework", &text), ML_ERROR_INVALID_PARAMETER,
                "single is a null pointer");
  single = open_plus_one();
  text = (char*)"x";
  CHECK_REFUSED(ml_single_get_property(single, "inputtipe", &text), ML_ERROR_NOT_SUPPORTED,
                "did you mean inputtype?");
  CHECK(text == NULL);
  CHECK_REFUSED(ml_single_set_property(single, "custom", NULL), ML_ERROR_INVALID_PARAMETER,
                "null pointer");
  CHECK_REFUSED(ml_single_get_property(single, NULL, &text), ML_ERROR_INVALID_PARAMETER,
                "null pointer");
  OK(ml_single_close(single));
  CHECK_REFUSED(ml_single_close(single), ML_ERROR_INVALID_PARAMETER,
                "single is a handle that was destroyed or released");
  OK(ml_tensors_info_destroy(info));
  OK(ml_tensors_info_destroy(empty));
}

static void wrong_inputs_are_refused(void) {
  ml_tensors_info_h bytes = make_info(ML_TENSOR_TYPE_UINT8, 4, 2);
  ml_tensors_info_h long_row = make_info(ML_TENSOR_TYPE_FLOAT32, 5, 2);
  ml_tensors_data_h wrong_type = NULL, wrong_shape = NULL, output = NULL;
  ml_single_h single = open_plus_one();
  OK(ml_tensors_data_create(bytes, &wrong_type));
  OK(ml_tensors_data_create(long_row, &wrong_shape));
  CHECK_REFUSED(ml_single_invoke(single, wrong_type, &output), ML_ERROR_INVALID_PARAMETER, "uint8");
  CHECK(output == NULL);
  CHECK_REFUSED(ml_single_invoke(single, wrong_shape, &output), ML_ERROR_INVALID_PARAMETER,
                "WEIR-2004");
  CHECK_REFUSED(ml_single_invoke(single, NULL, &output), ML_ERROR_INVALID_PARAMETER,
                "input is a null pointer");
  CHECK_REFUSED(ml_single_invoke(single, wrong_type, NULL), ML_ERROR_INVALID_PARAMETER,
                "output is a null pointer");
  CHECK_REFUSED(ml_single_invoke(single, bytes, &output), ML_ERROR_INVALID_PARAMETER,
                "input is a handle of a different type");
  CHECK_REFUSED(ml_single_invoke(wrong_type, wrong_type, &output), ML_ERROR_INVALID_PARAMETER,
                "single is a handle of a different type");
  OK(ml_single_close(single));
  OK(ml_tensors_data_destroy(wrong_type));
  OK(ml_tensors_data_destroy(wrong_shape));
  OK(ml_tensors_info_destroy(bytes));
  OK(ml_tensors_info_destroy(long_row));
}

static void a_slow_model_runs_out_of_time(void) {
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_FLOAT32, 4, 2);
  ml_tensors_info_h longer = make_info(ML_TENSOR_TYPE_FLOAT32, 4, 3);
  ml_tensors_data_h input = eight_floats(info), output = NULL;
  ml_single_h single = NULL;
  OK(ml_single_open(&single, "slow", NULL, NULL, ML_NNFW_TYPE_CUSTOM_FILTER, ML_NNFW_HW_ANY));
  OK(ml_single_set_timeout(single, 20));
  pthread_mutex_lock(&door);
  CHECK_REFUSED(ml_single_invoke(single, input, &output), ML_ERROR_TIMED_OUT,
                "a result within 20 ms");
  CHECK_REFUSED(ml_single_invoke(single, input, &output), ML_ERROR_TRY_AGAIN,
                "the model is still running an invoke that timed out");
  CHECK_REFUSED(ml_single_set_input_info(single, longer), ML_ERROR_TRY_AGAIN,
                "the model is still running an invoke that timed out");
  pthread_mutex_unlock(&door);
  CHECK(output == NULL);
  OK(ml_single_close(single));
  OK(ml_tensors_data_destroy(input));
  OK(ml_tensors_info_destroy(info));
  OK(ml_tensors_info_destroy(longer));
}

/* The inputs before are set again when the invoke that goes on has ended. */
static void a_dynamic_invoke_runs_out_of_time(void) {
  ml_tensors_info_h three = make_info(ML_TENSOR_TYPE_FLOAT32, 4, 3), out_info = NULL;
  ml_tensors_info_h two = make_info(ML_TENSOR_TYPE_FLOAT32, 4, 2);
  ml_tensors_data_h eight = eight_floats(two), twelve = NULL, output = NULL;
  ml_single_h single = NULL;
  int result = ML_ERROR_TRY_AGAIN;
  OK(ml_tensors_data_create(three, &twelve));
  OK(ml_single_open(&single, "slow-rows", NULL, NULL, ML_NNFW_TYPE_CUSTOM_FILTER, ML_NNFW_HW_ANY));
  OK(ml_single_set_input_info(single, three));
  OK(ml_single_set_timeout(single, 20));
  pthread_mutex_lock(&door);
  CHECK_REFUSED(ml_single_invoke_dynamic(single, eight, two, &output, &out_info),
                ML_ERROR_TIMED_OUT, "a result within 20 ms");
  expect_property(single, "input", "4:3");
  CHECK_REFUSED(ml_single_invoke(single, twelve, &output), ML_ERROR_TRY_AGAIN,
                "the model is still running an invoke that timed out");
  pthread_mutex_unlock(&door);
  OK(ml_single_set_timeout(single, 0));
  while (result == ML_ERROR_TRY_AGAIN) result = ml_single_invoke(single, twelve, &output);
  CHECK(result == ML_ERROR_NONE);
  expect_property(single, "input", "4:3");
  OK(ml_single_close(single));
  OK(ml_tensors_data_destroy(output));
  OK(ml_tensors_data_destroy(eight));
  OK(ml_tensors_data_destroy(twelve));
  OK(ml_tensors_info_destroy(two));
  OK(ml_tensors_info_destroy(three));
}

static int count_outputs(const ml_tensors_data_h data, void* user_data) {
  const float* y = floats(data, 0, 8);
  CHECK(y && y[7] == 9);
  ++*(int*)user_data;
  return *(int*)user_data < 2 ? 0 : -1;
}

/* An option of ml_single_open_with_option for plus-one. */
static ml_option_h make_option(ml_nnfw_type_e* nnfw, ml_nnfw_hw_e* hw) {
  ml_option_h option = NULL;
  OK(ml_option_create(&option));
  OK(ml_option_set(option, "models", (void*)"plus-one", NULL));
  OK(ml_option_set(option, "nnfw", nnfw, NULL));
  OK(ml_option_set(option, "hw", hw, NULL));
  OK(ml_option_set(option, "unknown", hw, NULL));
  return option;
}

static void a_model_is_opened_with_options(void) {
  ml_nnfw_type_e nnfw = ML_NNFW_TYPE_CUSTOM_FILTER;
  ml_nnfw_hw_e hw = ML_NNFW_HW_CPU;
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_FLOAT32, 4, 2), got = NULL;
  ml_tensors_info_h bytes = make_info(ML_TENSOR_TYPE_UINT8, 4, 2);
  ml_option_h option = make_option(&nnfw, &hw);
  ml_tensors_data_h input = eight_floats(info), output = NULL;
  ml_single_h single = NULL;
  int calls = 0;
  OK(ml_option_set(option, "input_info", info, NULL));
  OK(ml_single_open_with_option(&single, option));
  expect_property(single, "accelerator", "true:cpu");
  OK(ml_single_get_input_info(single, &got));
  OK(ml_single_close(single));
  OK(ml_option_set(option, "input_info", bytes, NULL));
  CHECK_REFUSED(ml_single_open_with_option(&single, option), ML_ERROR_INVALID_PARAMETER, "uint8");
  OK(ml_option_destroy(option));
  /* A name wins over the number. */
  option = make_option(&nnfw, &hw);
  nnfw = ML_NNFW_TYPE_SNPE;
  OK(ml_option_set(option, "framework_name", (void*)"custom-easy", NULL));
  OK(ml_option_set(option, "invoke_async", (void*)"true", NULL));
  CHECK_REFUSED(ml_single_open_with_option(&single, option), ML_ERROR_INVALID_PARAMETER,
                "invoke_async needs a function\n  needed: the key async_callback");
  OK(ml_option_set(option, "async_callback", (void*)(intptr_t)count_outputs, NULL));
  OK(ml_option_set(option, "async_data", &calls, NULL));
  OK(ml_single_open_with_option(&single, option));
  OK(ml_single_invoke(single, input, &output));
  CHECK(calls == 1 && output == NULL);
  CHECK_REFUSED(ml_single_invoke(single, input, &output), ML_ERROR_STREAMS_PIPE,
                "async_callback returned -1");
  OK(ml_single_close(single));
  OK(ml_option_destroy(option));
  OK(ml_option_create(&option));
  CHECK_REFUSED(ml_single_open_with_option(&single, option), ML_ERROR_INVALID_PARAMETER,
                "the option names no model");
  CHECK_REFUSED(ml_single_open_with_option(&single, info), ML_ERROR_INVALID_PARAMETER,
                "option is a handle of a different type");
  CHECK_REFUSED(ml_single_open_with_option(NULL, option), ML_ERROR_INVALID_PARAMETER,
                "single is a null pointer");
  OK(ml_option_destroy(option));
  OK(ml_tensors_data_destroy(input));
  OK(ml_tensors_info_destroy(got));
  OK(ml_tensors_info_destroy(bytes));
  OK(ml_tensors_info_destroy(info));
}

/* The bytes count, not the type or the shape. */
static void inputs_of_the_right_size_are_taken(void) {
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_UINT8, 32, 0);
  ml_tensors_data_h input = eight_floats(info), output = NULL, into = NULL;
  ml_single_h single = open_plus_one();
  const float* y;
  OK(ml_single_invoke(single, input, &output));
  y = floats(output, 0, 8);
  CHECK(y && y[0] == 2 && y[7] == 9);
  OK(ml_tensors_data_create(info, &into));
  OK(ml_single_invoke_fast(single, input, into));
  y = floats(into, 0, 8);
  CHECK(y && y[7] == 9);
  OK(ml_single_close(single));
  OK(ml_tensors_data_destroy(into));
  OK(ml_tensors_data_destroy(output));
  OK(ml_tensors_data_destroy(input));
  OK(ml_tensors_info_destroy(info));
}

static Counter entered = COUNTER, released = COUNTER, finished = COUNTER;

static int wait_for_release(const weir_host* host, const weir_frame* in, weir_frame* out,
                            void* data, weir_error* error) {
  raise_count(&entered);
  wait_for(&released, 1);
  raise_count(&finished);
  return add_one(host, in, out, data, error);
}

typedef struct {
  ml_single_h single;
  ml_tensors_data_h input;
} Call;

static void* invoke_it(void* data) {
  const Call* call = data;
  ml_tensors_data_h output = NULL;
  OK(ml_single_invoke(call->single, call->input, &output));
  OK(ml_tensors_data_destroy(output));
  return NULL;
}

static void* close_it(void* single) {
  OK(ml_single_close(single));
  CHECK(get_count(&finished) == 1);
  return NULL;
}

static void a_close_waits_for_an_invoke(void) {
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_FLOAT32, 4, 2);
  Call call = {NULL, eight_floats(info)};
  pthread_t invoking, closing;
  int i;
  OK(ml_single_open(&call.single, "released", NULL, NULL, ML_NNFW_TYPE_CUSTOM_FILTER,
                    ML_NNFW_HW_ANY));
  CHECK(pthread_create(&invoking, NULL, invoke_it, &call) == 0);
  wait_for(&entered, 1);
  CHECK(pthread_create(&closing, NULL, close_it, call.single) == 0);
  for (i = 0; i < 1000; ++i) /* until the close has begun */
    while (ml_single_set_timeout(call.single, 0) == ML_ERROR_NONE) {
    }
  raise_count(&released);
  pthread_join(invoking, NULL);
  pthread_join(closing, NULL);
  CHECK_REFUSED(ml_single_set_timeout(call.single, 1), ML_ERROR_INVALID_PARAMETER, "was destroyed");
  OK(ml_tensors_data_destroy(call.input));
  OK(ml_tensors_info_destroy(info));
}

int main(void) {
  register_filter("plus-one", 2, add_one);
  register_filter("any-rows", -1, add_one);
  register_filter("slow", 2, wait_at_the_door);
  register_filter("slow-rows", -1, wait_at_the_door);
  register_filter("released", 2, wait_for_release);
  a_model_is_invoked();
  infos_are_the_models();
  open_dimensions_are_set();
  wrong_models_and_words_are_refused();
  wrong_inputs_are_refused();
  a_slow_model_runs_out_of_time();
  a_dynamic_invoke_runs_out_of_time();
  a_model_is_opened_with_options();
  inputs_of_the_right_size_are_taken();
  a_close_waits_for_an_invoke();
  return result_of_checks();
}
