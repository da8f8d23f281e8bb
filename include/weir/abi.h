/* The plug-in ABI of Weir, version 1, for engines, decoders and converters, both Weir's own and
 * those of users.
 *
 * A module is a shared object that exports one symbol, weir_module_entry. Rules:
 *    (A) Structs that are elements of arrays are frozen. They have reserved members; 0 = absent.
 *    (B) Other structs begin with struct_size and are passed by pointer. New members are only
 *        appended: never access a struct of the other side beyond its struct_size.
 *    (C) Shapes are outermost-first as in NumPy, -1 = unknown. Only the text grammar of caps and
 *        properties is innermost-first.
 * Functions that return int return 0 on success and -code (codes.h) on failure, with the weir_error
 * filled through host->fail. invoke and decode return > 0 to drop the frame (invoke: no_result.h).
 * Strings are UTF-8, zero-terminated, owned by the side that passes them and valid for the call
 * unless stated otherwise.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_ABI_H
#define WEIR_ABI_H
#include <stddef.h>
#include <stdint.h>

#include "weir/codes.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The host refuses a module of another major version; minor versions only append. */
#define WEIR_ABI_MAJOR 1
#define WEIR_ABI_MINOR 0
#define WEIR_RANK_LIMIT 16
#define WEIR_TENSOR_LIMIT 256
#define WEIR_NO_BATCH_AXIS 0xFFu
#define WEIR_RANK_UNKNOWN 0xFFFFFFFFu /* rank 0 is a scalar */

/* Element types; the numbers are part of wire formats. */
enum weir_type {
  WEIR_INT32 = 0,
  WEIR_UINT32,
  WEIR_INT16,
  WEIR_UINT16,
  WEIR_INT8,
  WEIR_UINT8,
  WEIR_FLOAT64,
  WEIR_FLOAT32,
  WEIR_INT64,
  WEIR_UINT64,
  WEIR_FLOAT16,
  WEIR_TYPE_END
};
enum weir_layout { WEIR_LAYOUT_ANY = 0, WEIR_LAYOUT_NHWC, WEIR_LAYOUT_NCHW, WEIR_LAYOUT_NONE };
/* The host allocates HOST memory only. */
enum weir_memory_kind {
  WEIR_MEMORY_HOST = 0,
  WEIR_MEMORY_DMABUF,
  WEIR_MEMORY_CUDA,
  WEIR_MEMORY_OPENCL,
  WEIR_MEMORY_GL,
  WEIR_MEMORY_VULKAN
};
enum weir_tensor_flag {
  WEIR_TENSOR_READONLY = 1,
  WEIR_TENSOR_ALIASES_INPUT = 2,
  WEIR_TENSOR_DYNAMIC = 4
};
/* What each source map of a frame applies to: a tensor (one map for all tensors, or one each) or,
 * for batches, an index of the outermost dimension, in every tensor. */
enum weir_maps_of { WEIR_MAPS_OF_TENSORS = 0, WEIR_MAPS_OF_REGIONS };
enum weir_frame_flag { WEIR_FRAME_DISCONT = 1, WEIR_FRAME_GAP = 2, WEIR_FRAME_LAST = 4 };
/* THREAD_SAFE: several threads may invoke one session. STATEFUL: a frame depends on earlier ones,
 * so there are no batches and one worker. ALLOCATES_OUTPUT: the engine allocates the outputs.
 * DYNAMIC_OUTPUT: each invoke decides the outputs' sizes. ASYNC: submit() may be used. CANCELS: the
 * engine handles cancel(). FORK_UNSAFE: the model does not work in a forked process. */
enum weir_model_flag {
  WEIR_MODEL_THREAD_SAFE = 1,
  WEIR_MODEL_STATEFUL = 2,
  WEIR_MODEL_IN_PLACE = 4,
  WEIR_MODEL_ALLOCATES_OUTPUT = 8,
  WEIR_MODEL_DYNAMIC_OUTPUT = 16,
  WEIR_MODEL_ASYNC = 32,
  WEIR_MODEL_CANCELS = 64,
  WEIR_MODEL_FORK_UNSAFE = 128
};
/* NEEDS_NO_MODEL: model= is optional. MODEL_IS_NO_FILE: model= is a name or text that the engine
 * interprets; the host does not look for a file. */
