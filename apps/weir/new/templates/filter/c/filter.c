/* The filter my-filter: y = 255 - x, for uint8 tensors of any shape. See <weir/abi.h>. */
#include <stdlib.h>
#include <string.h>
#include <weir/abi.h>

static const weir_host* host;

/* An open filter. Put here what sessions share; it must own the tensor infos. */
struct weir_model {
  weir_tensor_info bytes;
};

static int open_filter(const weir_open* request, weir_model** out, weir_error* error) {
  (void)request; /* request->options has the pairs of custom=key:value */
  (void)error;
  *out = calloc(1, sizeof **out);
  if (!*out) return -WEIR_OUT_OF_MEMORY;
  (*out)->bytes.type = WEIR_UINT8;
  (*out)->bytes.rank = WEIR_RANK_UNKNOWN; /* the stream decides */
  (*out)->bytes.name = "bytes";
  (*out)->bytes.batch_axis = WEIR_NO_BATCH_AXIS;
  return WEIR_OK;
}

static void close_filter(weir_model* filter) {
  free(filter);
}

static int info(weir_model* filter, weir_model_info* out, weir_error* error) {
  (void)error;
  out->n_inputs = out->n_outputs = 1;
  out->inputs = out->outputs = &filter->bytes;
  out->max_sessions = out->max_in_flight = out->preferred_batch = 1;
  return WEIR_OK;
}

/* A session is the state of one thread; this filter has none. */
static int session_new(weir_model* filter, const weir_option* options, uint32_t n,
                       weir_session** out, weir_error* error) {
  (void)options, (void)n, (void)error;
  *out = (weir_session*)filter;
  return WEIR_OK;
}

static void session_free(weir_session* session) {
  (void)session;
}

/* The output has the input's shape. */
static int resolve(weir_session* session, const weir_tensor_info* in, uint32_t n_in,
                   weir_tensor_info* out, uint32_t n_out, weir_error* error) {
  (void)session, (void)error;
  if (n_in != 1 || n_out != 1) return WEIR_OK;
  out[0].rank = in[0].rank;
  memcpy(out[0].shape, in[0].shape, sizeof in[0].shape);
  return WEIR_OK;
}

/* Returns 0; above 0 to drop the frame; host->fail(error, ...) for an error. */
static int invoke(weir_session* session, const weir_frame* in, weir_frame* out, weir_error* error) {
  const uint8_t* x = in->tensors[0].data;
  uint8_t* y = out->tensors[0].data;
  (void)session;
  if (in->tensors[0].bytes != out->tensors[0].bytes)
    return host->fail(error, WEIR_FRAME_SIZE, "the output and the input have different lengths",
                      NULL, NULL, NULL, NULL);
  for (uint64_t i = 0; i < in->tensors[0].bytes; ++i) y[i] = (uint8_t)(255 - x[i]);
  return WEIR_OK;
}

static const weir_engine engine = {.struct_size = sizeof engine,
                                   .abi_major = WEIR_ABI_MAJOR,
                                   .abi_minor = WEIR_ABI_MINOR,
                                   .name = "my-filter",
                                   .version = "1",
                                   .flags = WEIR_ENGINE_NEEDS_NO_MODEL,
                                   .open = open_filter,
                                   .close = close_filter,
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

__attribute__((visibility("default"))) const weir_module* weir_module_entry(
    const weir_host* given) {
  if (given->abi_major != WEIR_ABI_MAJOR) return NULL;
  host = given;
  return &module;
}
