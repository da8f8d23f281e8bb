/* The C API of models in C11: the fake engine's y = x + 1, the parts of an error, the limits. */
/* SPDX-License-Identifier: LGPL-2.1-or-later */
#include <stdio.h>
#include <string.h>

#include "weir/model.h"

#define CHECK(condition)                                               \
  do {                                                                 \
    if (!(condition)) {                                                \
      printf("%s:%d: not true: %s\n", __FILE__, __LINE__, #condition); \
      return 1;                                                        \
    }                                                                  \
  } while (0)

int main(void) {
  weir_model_options options = WEIR_MODEL_OPTIONS_INIT;
  weir_loaded_model* model = NULL;
  weir_error* error = NULL;
  options.engine = "nosuch";
  CHECK(weir_model_open(&options, &model, &error) == -WEIR_ENGINE_UNKNOWN);
  CHECK(model == NULL && weir_error_code(error) == WEIR_ENGINE_UNKNOWN);
  CHECK(strstr(weir_error_message(error), "WEIR-3001: no engine has this name\n  offered: "));
  CHECK(strcmp(weir_error_offered(error), "framework=nosuch") == 0);
  weir_error_free(error);
  CHECK(weir_model_open(&options, &model, NULL) == -WEIR_ENGINE_UNKNOWN);

  options.engine = "fake";
  options.timeout_ns = 60 * INT64_C(1000000000);
  CHECK(weir_model_open(&options, &model, &error) == WEIR_OK && error == NULL);
  CHECK(strcmp(weir_model_engine(model), "fake") == 0);
  CHECK(strcmp(weir_model_engine_version(model), "1") == 0 && !weir_model_metadata(model));
  CHECK(weir_model_input_count(model) == 1 && weir_model_output_count(model) == 1);
  weir_tensor_info info;
  CHECK(weir_model_input(model, 0, &info) == WEIR_OK);
  CHECK(strcmp(info.name, "x") == 0 && info.rank == 2 && info.shape[0] == -1);
  CHECK(weir_model_input(model, 1, &info) == -WEIR_OPTION_VALUE);
  CHECK(weir_model_output(model, 0, NULL) == -WEIR_OPTION_VALUE);

  const float x[8] = {1, 2, 3, 4, 5, 6, 7, 8};
  weir_tensor input = weir_tensor_of(x, sizeof x, WEIR_FLOAT32);
  weir_results* results = NULL;
  CHECK(weir_model_invoke(model, &input, 1, &results, &error) == -WEIR_SPEC_MISMATCH);
  CHECK(strcmp(weir_error_fix(error), "model.reshape({{1, 4}})") == 0 && results == NULL);
  weir_error_free(error);

  info.type = WEIR_TYPE_END;
  info.shape[0] = 2;
  CHECK(weir_model_reshape(model, &info, 1, &error) == WEIR_OK);
  CHECK(weir_model_invoke(model, &input, 1, &results, &error) == WEIR_OK);
  CHECK(weir_results_count(results) == 1 && weir_results_frames(results) == 1);
  weir_tensor output;
  CHECK(weir_results_tensor(results, 0, &output) == WEIR_OK);
  CHECK(output.bytes == sizeof x && ((const float*)output.data)[7] == 9);
  CHECK(output.info.rank == 2 && output.info.shape[0] == 2);
  CHECK(weir_results_tensor(results, 1, &output) == -WEIR_OPTION_VALUE);
  weir_results_free(results);

  const weir_tensor frames[2] = {weir_tensor_of(x, 16, WEIR_FLOAT32),
                                 weir_tensor_of(x + 4, 16, WEIR_FLOAT32)};
  CHECK(weir_model_invoke_batch(model, frames, 2, 2, &results, &error) == WEIR_OK);
  CHECK(weir_results_frames(results) == 2);
  CHECK(weir_results_frame_tensor(results, 1, 0, &output) == WEIR_OK);
  CHECK(output.bytes == 16 && ((const float*)output.data)[0] == 6);
  CHECK(weir_results_frame_tensor(results, 2, 0, &output) == -WEIR_OPTION_VALUE);
  weir_model_close(model);
  CHECK(((const float*)output.data)[3] == 9);
  weir_results_free(results);
  return 0;
}