enum weir_engine_flag { WEIR_ENGINE_NEEDS_NO_MODEL = 1, WEIR_ENGINE_MODEL_IS_NO_FILE = 2 };
/* WARM: do now the work that the first invoke would otherwise do. SUSPEND: release what RESUME can
 * restore; an engine without it is closed and opened again. RESET_STATE: the next frame does not
 * continue the previous ones. SET_OPTION: apply the options passed to the call. A return value
 * below 0: not supported. */
enum weir_control { WEIR_WARM = 0, WEIR_SUSPEND, WEIR_RESUME, WEIR_RESET_STATE, WEIR_SET_OPTION };
enum weir_log_level { WEIR_LOG_ERROR = 1, WEIR_LOG_WARNING, WEIR_LOG_INFO, WEIR_LOG_DEBUG };

/* One tensor's description. FROZEN, 192 bytes on LP64. */
typedef struct {
  uint32_t type, rank;
  int64_t shape[WEIR_RANK_LIMIT]; /* outermost-first, -1 = unknown */
  const char* name;               /* or NULL; the function that returns it defines its lifetime */
  float scale;                    /* real = scale * (value - zero_point); 0 = not quantised */
  int32_t zero_point;
  uint32_t layout, batch_axis; /* WEIR_NO_BATCH_AXIS: none */
  uint64_t reserved[4];
} weir_tensor_info;

/* One tensor's memory. FROZEN, 424 bytes on LP64. */
typedef struct {
  void* data; /* NULL in an output frame: the engine allocates and sets release */
  uint64_t bytes, capacity /* with readable padding */, offset;
  int64_t stride[WEIR_RANK_LIMIT]; /* bytes per step, outermost-first; all 0 = dense */
  uint32_t memory_kind, flags;
  intptr_t handle;
  int32_t device, fence_fd;
  void (*release)(void* owner);
  void* owner;
  weir_tensor_info info;
  uint64_t reserved[4];
} weir_tensor;

/* Transform from tensor to source picture coordinates:
 *   source x = xx * x + xy * y + x0, source y = yx * x + yy * y + y0.
 * Coordinates are in pixels from the top left corner; integers are the edges between pixels.
 * FROZEN, 80 bytes on LP64. */
typedef struct {
  double xx, xy, x0, yx, yy, y0;
  uint32_t source_width, source_height, width, height; /* of the picture, of the tensor */
  uint32_t x_dimension, y_dimension;                   /* of the tensor, 0 = innermost */
  uint64_t row; /* of the results (results.h) that a region was cut out for, plus 1; 0 = unknown */
} weir_source_map;

/* One frame: its tensors in the order of the model, times, and source maps. */
typedef struct {
  uint32_t struct_size, n_tensors;
  weir_tensor* tensors;
  int64_t pts, duration, deadline; /* ns; the deadline in running time; -1 = none */
  uint64_t stream_id, sequence;
  uint32_t flags;
  uint32_t n_maps, maps_of; /* weir_maps_of */
  const weir_source_map* maps;
  int64_t expires; /* the deadline by CLOCK_MONOTONIC, ns; 0 = none, or the host does not know */
} weir_frame;

typedef struct {
  const char *key, *value;
} weir_option; /* FROZEN */
typedef struct weir_error weir_error;
typedef struct weir_model weir_model;
typedef struct weir_session weir_session;
typedef struct weir_request weir_request;
typedef struct weir_decoder weir_decoder;
typedef struct weir_converter weir_converter;
typedef struct weir_sink weir_sink;

/* The host's functions; a module needs no other symbol of Weir. Valid until the process ends. */
typedef struct {
  uint32_t struct_size;
  uint16_t abi_major, abi_minor;
  /* Fills the error with copies of the texts (any length; NULL parts are omitted). Returns
   * -code. */
  int (*fail)(weir_error*, int code, const char* what, const char* offered, const char* needed,
              const char* difference, const char* fix);
  void (*log)(int level, const char* module, const char* text); /* weir_log_level; any thread */
  /* Allocates `bytes` of HOST memory for one tensor, aligned to `alignment` (a power of two, at
   * least 64 is used): sets data, bytes, capacity, release and owner. */
  int (*allocate)(void* host_ctx, uint32_t memory_kind, uint64_t bytes, uint32_t alignment,
                  weir_tensor* out);
  /* Continues or ends a submit(). Call it 1..N times from any thread, the last time with more = 0,
   * after which the request and its input are invalid. status: a return value of invoke. out: one
   * output, or NULL for none; the host takes over its tensors and releases them. May block until
   * earlier outputs have been consumed, but never until other requests end. */
  void (*complete)(weir_request*, int status, weir_frame* out, uint32_t more);
  /* The request's error: fill it through fail() before complete() with a status below 0. */
  weir_error* (*error_of)(weir_request*);
  /* Returns nonzero when the result is no longer needed: complete the request soon. Cheap to
   * poll. */
  int (*cancelled)(const weir_request*);
  const void* (*extension)(const char* id); /* "weir.sink/1" = const weir_sink_calls* */
} weir_host;

