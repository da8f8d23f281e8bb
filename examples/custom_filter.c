/* A C program that registers its own filter and uses it in a pipeline: y = x + step, for four
 * values.
 *
 *   custom_filter 'tensor_filter framework=custom-easy model=step'
 *   cc -std=c11 custom_filter.c $(pkg-config --cflags --libs weir weir-pipeline)
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include "weir/custom_filter.h"

#include <stdio.h>

#include "weir/pipeline.h"

enum { kNumbers = 4 };

/* The sizes are already checked: four values in, memory for four values out. */
static int add_step(const weir_host* host, const weir_frame* in, weir_frame* out, void* data,
                    weir_error* error) {
  const float* x = in->tensors[0].data;
  float* y = out->tensors[0].data;
  const float step = *(const float*)data;
  for (int i = 0; i < kNumbers; ++i) {
    if (x[i] != x[i])
      return host->fail(error, WEIR_CALLBACK_FAILED, "a value is not a number", "NaN", "numbers",
                        NULL, NULL);
    y[i] = x[i] + step;
  }
  return 0;
}

static int complain(weir_error* error) {
  fprintf(stderr, "%s\n", weir_error_message(error));
  weir_error_free(error);
  return 1;
}

static int register_step(float* step, weir_error** error) {
  const weir_tensor_info four = {.type = WEIR_FLOAT32, .rank = 1, .shape = {kNumbers}, .name = "x"};
  const weir_filter filter = {.struct_size = sizeof filter,
                              .n_inputs = 1,
                              .n_outputs = 1,
                              .inputs = &four,
                              .outputs = &four,
                              .invoke = add_step,
                              .data = step};
  return weir_filter_register("step", &filter, error);
}

static int pull_all(weir_pipeline* pipeline, weir_error** error) {
  for (;;) {
    weir_pulled* frame = NULL;
    weir_tensor tensor;
    const int result = weir_pipeline_pull(pipeline, "out", -1, &frame, error);
    if (result != WEIR_PIPELINE_DONE) return result;
    weir_pulled_tensor(frame, 0, &tensor);
    for (size_t i = 0; i < tensor.bytes / sizeof(float); ++i)
      printf("%g ", (double)((const float*)tensor.data)[i]);
    printf("\n");
    weir_pulled_free(frame);
  }
}

static int run(weir_pipeline* pipeline, weir_error** error) {
  float values[kNumbers] = {1, 2, 3, 4};
  weir_tensor tensor = {.data = values, .bytes = sizeof values, .capacity = sizeof values};
  tensor.info.type = WEIR_FLOAT32;
  tensor.info.rank = 1;
  tensor.info.shape[0] = kNumbers;
  tensor.info.batch_axis = WEIR_NO_BATCH_AXIS;
  int result = weir_pipeline_start(pipeline, error);
  if (result == 0) result = weir_pipeline_push(pipeline, "in", &tensor, 1, -1, -1, error);
  if (result == 0) result = weir_pipeline_end(pipeline, "in", error);
  return result == 0 ? pull_all(pipeline, error) : result;
}

int main(int argc, char** argv) {
  char text[512];
  float step = 10;
  weir_error* error = NULL;
  weir_pipeline* pipeline = NULL;
  if (argc != 2) return fprintf(stderr, "custom_filter 'tensor_filter ...'\n"), 2;
  if (register_step(&step, &error) < 0) return complain(error);
  if (register_step(&step, NULL) >= 0) return 3; /* the name is in use */
  snprintf(text, sizeof text, "appsrc name=in ! %s ! tensor_sink name=out", argv[1]);
  if (weir_pipeline_parse(text, &pipeline, &error) < 0) return complain(error);
  const int result = run(pipeline, &error);
  weir_pipeline_free(pipeline);
  if (result < 0) return complain(error);
  return weir_filter_unregister("step") == 0 ? 0 : 4;
}
