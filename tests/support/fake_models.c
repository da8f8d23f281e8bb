/* An engine with models of many shapes for the tests of `weir inspect`. The name of the model's
 * file selects one; each invoke returns zeros.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <stdlib.h>
#include <string.h>

#include "one_engine.h"

struct weir_model {
  uint32_t n_inputs;
  weir_tensor_info inputs[2], output;
  const char* metadata;
};
struct weir_session {
  struct weir_model* model;
};

static weir_tensor_info tensor(const char* name, uint32_t type, uint32_t layout, uint32_t rank,
                               const int64_t* shape) {
  weir_tensor_info out = {
      .type = type, .rank = rank, .name = name, .layout = layout, .batch_axis = WEIR_NO_BATCH_AXIS};
  memcpy(out.shape, shape, rank * sizeof *shape);
  return out;
}

/* A picture of any size, quantised; 0 when there is no such model. */
static int choose(struct weir_model* model, const char* path) {
  model->n_inputs = 1;
  if (strstr(path, "quantised")) {
    model->inputs[0] =
        tensor("picture", WEIR_UINT8, WEIR_LAYOUT_NHWC, 4, (int64_t[]){1, -1, -1, 3});
    model->inputs[0].scale = 0.0078125f;
    model->inputs[0].zero_point = 128;
    model->metadata =
        "{\"description\": \"made for\\ttests\\u001b[31m\", \"author\": \"\", \"classes\": [1, 2],"
        " \"licence\": "
        "\"aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"
        "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa "
        "end\"}";
  } else if (strstr(path, "planar")) {
    model->inputs[0] =
        tensor("picture", WEIR_FLOAT32, WEIR_LAYOUT_NCHW, 4, (int64_t[]){1, 3, 16, 24});
    model->metadata = "no JSON";
  } else if (strstr(path, "signed")) {
    model->inputs[0] = tensor("", WEIR_INT8, WEIR_LAYOUT_NHWC, 4, (int64_t[]){2, 8, 8, 1});
  } else if (strstr(path, "several")) {
    model->n_inputs = 2;
    model->inputs[0] = tensor("words", WEIR_INT16, WEIR_LAYOUT_NONE, 2, (int64_t[]){2, 3});
    model->inputs[1] = tensor("weights", WEIR_FLOAT64, WEIR_LAYOUT_NONE, 1, (int64_t[]){4});
  } else {
    return 0;
  }
  model->output = tensor("classes", WEIR_UINT8, WEIR_LAYOUT_NONE, 2, (int64_t[]){1, 5});
  return 1;
}

static int open_model(const weir_open* request, weir_model** out, weir_error* error) {
  struct weir_model* model = calloc(1, sizeof *model);
  if (!model) return host->fail(error, WEIR_OUT_OF_MEMORY, "no memory", NULL, NULL, NULL, NULL);
  if (!choose(model, strrchr(request->paths[0], '/') + 1)) {
    free(model);
    return host->fail(error, WEIR_MODEL_INVALID, "no model of mine", request->paths[0], NULL, NULL,
                      NULL);
  }
  *out = model;
  return WEIR_OK;
}

static void close_model(weir_model* model) {
  free(model);
}

static int info(weir_model* model, weir_model_info* out, weir_error* error) {
  (void)error;
  out->n_inputs = model->n_inputs;
  out->n_outputs = 1;
  out->inputs = model->inputs;
  out->outputs = &model->output;
  out->metadata_json = model->metadata;
  return WEIR_OK;
}

static int session_new(weir_model* model, const weir_option* options, uint32_t n,
                       weir_session** out, weir_error* error) {
  (void)options, (void)n;
  *out = calloc(1, sizeof **out);
  if (!*out) return host->fail(error, WEIR_OUT_OF_MEMORY, "no memory", NULL, NULL, NULL, NULL);
  (*out)->model = model;
  return WEIR_OK;
}

static void session_free(weir_session* session) {
  free(session);
}

static int invoke(weir_session* session, const weir_frame* in, weir_frame* out, weir_error* error) {
  if (in->n_tensors != session->model->n_inputs)
    return host->fail(error, WEIR_SPEC_MISMATCH, "another number of tensors", NULL, NULL, NULL,
                      NULL);
  memset(out->tensors[0].data, 0, out->tensors[0].bytes);
  return WEIR_OK;
}

static const weir_engine engine = {
    .struct_size = sizeof engine,
    .abi_major = WEIR_ABI_MAJOR,
    .abi_minor = WEIR_ABI_MINOR,
    .name = "fake-models",
    .version = "3.1",
    .open = open_model,
    .close = close_model,
    .info = info,
    .session_new = session_new,
    .session_free = session_free,
    .invoke = invoke,
};
