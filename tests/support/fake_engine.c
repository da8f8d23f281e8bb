/* An engine in C11 for tests, as a user would write one: y = x + 1 on float32 [-1, 4].
 * Options: fail-at:N (that invoke fails), drop-at:N (that invoke drops its frame), alignment:N and
 * padding:N (required, and checked in each invoke), rows:N (float32 [N, 4], no other length),
 * stateful:1 (declares that it keeps state), show-deadline:1 (y = the frame's deadline in ms),
 * show-expiry:1 (y = 1 if the frame expires, otherwise 0).
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <stdlib.h>
#include <string.h>

#include "one_engine.h"

struct weir_model {
  weir_tensor_info input, output;
  long fail_at, drop_at;
  uint32_t alignment, padding, flags;
  int shows_deadline, shows_expiry;
};
struct weir_session {
  struct weir_model* model;
  long invokes;
};

static int open_model(const weir_open* request, weir_model** out, weir_error* error) {
  weir_model* model = calloc(1, sizeof *model);
  if (!model) return host->fail(error, WEIR_OUT_OF_MEMORY, "no memory", NULL, NULL, NULL, NULL);
  model->fail_at = model->drop_at = -1;
  model->input.shape[0] = -1;
  for (uint32_t i = 0; i < request->n_options; ++i) {
    if (strcmp(request->options[i].key, "rows") == 0)
      model->input.shape[0] = strtol(request->options[i].value, NULL, 10);
    if (strcmp(request->options[i].key, "stateful") == 0) model->flags = WEIR_MODEL_STATEFUL;
    if (strcmp(request->options[i].key, "fail-at") == 0)
      model->fail_at = strtol(request->options[i].value, NULL, 10);
    if (strcmp(request->options[i].key, "drop-at") == 0)
      model->drop_at = strtol(request->options[i].value, NULL, 10);
    if (strcmp(request->options[i].key, "alignment") == 0)
      model->alignment = (uint32_t)strtoul(request->options[i].value, NULL, 10);
    if (strcmp(request->options[i].key, "padding") == 0)
      model->padding = (uint32_t)strtoul(request->options[i].value, NULL, 10);
    if (strcmp(request->options[i].key, "show-deadline") == 0) model->shows_deadline = 1;
    if (strcmp(request->options[i].key, "show-expiry") == 0) model->shows_expiry = 1;
  }
  model->input.type = WEIR_FLOAT32;
  model->input.rank = 2;
  model->input.shape[1] = 4;
  model->input.name = "x";
  model->input.batch_axis = WEIR_NO_BATCH_AXIS;
  model->output = model->input;
  model->output.name = "y";
  *out = model;
  return WEIR_OK;
}

static void close_model(weir_model* model) {
  free(model);
}

static int info(weir_model* model, weir_model_info* out, weir_error* error) {
  (void)error;
  out->n_inputs = out->n_outputs = 1;
  out->inputs = &model->input;
  out->outputs = &model->output;
  out->flags = model->flags;
  out->alignment = model->alignment;
  out->input_padding = model->padding;
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

static int resolve(weir_session* session, const weir_tensor_info* in, uint32_t n_in,
                   weir_tensor_info* out, uint32_t n_out, weir_error* error) {
  if (n_in != 1 || n_out != 1)
    return host->fail(error, WEIR_SPEC_MISMATCH, "one tensor in, one out", NULL, NULL, NULL, NULL);
  const int64_t rows = session->model->input.shape[0];
  if (rows >= 0 && in->shape[0] != rows)
    return host->fail(error, WEIR_SPEC_MISMATCH, "another number of rows", NULL, NULL, NULL, NULL);
  out->shape[0] = in->shape[0];
  return WEIR_OK;
}

static int invoke(weir_session* session, const weir_frame* in, weir_frame* out, weir_error* error) {
  const long number = session->invokes++;
  const float* x = in->tensors[0].data;
  float* y = out->tensors[0].data;
  if (number == session->model->fail_at)
    return host->fail(error, WEIR_INVOKE_FAILED, "ordered to fail", NULL, NULL, NULL,
                      "drop the option");
  if (number == session->model->drop_at) return 1;
  const int64_t rows = session->model->input.shape[0];
  if (rows >= 0 && in->tensors[0].bytes != (uint64_t)rows * 4 * sizeof *x)
    return host->fail(error, WEIR_INVOKE_FAILED, "another number of rows", NULL, NULL, NULL, NULL);
  const uint32_t alignment = session->model->alignment ? session->model->alignment : 1;
  if ((uintptr_t)x % alignment != 0 ||
      in->tensors[0].capacity < in->tensors[0].bytes + session->model->padding)
    return host->fail(error, WEIR_INVOKE_FAILED, "memory that was not requested", NULL, NULL, NULL,
                      NULL);
  const float deadline = in->deadline < 0 ? -1.f : (float)in->deadline / 1e6f;
  for (uint64_t i = 0; i < in->tensors[0].bytes / sizeof *x; ++i) {
    y[i] = session->model->shows_deadline ? deadline : x[i] + 1;
    if (session->model->shows_expiry) y[i] = in->expires > 0;
  }
  return WEIR_OK;
}

static const weir_engine engine = {
    .struct_size = sizeof engine,
    .abi_major = WEIR_ABI_MAJOR,
    .abi_minor = WEIR_ABI_MINOR,
    .name = "fake",
    .version = "1",
    .open = open_model,
    .close = close_model,
    .info = info,
    .session_new = session_new,
    .session_free = session_free,
    .resolve = resolve,
    .invoke = invoke,
};