/* Output of a decoder or converter, from host->extension("weir.sink/1"). */
typedef struct {
  uint32_t struct_size;
  /* In configure: sets the output caps as GStreamer text, without framerate, which the host
   * adds. */
  int (*set_caps)(weir_sink*, const char* caps, weir_error*);
  /* Returns `bytes` of writable output memory, valid until decode returns. Each further call
   * appends a memory to the output. NULL when out of memory. */
  void* (*reserve)(weir_sink*, uint64_t bytes);
  /* Appends tensor `index` of the input frame without copying it. */
  int (*share_input)(weir_sink*, uint32_t index, weir_error*);
} weir_sink_calls;

/* The model to open: n_models file paths, and the user's settings. Valid for the call. */
typedef struct {
  uint32_t struct_size, n_models;
  const char* const* paths;
  const void* bytes;
  uint64_t n_bytes;
  const weir_option* options;
  uint32_t n_options;
  const char* accelerator;
  int32_t threads; /* 0 = the engine's own choice */
  void* host_ctx;
} weir_open;

/* Describes an open model; weir_model_flag in flags. At most 256 inputs and outputs each; 0 inputs:
 * any; 0 outputs: resolve() returns them. */
typedef struct {
  uint32_t struct_size, flags;
  uint32_t n_inputs, n_outputs;
  const weir_tensor_info *inputs, *outputs; /* names too; valid until the model is closed */
  /* Bytes, 0 = none. Each input starts at a multiple of alignment (a power of two up to 4096) and
   * is followed by input_padding readable bytes (up to 65536). The host copies inputs whose memory
   * does not satisfy this, so request no more than the engine needs. */
  uint32_t alignment, input_padding;
  uint64_t memory_kinds; /* bit per weir_memory_kind */
  /* max_sessions: concurrent sessions, 0 = no limit. max_in_flight: requests in progress, 0 = 1;
   * THREAD_SAFE without ASYNC: parallel invokes. preferred_batch: frames of one invoke, 0 = any. */
  uint32_t max_sessions, max_in_flight, preferred_batch;
  uint64_t weight_bytes;
  const char* metadata_json; /* or NULL */
} weir_model_info;

/* An engine runs models. open, close, info, session_new, session_free and invoke are required; the
 * other functions may be NULL. */
typedef struct {
  uint32_t struct_size;
  uint16_t abi_major, abi_minor;
  const char *name, *version, *aliases, *extensions; /* lists: comma-separated, "tflite" no dot */
  /* The custom= options: [{"name":"threads","type":"integer","default":"1","help":"..."}], or NULL.
   * type: boolean, integer, number, text, file, values: "a|b". "setting": "group/key" of
   * weir.ini. */
  const char* options_json;
  uint64_t flags; /* weir_engine_flag */
  /* Looks at the first n bytes without loading the model. score: 0 (not mine) to 100 (certain). */
  int (*probe)(const char* path, const void* head, size_t n, int* score, weir_error*);
  int (*open)(const weir_open*, weir_model**, weir_error*);
  void (*close)(weir_model*); /* after session_free() of all its sessions */
  int (*info)(weir_model*, weir_model_info*, weir_error*);
  /* Creates an invocation context. One thread at a time uses a session that is not THREAD_SAFE. */
  int (*session_new)(weir_model*, const weir_option*, uint32_t n, weir_session**, weir_error*);
  void (*session_free)(weir_session*);
  /* Computes the outputs' types and shapes for these inputs. Unknown extents are -1. For a model
   * without outputs in its info, n_out is the capacity; the first entry left with WEIR_TYPE_END and
   * WEIR_RANK_UNKNOWN ends the list. */
  int (*resolve)(weir_session*, const weir_tensor_info* in, uint32_t n_in, weir_tensor_info* out,
                 uint32_t n_out, weir_error*);
  /* Runs the model on one frame. Writes the outputs to their data, or allocates where data is NULL
   * and sets info. `in` is read-only and valid for the call. */
  int (*invoke)(weir_session*, const weir_frame* in, weir_frame* out, weir_error*);
  /* Optional: starts an asynchronous invoke that ends with host->complete(). `in` is readable until
   * then. When submit returns below 0, complete() must not be called. */
  int (*submit)(weir_session*, const weir_frame* in, weir_request*, weir_error*);
  void (*cancel)(weir_session*, weir_request*); /* optional; complete() still comes */
  int (*control)(weir_session*, int op, const weir_option*, weir_error*); /* weir_control */
  /* "weir.accelerators/1" = const char*, a comma-separated list of the supported accelerators
   * ("cpu,cpu.simd,gpu"), the automatic choice first. Returns NULL for an unknown id. */
  const void* (*extension)(const char* id);
} weir_engine;

