/* Opens a model with the engine found by its name or the given one, runs it once on zeros, and
 * prints the size of each output in bytes.
 *
 *   model_once MODEL [ENGINE]
 *   cc -std=c11 model_once.c -o model_once $(pkg-config --cflags --libs weir)
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "weir/model.h"

static int complain(weir_error* error) {
  fprintf(stderr, "%s\n", weir_error_message(error));
  weir_error_free(error);
  return 1;
}

/* Runs on zeros; weir_model_reshape has fixed all input shapes. */
static int run(weir_loaded_model* model) {
  const uint32_t n = weir_model_input_count(model);
  weir_tensor_info* infos = calloc(n + 1, sizeof *infos);
  weir_tensor* inputs = calloc(n + 1, sizeof *inputs);
  weir_results* results = NULL;
  weir_error* error = NULL;
  int result = infos && inputs ? 0 : -WEIR_OUT_OF_MEMORY;
  for (uint32_t i = 0; i < n && result == 0; ++i) {
    weir_model_input(model, i, &infos[i]);
    for (uint32_t axis = 0; infos[i].rank <= WEIR_RANK_LIMIT && axis < infos[i].rank; ++axis)
      if (infos[i].shape[axis] < 1) infos[i].shape[axis] = 1;
  }
  if (result == 0) result = weir_model_reshape(model, infos, n, &error);
  for (uint32_t i = 0; i < n && result == 0; ++i) {
    static const uint8_t element_bytes[] = {4, 4, 2, 2, 1, 1, 8, 4, 8, 8, 2}; /* by weir_type */
    weir_model_input(model, i, &infos[i]);
    uint64_t bytes = element_bytes[infos[i].type];
    for (uint32_t axis = 0; axis < infos[i].rank; ++axis) bytes *= (uint64_t)infos[i].shape[axis];
    inputs[i] = weir_tensor_of(calloc(1, bytes), bytes, infos[i].type);
    printf("input %s: %" PRIu64 " bytes\n", infos[i].name ? infos[i].name : "", bytes);
  }
  if (result == 0) result = weir_model_invoke(model, inputs, n, &results, &error);
  for (uint32_t i = 0; result == 0 && i < weir_results_count(results); ++i) {
    weir_tensor output;
    weir_results_tensor(results, i, &output);
    printf("output %s: %" PRIu64 " bytes\n", output.info.name, output.bytes);
  }
  for (uint32_t i = 0; inputs && i < n; ++i) free(inputs[i].data);
  weir_results_free(results);
  free(inputs);
  free(infos);
  return result < 0 ? complain(error) : 0;
}

int main(int argc, char** argv) {
  weir_model_options options = WEIR_MODEL_OPTIONS_INIT;
  weir_loaded_model* model = NULL;
  weir_error* error = NULL;
  const char* path = argc > 1 ? argv[1] : "";
  options.paths = &path;
  options.n_paths = 1;
  options.engine = argc > 2 ? argv[2] : NULL;
  options.timeout_ns = INT64_C(30000000000);
  if (argc < 2) return fprintf(stderr, "model_once MODEL [ENGINE]\n"), 2;
  if (weir_model_open(&options, &model, &error) < 0) return complain(error);
  printf("engine: %s\n", weir_model_engine(model));
  const int result = run(model);
  weir_model_close(model);
  return result;
}
