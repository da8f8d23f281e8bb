/* Modules that must be rejected: one is built for each WEIR_BAD_... that the build defines. */
/* SPDX-License-Identifier: LGPL-2.1-or-later */
#include <stddef.h>

#include "weir/abi.h"

#ifdef WEIR_BAD_SYMBOL
__attribute__((visibility("default"))) const int weir_module_entrance = 1;
#else

static int open_model(const weir_open* request, weir_model** out, weir_error* error) {
  (void)request, (void)out, (void)error;
  return -WEIR_MODEL_INVALID;
}
static void close_model(weir_model* model) {
  (void)model;
}
static int info(weir_model* model, weir_model_info* out, weir_error* error) {
  (void)model, (void)out, (void)error;
  return -WEIR_MODEL_INVALID;
}
static int session_new(weir_model* model, const weir_option* options, uint32_t n,
                       weir_session** out, weir_error* error) {
  (void)model, (void)options, (void)n, (void)out, (void)error;
  return -WEIR_MODEL_INVALID;
}
static void session_free(weir_session* session) {
  (void)session;
}
static int invoke(weir_session* session, const weir_frame* in, weir_frame* out, weir_error* error) {
  (void)session, (void)in, (void)out, (void)error;
  return -WEIR_INVOKE_FAILED;
}

static const weir_engine engine = {
#ifdef WEIR_BAD_ENGINE_SIZE
    .struct_size = 16,
#else
    .struct_size = sizeof(weir_engine),
#endif
    .abi_major = WEIR_ABI_MAJOR,
#ifndef WEIR_BAD_ENGINE_NAME
    .name = "bad",
#endif
    .open = open_model,
    .close = close_model,
    .info = info,
    .session_new = session_new,
    .session_free = session_free,
#ifndef WEIR_BAD_ENGINE_FUNCTIONS
    .invoke = invoke,
#endif
};
static const weir_engine* const engines[] = {
#ifndef WEIR_BAD_EMPTY
    &engine,
#endif
    NULL};
static const weir_module module = {
#ifdef WEIR_BAD_SIZE
    .struct_size = 8,
#else
    .struct_size = sizeof(weir_module),
#endif
#ifdef WEIR_BAD_VERSION
    .abi_major = WEIR_ABI_MAJOR + 1,
#else
    .abi_major = WEIR_ABI_MAJOR,
#endif
    .engines = engines};

__attribute__((visibility("default"))) const weir_module* weir_module_entry(const weir_host* host) {
  (void)host, (void)engine, (void)invoke;
#ifdef WEIR_BAD_NOTHING
  (void)module;
  return NULL;
#else
  return &module;
#endif
}
#endif
