/* Opens and invokes a model of any engine directly, without a pipeline. In C++: model.hpp. Link
 * with libweir (pkg-config weir).
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
 * Functions that return int return 0 on success and -code (codes.h) on failure, with *error set to
 * an object for weir_error_free unless `error` is NULL; a value above 0 only where documented.
 * Shapes are outermost-first as in NumPy, -1 = open. Any thread may call; calls of one model are
 * serialised. Pointers must not be NULL unless documented; for a NULL pointer functions return
 * -WEIR_OPTION_VALUE, a count of 0, or "" as text.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_MODEL_H
#define WEIR_MODEL_H
#include "weir/abi.h"
#include "weir/error.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct weir_loaded_model weir_loaded_model;
typedef struct weir_results weir_results;

/* The model to open. Members are only appended; those beyond struct_size count as 0. */
typedef struct {
  uint32_t struct_size;
  uint32_t n_paths;
  const char* const* paths;   /* of the model's files */
  const char* engine;         /* name or alias; NULL, "", "auto": chosen by the file names */
  const char* accelerator;    /* in the engine's terms; NULL: the engine's own choice */
  const weir_option* options; /* of the engine: custom=key:value of tensor_filter */
  uint32_t n_options;
  int32_t threads;    /* of one invoke; 0: the engine's own choice */
  int64_t timeout_ns; /* see weir_model_set_timeout; 0: none */
  /* The properties input, inputtype, inputname, output... of tensor_filter as key and value, for
   * engines whose models do not describe their tensors. Other engines do not receive them. */
  const weir_option* declared;
  uint32_t n_declared;
} weir_model_options;
#define WEIR_MODEL_OPTIONS_INIT \
  { sizeof(weir_model_options), 0, NULL, NULL, NULL, NULL, 0, 0, 0, NULL, 0 }

/* Opens a model. Free it with weir_model_close. Errors: MODEL_NOT_FOUND, ENGINE_UNKNOWN,
 * ENGINE_NOT_INSTALLED, errors of the engine. */
WEIR_EXPORT int weir_model_open(const weir_model_options* options, weir_loaded_model** model,
                                weir_error** error);
/* Closes the model; NULL: no effect. Does not wait for an invoke that has timed out: the engine
 * closes when that ends. Results stay valid. */
WEIR_EXPORT void weir_model_close(weir_loaded_model* model);

/* Return the name and version of the engine; the metadata of the model file as a JSON object, or
 * NULL. Valid until close. */
WEIR_EXPORT const char* weir_model_engine(const weir_loaded_model* model);
WEIR_EXPORT const char* weir_model_engine_version(const weir_loaded_model* model);
WEIR_EXPORT const char* weir_model_metadata(const weir_loaded_model* model);

/* Describe the current tensors; weir_model_reshape changes them. Names are valid until close. Rank
 * WEIR_RANK_UNKNOWN and type WEIR_TYPE_END: open. -WEIR_OPTION_VALUE for an invalid index. */
WEIR_EXPORT uint32_t weir_model_input_count(const weir_loaded_model* model);
WEIR_EXPORT uint32_t weir_model_output_count(const weir_loaded_model* model);
WEIR_EXPORT int weir_model_input(const weir_loaded_model* model, uint32_t index,
                                 weir_tensor_info* info);
WEIR_EXPORT int weir_model_output(const weir_loaded_model* model, uint32_t index,
                                  weir_tensor_info* info);

/* Sets the shapes of all inputs where the model leaves them open, until the next reshape. Only
 * type, rank and shape of `inputs` are read; rank WEIR_RANK_UNKNOWN and type WEIR_TYPE_END keep the
 * model's. Errors: SPEC_MISMATCH for an extent that contradicts the model, errors of the engine. On
 * failure the shapes do not change. */
WEIR_EXPORT int weir_model_reshape(weir_loaded_model* model, const weir_tensor_info* inputs,
                                   uint32_t n_inputs, weir_error** error);

/* Limits the duration of later calls, in ns; 0 or below: no limit. With a limit, inputs are copied
 * and the engine runs on a thread of the model. An engine cannot be interrupted: after
 * -WEIR_WORKER_TIMEOUT (3015) the invoke continues in its own memory, and until it ends every call
 * of the model returns -WEIR_WORKER_TIMEOUT. */
WEIR_EXPORT void weir_model_set_timeout(weir_loaded_model* model, int64_t timeout_ns);

/* Describes memory that the caller lends as a tensor in the model's current shape; for another
 * shape set info.rank and info.shape. `bytes` is the size, `type` a weir_type. Strides, flags and
 * release are ignored. Raise capacity above bytes when more memory is readable, which avoids a copy
 * for engines that require padding. */
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

/* Runs the model once. The inputs are dense, in the order of weir_model_input, and are read during
 * the call. Returns 0 with *results for weir_results_free, or 1 with NULL in *results when the
 * model has no output for these inputs. Errors name the tensor: SPEC_MISMATCH (number, type,
 * shape), FRAME_SIZE, INVOKE_FAILED, WORKER_TIMEOUT, errors of the engine. */
WEIR_EXPORT int weir_model_invoke(weir_loaded_model* model, const weir_tensor* inputs,
                                  uint32_t n_inputs, weir_results** results, weir_error** error);
/* Does the same as weir_model_invoke, into the caller's memory: one tensor per output with data and
 * the exact size in bytes. Fills their info, without names. Outputs of open shape are copied there;
 * FRAME_SIZE if the size differs. */
WEIR_EXPORT int weir_model_invoke_into(weir_loaded_model* model, const weir_tensor* inputs,
                                       uint32_t n_inputs, weir_tensor* outputs, uint32_t n_outputs,
                                       weir_error** error);
/* Runs n_frames frames at once, for models whose outermost axis is open or has exactly this length.
 * `inputs` are those of the first frame, then of the second and so on, each in the shape of one
 * frame with an outermost extent of 1. The results have the frames in their outermost axis; see
 * weir_results_frame_tensor. BATCH_UNSUPPORTED if the model has no such axis or keeps state. */
WEIR_EXPORT int weir_model_invoke_batch(weir_loaded_model* model, const weir_tensor* inputs,
                                        uint32_t n_inputs, uint32_t n_frames,
                                        weir_results** results, weir_error** error);

/* Return the number of outputs, and of frames in a batch. */
WEIR_EXPORT uint32_t weir_results_count(const weir_results* results);
WEIR_EXPORT uint32_t weir_results_frames(const weir_results* results); /* 1 without a batch */
/* Describes output `index`, of all frames or of one frame. Memory and name are valid until
 * weir_results_free. -WEIR_OPTION_VALUE for an invalid index. */
WEIR_EXPORT int weir_results_tensor(const weir_results* results, uint32_t index,
                                    weir_tensor* tensor);
WEIR_EXPORT int weir_results_frame_tensor(const weir_results* results, uint32_t frame,
                                          uint32_t index, weir_tensor* tensor);
WEIR_EXPORT void weir_results_free(weir_results* results); /* NULL: no effect */

#ifdef __cplusplus
}
#endif
#endif /* WEIR_MODEL_H */