/* One detected object, in units of the source picture. FROZEN, 112 bytes on LP64. */
typedef struct {
  float x, y, w, h, angle, score;
  int32_t class_id;
  int64_t track_id, parent;
  const char* label;
  const float* keypoints;
  uint32_t n_keypoints, n_mask_runs;
  const uint32_t* mask_runs;
  uint64_t reserved[4];
} weir_object;

/* A decoder turns tensors into pixels, text or bytes. open, close, configure and decode are
 * required. */
typedef struct {
  uint32_t struct_size;
  uint16_t abi_major, abi_minor;
  const char *name, *aliases;
  const char* options_json; /* [{"name":"option1","type":"file","default":"","help":"..."}] */
  int (*open)(const weir_option*, uint32_t n, void* host_ctx, weir_decoder**, weir_error*);
  void (*close)(weir_decoder*);
  /* Called when the input tensors are known (n = 0: each frame has its own); sets the output caps
   * through the sink's set_caps. */
  int (*configure)(weir_decoder*, const weir_tensor_info* in, uint32_t n,
                   const char* downstream_caps, weir_sink*, weir_error*);
  /* Decodes one frame into the sink. `in` is read-only and valid for the call. */
  int (*decode)(weir_decoder*, const weir_frame* in, weir_sink*, weir_error*);
  int (*set_option)(weir_decoder*, const weir_option*, weir_error*);
  void (*reset)(weir_decoder*); /* after a flush: frames before it are forgotten */
  const void* (*extension)(const char* id);
} weir_decoder_type;

/* An external converter turns a media stream into tensors. open, close, configure and convert are
 * required. */
typedef struct {
  uint32_t struct_size;
  uint16_t abi_major, abi_minor;
  const char *name, *aliases;
  const char* caps; /* accepted input, as GStreamer caps text */
  const char* options_json;
  int (*open)(const weir_option*, uint32_t n, void* host_ctx, weir_converter**, weir_error*);
  void (*close)(weir_converter*);
  /* Maps the input caps (text) to tensors. n_out: capacity on entry, count on return. A count of 0
   * or open extents: not known before the first frame. */
  int (*configure)(weir_converter*, const char* caps, weir_tensor_info* out, uint32_t* n_out,
                   weir_error*);
  /* `in` holds one uint8 tensor per memory, readable until convert returns. out->n_tensors:
   * capacity on entry, count on return. The converter allocates the tensors through host->allocate
   * and fills their info; one that differs from configure's renegotiates. The time of `out` is
   * preset to the input's. The host releases what a failed call has allocated. */
  int (*convert)(weir_converter*, const weir_frame* in, weir_frame* out, weir_error*);
  void (*reset)(weir_converter*);
  const void* (*extension)(const char* id);
} weir_converter_type;

/* The tables of a module; they stay valid until the process ends. */
typedef struct {
  uint32_t struct_size;
  uint16_t abi_major, abi_minor;
  const weir_engine* const* engines; /* lists: NULL-terminated, or NULL */
  const weir_decoder_type* const* decoders;
  const weir_converter_type* const* converters;
  const void* const* trainers;
  const void* (*extension)(const char* id);
} weir_module;

/* The only exported symbol. Returns NULL when the module is unusable here, after host->log. */
const weir_module* weir_module_entry(const weir_host*);

#ifdef __cplusplus
}
#endif
#endif /* WEIR_ABI_H */
