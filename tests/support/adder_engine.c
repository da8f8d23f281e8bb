/* An engine in C11 for tests of the model lifecycle: y = x + ADD on float32 [-1, WIDTH]. The
 * model's file contains "ADD WIDTH", followed by "gate" for a model whose opening waits for a byte
 * from the pipe gate:FD. Events are reported as bytes to the pipe events:FD: o opened, g waits at
 * the gate, c closed, s suspended, r resumed. Options: sleeps:yes (supports suspend), sessions:N
 * (max_sessions), parallel:N (max_in_flight), fail:N (the model that adds N fails in each invoke),
 * outcomes:yes (a frame that begins with -1, -2 or -3 is late, refused or lost). It reports an
 * execution on three spinning threads.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "one_engine.h"
#include "weir/abi.h"

struct weir_model {
  weir_tensor_info tensor;
  float add;
  int events, sleeps, outcomes;
  long fail;
  uint32_t sessions, parallel;
};

static void report(const weir_model* model, char what) {
  if (model->events < 0) return;
  const ssize_t written = write(model->events, &what, 1);
  (void)written;
}

static int open_model(const weir_open* request, weir_model** out, weir_error* error) {
  weir_model* model = calloc(1, sizeof *model);
  if (!model) return host->fail(error, WEIR_OUT_OF_MEMORY, "no memory", NULL, NULL, NULL, NULL);
  model->events = -1;
  model->fail = -1;
  int gate = -1;
  for (uint32_t i = 0; i < request->n_options; ++i) {
    const char *key = request->options[i].key, *value = request->options[i].value;
    if (strcmp(key, "events") == 0) model->events = (int)strtol(value, NULL, 10);
    if (strcmp(key, "gate") == 0) gate = (int)strtol(value, NULL, 10);
    if (strcmp(key, "sleeps") == 0) model->sleeps = 1;
    if (strcmp(key, "sessions") == 0) model->sessions = (uint32_t)strtoul(value, NULL, 10);
    if (strcmp(key, "parallel") == 0) model->parallel = (uint32_t)strtoul(value, NULL, 10);
    if (strcmp(key, "outcomes") == 0) model->outcomes = 1;
    if (strcmp(key, "fail") == 0) model->fail = strtol(value, NULL, 10);
  }
  char text[64] = "", word[16] = "";
  FILE* file = fopen(request->paths[0], "r");
  if (file && !fgets(text, sizeof text, file)) text[0] = 0;
  if (file) fclose(file);
  long width = 0;
  if (sscanf(text, "%f %ld %15s", &model->add, &width, word) < 2) {
    free(model);
    return host->fail(error, WEIR_MODEL_INVALID, "no model of the adder", text, "ADD WIDTH", NULL,
                      NULL);
  }
  const int gated = strcmp(word, "gate") == 0;
  char byte;
  if (gated) report(model, 'g');
  if (gated && read(gate, &byte, 1) != 1) {
    free(model);
    return host->fail(error, WEIR_MODEL_INVALID, "the gate is closed", NULL, NULL, NULL, NULL);
  }
  model->tensor.type = WEIR_FLOAT32;
  model->tensor.rank = 2;
  model->tensor.shape[0] = -1;
  model->tensor.shape[1] = width;
  model->tensor.name = "x";
  model->tensor.batch_axis = WEIR_NO_BATCH_AXIS;
  report(model, 'o');
  *out = model;
  return WEIR_OK;
}

static void close_model(weir_model* model) {
  report(model, 'c');
  free(model);
}

static int info(weir_model* model, weir_model_info* out, weir_error* error) {
  (void)error;
  out->flags = WEIR_MODEL_THREAD_SAFE; /* invoke modifies nothing */
  out->n_inputs = out->n_outputs = 1;
  out->inputs = out->outputs = &model->tensor;
  out->max_sessions = model->sessions;
  out->max_in_flight = model->parallel;
  out->weight_bytes = 1000;
  return WEIR_OK;
}

static int session_new(weir_model* model, const weir_option* options, uint32_t n,
                       weir_session** out, weir_error* error) {
  (void)options, (void)n, (void)error;
  *out = (weir_session*)model;
  return WEIR_OK;
}
static void session_free(weir_session* session) {
  (void)session;
}

static int resolve(weir_session* session, const weir_tensor_info* in, uint32_t n_in,
                   weir_tensor_info* out, uint32_t n_out, weir_error* error) {
  (void)session, (void)n_in, (void)n_out, (void)error;
  out->shape[0] = in->shape[0];
  return WEIR_OK;
}

static int invoke(weir_session* session, const weir_frame* in, weir_frame* out, weir_error* error) {
  const weir_model* model = (const weir_model*)session;
  const float* x = in->tensors[0].data;
  float* y = out->tensors[0].data;
  if ((long)model->add == model->fail)
    return host->fail(error, WEIR_INVOKE_FAILED, "ordered to fail", NULL, NULL, NULL, NULL);
  if (model->outcomes && x[0] == -1) return WEIR_RESULT_LATE;
  if (model->outcomes && x[0] == -2) return WEIR_RESULT_REFUSED;
  if (model->outcomes && x[0] == -3) return WEIR_RESULT_LOST;
  for (uint64_t i = 0; i < in->tensors[0].bytes / sizeof *x; ++i) y[i] = x[i] + model->add;
  return WEIR_OK;
}

static int control(weir_session* session, int op, const weir_option* option, weir_error* error) {
  (void)option;
  const weir_model* model = (const weir_model*)session;
  if (!model->sleeps || (op != WEIR_SUSPEND && op != WEIR_RESUME))
    return host->fail(error, WEIR_MODEL_UNSUPPORTED, "not known here", NULL, NULL, NULL, NULL);
  report(model, op == WEIR_SUSPEND ? 's' : 'r');
  return WEIR_OK;
}

static int describe_execution(weir_model* model, weir_execution* out) {
  (void)model;
  out->threads = 3;
  out->spins = 1;
  return WEIR_OK;
}

static const weir_execution_calls execution_calls = {sizeof execution_calls, describe_execution};

static const void* extension(const char* id) {
  if (strcmp(id, WEIR_EXECUTION) == 0) return &execution_calls;
  return strcmp(id, "weir.accelerators/1") == 0 ? "gpu,cpu" : NULL;
}

static const weir_engine engine = {
    .struct_size = sizeof engine,
    .abi_major = WEIR_ABI_MAJOR,
    .abi_minor = WEIR_ABI_MINOR,
    .name = "adder",
    .version = "1",
    .open = open_model,
    .close = close_model,
    .info = info,
    .session_new = session_new,
    .session_free = session_free,
    .resolve = resolve,
    .invoke = invoke,
    .control = control,
    .extension = extension,
};
