/* A model of any engine, opened and invoked by a program itself, with no pipeline around it. In
 * C++: model.hpp. Link with libweir (pkg-config weir).
 *
 *   weir_model_options options = WEIR_MODEL_OPTIONS_INIT;
 *   const char *path = "model.onnx";
 *   options.paths = &path;
 *   options.n_paths = 1;
 *   weir_loaded_model *model = NULL;
 *   weir_results *results = NULL;
 *   weir_error *error = NULL;
 *   if (weir_model_open (&options, &model, &error) < 0) ...weir_error_message (error)...
 *   weir_tensor input = weir_tensor_of (pixels, sizeof pixels, WEIR_UINT8);
 *   if (weir_model_invoke (model, &input, 1, &results, &error) < 0) ...
 *
 * Functions that return int: 0 = success; -code (codes.h) = failure, with *error set to an object
 * for weir_error_free unless `error` is NULL; above 0 only where it is said. Shapes are
 * outermost-first as in NumPy, -1 = open. Any thread may call; calls of one model wait for each
 * other. No pointer may be NULL unless said; one that is gives -WEIR_OPTION_VALUE, a count of 0, or
 * "" where a function returns text. */
#ifndef WEIR_MODEL_H
#define WEIR_MODEL_H
#include "weir/abi.h"
#include "weir/error.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct weir_loaded_model weir_loaded_model;
typedef struct weir_results weir_results;

/* What to open. Members are only appended; what is behind struct_size is taken as 0. */
typedef struct {
  uint32_t struct_size;
  uint32_t n_paths;
  const char* const* paths;   /* of the model's files */
  const char* engine;         /* name or alias; NULL, "", "auto": by the names of the files */
  const char* accelerator;    /* what the engine calls it; NULL: the engine's own choice */
  const weir_option* options; /* of the engine: custom=key:value of tensor_filter */
  uint32_t n_options;
  int32_t threads;    /* inside one invoke; 0: the engine's own choice */
  int64_t timeout_ns; /* weir_model_set_timeout; 0: none */
  /* What the properties input, inputtype, inputname, output... of tensor_filter would say, by these
   * names, for engines whose models do not; engines that do not ask for it do not get it. */
  const weir_option* declared;
  uint32_t n_declared;
} weir_model_options;
#define WEIR_MODEL_OPTIONS_INIT \
  { sizeof(weir_model_options), 0, NULL, NULL, NULL, NULL, 0, 0, 0, NULL, 0 }

/* Errors: MODEL_NOT_FOUND, ENGINE_UNKNOWN, ENGINE_NOT_INSTALLED, what the engine says. */
WEIR_EXPORT int weir_model_open(const weir_model_options* options, weir_loaded_model** model,
                                weir_error** error);
/* NULL: nothing. Does not wait for an invoke that timed out: the engine closes when it has ended.
 * Results stay. */
WEIR_EXPORT void weir_model_close(weir_loaded_model* model);

/* Of the engine, and what the model's file says of itself (a JSON object) or NULL. Live until
 * close. */
WEIR_EXPORT const char* weir_model_engine(const weir_loaded_model* model);
WEIR_EXPORT const char* weir_model_engine_version(const weir_loaded_model* model);
WEIR_EXPORT const char* weir_model_metadata(const weir_loaded_model* model);

/* The tensors as they are now: weir_model_reshape changes them. Names live until close; rank
 * WEIR_RANK_UNKNOWN and type WEIR_TYPE_END: open. -WEIR_OPTION_VALUE for an index beyond. */
WEIR_EXPORT uint32_t weir_model_input_count(const weir_loaded_model* model);
WEIR_EXPORT uint32_t weir_model_output_count(const weir_loaded_model* model);
WEIR_EXPORT int weir_model_input(const weir_loaded_model* model, uint32_t index,
                                 weir_tensor_info* info);
WEIR_EXPORT int weir_model_output(const weir_loaded_model* model, uint32_t index,
                                  weir_tensor_info* info);

