/* A third-party engine in C that uses every part of the interface. In: float32 of any length. Out:
 * "scaled", the input times `factor`; "positive", all values above 0.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#define _POSIX_C_SOURCE 200809L
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <weir/abi.h>

static const weir_host* host;

struct weir_model {
  weir_tensor_info input, outputs[2];
  float factor;
  int repeat, rest;
};
struct weir_session {
  struct weir_model* model;
  pthread_t thread; /* thread of the current request */
  int started;
  const weir_frame* in;
  weir_request* request;
  pthread_mutex_t mutex; /* guards the members below */
  pthread_cond_t changed;
  weir_request* cancelled; /* the last cancelled request */
};

static int number(const weir_option* option, float* value, weir_error* error) {
  char* end = NULL;
  *value = strtof(option->value, &end);
  if (*option->value && !*end) return WEIR_OK;
  return host->fail(error, WEIR_OPTION_VALUE, "an option is no number", option->value, "a number",
                    NULL, "custom=factor:2.5");
}

static int open_model(const weir_open* request, weir_model** out, weir_error* error) {
  weir_model* model = calloc(1, sizeof *model);
  *out = NULL;
  if (!model) return -WEIR_OUT_OF_MEMORY;
  model->factor = 1;
  model->repeat = 1;
  for (uint32_t i = 0; i < request->n_options; ++i) {
    float value = 0;
    const int result = number(&request->options[i], &value, error);
    if (result < 0) {
      free(model);
      return result;
    }
    if (strcmp(request->options[i].key, "factor") == 0) model->factor = value;
    if (strcmp(request->options[i].key, "repeat") == 0) model->repeat = (int)value;
    if (strcmp(request->options[i].key, "rest") == 0) model->rest = (int)value;
  }
  weir_tensor_info values = {.type = WEIR_FLOAT32,
                             .rank = 1,
                             .shape = {-1},
                             .name = "x",
                             .batch_axis = WEIR_NO_BATCH_AXIS};
  model->input = model->outputs[0] = model->outputs[1] = values;
  model->outputs[0].name = "scaled";
  model->outputs[1].name = "positive";
  *out = model;
  return WEIR_OK;
}

static void close_model(weir_model* model) {
  free(model);
}

static int info(weir_model* model, weir_model_info* out, weir_error* error) {
  (void)error;
  out->n_inputs = 1;
  out->inputs = &model->input;
  out->n_outputs = 2;
  out->outputs = model->outputs;
  out->flags = WEIR_MODEL_DYNAMIC_OUTPUT | WEIR_MODEL_ALLOCATES_OUTPUT | WEIR_MODEL_ASYNC |
               WEIR_MODEL_CANCELS;
  out->alignment = 64;
  out->input_padding = 32;
  out->max_sessions = 4;
  out->max_in_flight = 1;
  out->weight_bytes = 4;
  out->metadata_json = "{\"author\": \"another author\"}";
  return WEIR_OK;
}

static int session_new(weir_model* model, const weir_option* options, uint32_t n,
                       weir_session** out, weir_error* error) {
  (void)options, (void)n, (void)error;
  *out = calloc(1, sizeof **out);
  if (!*out) return -WEIR_OUT_OF_MEMORY;
  (*out)->model = model;
  pthread_mutex_init(&(*out)->mutex, NULL);
  pthread_cond_init(&(*out)->changed, NULL);
  return WEIR_OK;
}

static void join(weir_session* session) {
  if (session->started) pthread_join(session->thread, NULL);
  session->started = 0;
}

static void session_free(weir_session* session) {
  join(session);
  pthread_cond_destroy(&session->changed);
  pthread_mutex_destroy(&session->mutex);
  free(session);
}

static int resolve(weir_session* session, const weir_tensor_info* in, uint32_t n_in,
                   weir_tensor_info* out, uint32_t n_out, weir_error* error) {
  (void)session, (void)error;
  if (n_in == 1 && n_out == 2) out[0].shape[0] = in[0].shape[0];
  return WEIR_OK;
}

/* Our own memory: the host calls release(owner) when nothing reads it any more. */
static int room(weir_tensor* tensor, const weir_tensor_info* info, size_t count) {
  if (tensor->data) return WEIR_OK;
  tensor->data = tensor->owner = malloc(count * sizeof(float) + 1);
  if (!tensor->data) return -WEIR_OUT_OF_MEMORY;
  tensor->release = free;
  tensor->bytes = tensor->capacity = count * sizeof(float);
  tensor->memory_kind = WEIR_MEMORY_HOST;
  tensor->fence_fd = -1;
  tensor->info = *info;
  tensor->info.shape[0] = (int64_t)count;
  return WEIR_OK;
}

static int check(const weir_frame* in, weir_error* error) {
  const weir_tensor* tensor = &in->tensors[0];
  const float* x = tensor->data;
  if ((uintptr_t)x % 64 != 0 || tensor->capacity < tensor->bytes + 32)
    return host->fail(error, WEIR_INTERNAL, "the requirements for memory were not met", NULL, NULL,
                      NULL, NULL);
  for (size_t i = 0; i < tensor->bytes / sizeof *x; ++i)
    if (x[i] != x[i])
      return host->fail(error, WEIR_INVOKE_FAILED, "a value is not a number", "NaN", "numbers",
                        "the first NaN", "clean the input");
  return WEIR_OK;
}

