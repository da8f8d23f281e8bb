/* An engine for benchmarks: copies uint8 of any length, the minimum work of an engine. */
/* SPDX-License-Identifier: LGPL-2.1-or-later */
#include <string.h>

#include "weir/abi.h"

static const weir_tensor_info tensor = {
    .type = WEIR_UINT8, .rank = 1, .shape = {-1}, .batch_axis = WEIR_NO_BATCH_AXIS};

static int open_model(const weir_open* request, weir_model** out, weir_error* error) {
  (void)request, (void)error;
  *out = (weir_model*)&tensor;
  return WEIR_OK;
}
static void close_model(weir_model* model) {
  (void)model;
}
static int info(weir_model* model, weir_model_info* out, weir_error* error) {
  (void)model, (void)error;
  out->n_inputs = out->n_outputs = 1;
  out->inputs = out->outputs = &tensor;
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
  out[0].shape[0] = in[0].shape[0];
  return WEIR_OK;
}
static int invoke(weir_session* session, const weir_frame* in, weir_frame* out, weir_error* error) {
  (void)session, (void)error;
  memcpy(out->tensors[0].data, in->tensors[0].data, in->tensors[0].bytes);
  return WEIR_OK;
}

static const weir_engine engine = {.struct_size = sizeof engine,
                                   .abi_major = WEIR_ABI_MAJOR,
                                   .abi_minor = WEIR_ABI_MINOR,
                                   .name = "identity",
                                   .version = "1",
                                   .flags = WEIR_ENGINE_NEEDS_NO_MODEL,
                                   .open = open_model,
                                   .close = close_model,
                                   .info = info,
                                   .session_new = session_new,
                                   .session_free = session_free,
                                   .resolve = resolve,
                                   .invoke = invoke};
static const weir_engine* const engines[] = {&engine, NULL};
static const weir_module module = {.struct_size = sizeof module,
                                   .abi_major = WEIR_ABI_MAJOR,
                                   .abi_minor = WEIR_ABI_MINOR,
                                   .engines = engines};

__attribute__((visibility("default"))) const weir_module* weir_module_entry(const weir_host* host) {
  (void)host;
  return &module;
}