/* Sets shapes in place of what the model leaves open, of all inputs, until the next reshape. Of
 * `inputs` type, rank and shape are read; rank WEIR_RANK_UNKNOWN and type WEIR_TYPE_END: as the
 * model says. SPEC_MISMATCH where the model has another extent, and what the engine says; the
 * shapes stay as they were then. */
WEIR_EXPORT int weir_model_reshape(weir_loaded_model* model, const weir_tensor_info* inputs,
                                   uint32_t n_inputs, weir_error** error);

/* How long a later call may take, in ns; 0 or below: without limit. With a limit inputs are copied
 * and the engine runs on a thread of the model. No engine can be stopped from outside: after
 * -WEIR_WORKER_TIMEOUT (3015) the invoke goes on by itself, in memory of its own, and every call of
 * the model is -WEIR_WORKER_TIMEOUT until it has ended. */
WEIR_EXPORT void weir_model_set_timeout(weir_loaded_model* model, int64_t timeout_ns);

/* A tensor that the caller lends, its shape as the model has it now. With another shape: set
 * info.rank and info.shape. Strides, flags and release are not read; capacity above bytes says that
 * more can be read behind, which spares a copy for engines that want padding. */
static inline weir_tensor weir_tensor_of(const void* data, uint64_t bytes, uint32_t type) {
  weir_tensor tensor;
  uint32_t i;
  unsigned char* at = (unsigned char*)&tensor;
  for (i = 0; i < sizeof tensor; ++i) at[i] = 0;
  tensor.data = (void*)data;
  tensor.bytes = tensor.capacity = bytes;
  tensor.fence_fd = -1;
  tensor.info.type = type;
  tensor.info.rank = WEIR_RANK_UNKNOWN;
  tensor.info.batch_axis = WEIR_NO_BATCH_AXIS;
  return tensor;
}

/* Runs the model once. The inputs are dense, in the order of weir_model_input, and read during the
 * call. 0 with *results for weir_results_free; 1: the model gives nothing for these inputs,
 * *results is NULL. Errors: SPEC_MISMATCH (number, type, shape), FRAME_SIZE, INVOKE_FAILED,
 * WORKER_TIMEOUT, what the engine says; named by the tensor. */
WEIR_EXPORT int weir_model_invoke(weir_loaded_model* model, const weir_tensor* inputs,
                                  uint32_t n_inputs, weir_results** results, weir_error** error);
/* The same into the caller's memory: one for each output, data and bytes of exactly its size. Their
 * info is filled, without names. An output whose shape stays open is copied there, FRAME_SIZE when
 * its size is another one. */
WEIR_EXPORT int weir_model_invoke_into(weir_loaded_model* model, const weir_tensor* inputs,
                                       uint32_t n_inputs, weir_tensor* outputs, uint32_t n_outputs,
                                       weir_error** error);
/* n_frames frames at once, for models whose outermost axis is open (or just that long): `inputs`
 * are those of the first frame, then those of the second, ..., each with the shape of one frame,
 * its outermost extent 1. The results hold the frames in their outermost axis:
 * weir_results_frame_tensor. BATCH_UNSUPPORTED where the model has no such axis or keeps state. */
WEIR_EXPORT int weir_model_invoke_batch(weir_loaded_model* model, const weir_tensor* inputs,
                                        uint32_t n_inputs, uint32_t n_frames,
                                        weir_results** results, weir_error** error);

WEIR_EXPORT uint32_t weir_results_count(const weir_results* results);
WEIR_EXPORT uint32_t weir_results_frames(const weir_results* results); /* 1 without a batch */
/* Describes output `index`, of all frames or of one. Memory and name live until
 * weir_results_free. -WEIR_OPTION_VALUE for an index beyond. */
WEIR_EXPORT int weir_results_tensor(const weir_results* results, uint32_t index,
                                    weir_tensor* tensor);
WEIR_EXPORT int weir_results_frame_tensor(const weir_results* results, uint32_t frame,
                                          uint32_t index, weir_tensor* tensor);
WEIR_EXPORT void weir_results_free(weir_results* results); /* NULL: nothing */

#ifdef __cplusplus
}
#endif
#endif /* WEIR_MODEL_H */