static int make(const weir_model* model, const weir_frame* in, weir_tensor* out, float factor,
                weir_error* error) {
  const float* x = in->tensors[0].data;
  const size_t count = in->tensors[0].bytes / sizeof *x;
  size_t positive = 0, at = 0;
  const int result = check(in, error);
  if (result < 0) return result;
  for (size_t i = 0; i < count; ++i) positive += x[i] > 0;
  if (room(&out[0], &model->outputs[0], count) < 0 ||
      room(&out[1], &model->outputs[1], positive) < 0)
    return -WEIR_OUT_OF_MEMORY;
  for (size_t i = 0; i < count; ++i) {
    ((float*)out[0].data)[i] = factor * x[i];
    if (x[i] > 0) ((float*)out[1].data)[at++] = x[i];
  }
  return WEIR_OK;
}

static int invoke(weir_session* session, const weir_frame* in, weir_frame* out, weir_error* error) {
  if (in->tensors[0].bytes == sizeof(float)) return 1; /* drops the frame */
  return make(session->model, in, out->tensors, session->model->factor, error);
}

/* A long computation that cancel() ends. */
static void rest(weir_session* session, const weir_request* request) {
  struct timespec end;
  host->log(WEIR_LOG_WARNING, "outside-c", "a request rests");
  clock_gettime(CLOCK_REALTIME, &end);
  end.tv_sec += session->model->rest;
  pthread_mutex_lock(&session->mutex);
  while (session->cancelled != request)
    if (pthread_cond_timedwait(&session->changed, &session->mutex, &end) != 0) break;
  pthread_mutex_unlock(&session->mutex);
}

static void* run_frame(void* data) {
  weir_session* session = data;
  weir_request* request = session->request;
  int result = WEIR_OK;
  if (session->model->rest > 0) rest(session, request);
  for (int i = 0; i < session->model->repeat && result == WEIR_OK && !host->cancelled(request);
       ++i) {
    weir_tensor tensors[2];
    memset(tensors, 0, sizeof tensors);
    weir_frame out = {.struct_size = sizeof out, .n_tensors = 2, .tensors = tensors};
    out.pts = out.duration = out.deadline = -1;
    result = make(session->model, session->in, tensors, session->model->factor + (float)i,
                  host->error_of(request));
    if (result == WEIR_OK) host->complete(request, WEIR_OK, &out, 1);
  }
  host->complete(request, result, NULL, 0);
  return NULL;
}

static int submit(weir_session* session, const weir_frame* in, weir_request* request,
                  weir_error* error) {
  join(session);
  session->in = in;
  session->request = request;
  if (pthread_create(&session->thread, NULL, run_frame, session) != 0)
    return host->fail(error, WEIR_OUT_OF_MEMORY, "no thread for a request", NULL, NULL, NULL, NULL);
  session->started = 1;
  return WEIR_OK;
}

static void cancel(weir_session* session, weir_request* request) {
  pthread_mutex_lock(&session->mutex);
  session->cancelled = request;
  pthread_cond_broadcast(&session->changed);
  pthread_mutex_unlock(&session->mutex);
  host->log(WEIR_LOG_WARNING, "outside-c", "cancel() was called");
}

static int control(weir_session* session, int op, const weir_option* option, weir_error* error) {
  if (op == WEIR_WARM) return WEIR_OK;
  if (op == WEIR_SET_OPTION && option && strcmp(option->key, "factor") == 0)
    return number(option, &session->model->factor, error);
  return -WEIR_OPTION_VALUE;
}

static int probe(const char* path, const void* head, size_t n, int* score, weir_error* error) {
  (void)path, (void)error;
  *score = n >= 7 && memcmp(head, "OUTSIDE", 7) == 0 ? 100 : 0;
  return WEIR_OK;
}

static const weir_engine engine = {
    .struct_size = sizeof(weir_engine),
    .abi_major = WEIR_ABI_MAJOR,
    .abi_minor = WEIR_ABI_MINOR,
    .name = "outside-c",
    .version = "1.0",
    .options_json =
        "[{\"name\": \"factor\", \"type\": \"number\", \"default\": \"1\","
        "  \"help\": \"what the input is multiplied with\"},"
        " {\"name\": \"repeat\", \"type\": \"integer\", \"default\": \"1\","
        "  \"help\": \"outputs per input, asynchronous\"},"
        " {\"name\": \"rest\", \"type\": \"integer\", \"default\": \"0\","
        "  \"help\": \"seconds that an asynchronous answer takes\"}]",
    .flags = WEIR_ENGINE_NEEDS_NO_MODEL | WEIR_ENGINE_MODEL_IS_NO_FILE,
    .probe = probe,
    .open = open_model,
    .close = close_model,
    .info = info,
    .session_new = session_new,
    .session_free = session_free,
    .resolve = resolve,
    .invoke = invoke,
    .submit = submit,
    .cancel = cancel,
    .control = control,
};

__attribute__((visibility("default"))) const weir_module* weir_module_entry(
    const weir_host* given) {
  static const weir_engine* const engines[] = {&engine, NULL};
  static const weir_module module = {.struct_size = sizeof(weir_module),
                                     .abi_major = WEIR_ABI_MAJOR,
                                     .abi_minor = WEIR_ABI_MINOR,
                                     .engines = engines};
  if (given->abi_major != WEIR_ABI_MAJOR) return NULL;
  host = given;
  return &module;
}
