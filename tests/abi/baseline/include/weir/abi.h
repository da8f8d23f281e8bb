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
 * filled through host->fail. decode, and invoke with weir_no_result, return > 0 to drop the frame.
 * Strings are UTF-8, zero-terminated, owned by the side that passes them and valid for the call
 * unless stated otherwise.
 *
 * The tables of the host, an engine, a decoder and a converter are followed by their extensions,
 * all optional. extension(id) returns the struct that the id names, or NULL for an unknown id. It
 * is valid until the process ends unless stated otherwise.
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
 * engine handles cancel(). FORK_UNSAFE: the model does not work in a forked process. EMPTY_INPUT:
 * invoke takes inputs with a dimension of 0, which have no elements; without it the host sends a
 * GAP event in place of such a frame. */
enum weir_model_flag {
  WEIR_MODEL_THREAD_SAFE = 1,
  WEIR_MODEL_STATEFUL = 2,
  WEIR_MODEL_IN_PLACE = 4,
  WEIR_MODEL_ALLOCATES_OUTPUT = 8,
  WEIR_MODEL_DYNAMIC_OUTPUT = 16,
  WEIR_MODEL_ASYNC = 32,
  WEIR_MODEL_CANCELS = 64,
  WEIR_MODEL_FORK_UNSAFE = 128,
  WEIR_MODEL_EMPTY_INPUT = 256
};
/* NEEDS_NO_MODEL: model= is optional. MODEL_IS_NO_FILE: model= is a name or text that the engine
 * interprets; the host does not look for a file. */
enum weir_engine_flag { WEIR_ENGINE_NEEDS_NO_MODEL = 1, WEIR_ENGINE_MODEL_IS_NO_FILE = 2 };
/* WARM: do now the work that the first invoke would otherwise do. SUSPEND: release what RESUME can
 * restore; an engine without it is closed and opened again. RESET_STATE: the next frame does not
 * continue the previous ones. SET_OPTION: apply the options passed to the call. A return value
 * below 0: not supported. */
enum weir_control { WEIR_WARM = 0, WEIR_SUSPEND, WEIR_RESUME, WEIR_RESET_STATE, WEIR_SET_OPTION };
/* Return values of invoke that say why a frame has no result; other values above 0 mean
 * WEIR_NO_RESULT. An engine with submit() passes it to the last complete() of a request. After the
 * last three, the host may run another model on the frame (tensor_filter fallback=...). `stats`
 * counts the frames as dropped-policy, dropped-late, dropped-refused and dropped-lost. */
enum weir_no_result {
  WEIR_NO_RESULT = 1,            /* the engine drops the frame */
  WEIR_RESULT_LATE = 0x57450001, /* the result did not come in time */
  WEIR_RESULT_REFUSED,           /* another process or machine rejected the frame */
  WEIR_RESULT_LOST               /* another process or machine has ended, or cannot be reached */
};
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
  /* weir_sink_calls, weir_frame_holder, weir_engine_finder */
  const void* (*extension)(const char* id);
} weir_host;

/* "weir.sink/1", an extension of the host: the output of a decoder. */
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

#define WEIR_HOLD_FRAME "weir.hold-frame/1"

/* An extension of the host that keeps input memory valid beyond its invoke, for engines that pass
 * it to code which may retain it. */
typedef struct {
  uint32_t struct_size;
  /* Call it on the thread of invoke for the frame being invoked. The memory of all its inputs stays
   * valid and unchanged until release(owner) is called, once, on any thread. Returns 0, or below 0
   * when the host cannot: batches, worker processes, memory that a program lent for a call. */
  int (*hold)(const weir_frame* in, void (**release)(void* owner), void** owner);
} weir_frame_holder;

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
  /* weir_execution_calls, weir_engine_statistics, weir_engine_servers, and texts:
   * - "weir.accelerators/1", const char*: a comma-separated list of the supported accelerators
   *   ("cpu,cpu.simd,gpu"), the automatic choice first.
   * - "weir.library/1", const char* const[2]: path and version of the engine's library; NULL when
   *   it is missing or unusable.
   * - "weir.library-problem/1", const char* const[2]: that problem and the command that fixes it,
   *   valid until the thread's next call; NULL without a problem. */
  const void* (*extension)(const char* id);
} weir_engine;

#define WEIR_FIND_ENGINE "weir.find-engine/1"

/* An extension of the host for engines that delegate a model to another engine, for example after
 * translating it. */
typedef struct {
  uint32_t struct_size;
  /* Finds the engine with this name or alias. Its module is opened on first use and stays open.
   * Returns 0, or below 0 with the error filled: ENGINE_UNKNOWN, ENGINE_NOT_INSTALLED with the
   * install command, MODULE_REFUSED. Any thread, but not during weir_module_entry. */
  int (*find)(const char* name, const weir_engine** out, weir_error*);
} weir_engine_finder;

/* The extensions of an engine report on an open model. `tensor_filter` shows them in `stats`. */
#define WEIR_EXECUTION "weir.execution/1"
#define WEIR_ENGINE_STATISTICS "weir.statistics/1"
#define WEIR_ENGINE_SERVERS "weir.servers/1"

/* The execution settings of a model. */
typedef struct {
  uint32_t struct_size; /* set by the caller; later members are not written */
  uint32_t threads;     /* of one invoke; 0 = not chosen yet: depends on the input shapes */
  uint32_t spins;       /* 1: idle threads spin between operators instead of sleeping */
} weir_execution;

/* Reports the execution settings that the engine chose for a model. */
typedef struct {
  uint32_t struct_size;
  /* Describes an open model; resolve() may change the result. Any thread. Returns 0, or below 0
   * when the engine does not know. */
  int (*describe)(weir_model*, weir_execution*);
} weir_execution_calls;

/* FROZEN. */
typedef struct {
  const char* name; /* lower case with hyphens; valid until the process ends */
  uint64_t value;
} weir_statistic;

/* Reports counts of the engine's own. */
typedef struct {
  uint32_t struct_size;
  /* Writes up to `room` statistics of an open model. Returns how many it has, or below 0. Any
   * thread, also during an invoke. */
  int (*read)(weir_model*, weir_statistic* out, uint32_t room);
} weir_engine_statistics;

/* Whether a server gets requests. */
enum weir_circuit {
  WEIR_CIRCUIT_CLOSED = 0,    /* it does */
  WEIR_CIRCUIT_HALF_OPEN = 1, /* one, whose response closes the circuit */
  WEIR_CIRCUIT_OPEN = 2       /* none, until a probe finds it ready */
};

/* FROZEN. -1: not known. */
typedef struct {
  const char* address; /* valid until the model is closed */
  int32_t circuit;     /* weir_circuit */
  uint32_t in_flight;
  /* Requests that were sent to this server, by how they ended there. A request that another server
   * answered in the end is one of both. */
  uint64_t answered, late, refused, lost;
  uint64_t bytes_sent, bytes_received;
  int64_t p50_us, p95_us, p99_us; /* of the last responses */
  int64_t queue_us, compute_us;   /* mean time of a request in the server, as it reports it */
  /* How far the server's clock is ahead, in nanoseconds, within clock_error_ns; known only if that
   * is not below 0. */
  int64_t clock_offset_ns, clock_error_ns;
} weir_server;

/* Reports on each server that a model is on. */
typedef struct {
  uint32_t struct_size;
  /* Writes up to `room` servers of an open model, in the order of its addresses. Returns how many
   * it has, or below 0. Any thread, also during an invoke. */
  int (*read)(weir_model*, weir_server* out, uint32_t room);
  /* The address of the server that answered the last invoke of a session; null while none has.
   * Valid until the model is closed. Called by the thread of that invoke, before the next. */
  const char* (*answered_by)(weir_session*);
} weir_engine_servers;

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
  /* Decodes one frame into the sink. `in` is read-only and valid for the call. What host->fail
   * filled in before a call that succeeds is a warning about the frame. */
  int (*decode)(weir_decoder*, const weir_frame* in, weir_sink*, weir_error*);
  int (*set_option)(weir_decoder*, const weir_option*, weir_error*);
  void (*reset)(weir_decoder*); /* after a flush: frames before it are forgotten */
  /* weir_decoder_stream, _model, _caps, _times, _labels */
  const void* (*extension)(const char* id);
} weir_decoder_type;

/* The extensions of a decoder pass what it knows or needs of the stream besides its tensors. The
 * host calls them on the thread of configure and decode. */
#define WEIR_DECODER_STREAM "weir.decoder-stream/1"
#define WEIR_DECODER_MODEL "weir.decoder-model/1"
#define WEIR_DECODER_CAPS "weir.decoder-caps/1"
#define WEIR_DECODER_TIMES "weir.decoder-times/1"
#define WEIR_DECODER_LABELS "weir.decoder-labels/1"

/* WITH_HEADERS: in flexible streams, `data` and `bytes` of each tensor include its 128-byte header;
 * `info` still describes the payload, and share_input still appends the payload alone. */
enum weir_decoder_stream_flag { WEIR_DECODER_WITH_HEADERS = 1 };

/* For formats that carry the frame rate or the headers of flexible tensors. */
typedef struct {
  uint32_t struct_size;
  uint32_t flags; /* weir_decoder_stream_flag */
  /* Called before each configure: the frame rate n/d of the input (0/1 = variable or unknown), and
   * whether it is flexible. */
  void (*set_stream)(weir_decoder*, int32_t rate_n, int32_t rate_d, int is_flexible);
} weir_decoder_stream;

/* What is known of the model whose outputs the decoder reads; tensor_filter sends it downstream
 * with its stream. Valid for the call. Tensors have the names and the quantisation of the model
 * file. */
typedef struct {
  uint32_t struct_size;
  uint32_t n_inputs, n_outputs;
  const weir_tensor_info *inputs, *outputs;
  const char* path;          /* of the model file, or NULL */
  const char* metadata_json; /* an object of strings, as in weir_model_info, or NULL */
  /* Names of classes in the model's card. Check struct_size before you read them. */
  const char* const* card_labels;
  uint32_t n_card_labels;
} weir_stream_model;

typedef struct {
  uint32_t struct_size;
  uint32_t reserved;
  /* Called before configure. NULL: the stream's model is not known. Outputs are those of the
   * stream: the host passes a model only if types and shapes are equal. */
  void (*set_model)(weir_decoder*, const weir_stream_model*);
} weir_decoder_model;

/* For formats that carry other fields of the input caps, such as weir-columns (results.h). */
typedef struct {
  uint32_t struct_size;
  uint32_t reserved;
  /* Called before each configure: the text fields of the input caps, by name. Valid for the
   * call. */
  void (*set_caps)(weir_decoder*, const weir_option* fields, uint32_t n);
} weir_decoder_caps;

/* For formats that write times beyond those of weir_frame, whose pts is of the segment. */
typedef struct {
  uint32_t struct_size;
  uint32_t reserved;
  /* Called before each decode, in nanoseconds: the frame's running time, and when it was captured,
   * since 1970 UTC. -1 = unknown. */
  void (*set_times)(weir_decoder*, int64_t running_time, int64_t unix_time);
} weir_decoder_times;

/* Names of classes. A decoder that writes results reports those of its results, and the host sends
 * them downstream with the stream; a decoder that reads results receives those of the sources in
 * weir-source (results.h). */
typedef struct {
  uint32_t struct_size;
  uint32_t reserved;
  /* Called after configure: the number of names, which are those of class 0 and the classes after
   * it; 0 = not known. They stay valid until the next call of the decoder. NULL: the decoder writes
   * no results. */
  uint32_t (*labels)(weir_decoder*, const char* const** names);
  /* Called before configure and between frames: the names of the classes of one source, valid for
   * the call. NULL: the decoder does not use them. */
  void (*set_labels)(weir_decoder*, const char* source, const char* const* names, uint32_t n);
  /* Called after configure: the number of classes that the model tells apart; 0 = not known. The
   * host warns of fewer names than that. NULL, or beyond struct_size: not known. */
  uint32_t (*classes)(weir_decoder*);
} weir_decoder_labels;

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
  const void* (*extension)(const char* id); /* weir_converter_rate, weir_converter_stream */
} weir_converter_type;

/* The extensions of a converter report on the frame of a convert that succeeded. The host calls
 * them after it, on its thread. */
#define WEIR_CONVERTER_RATE "weir.converter-rate/1"
#define WEIR_CONVERTER_STREAM "weir.converter-stream/1"

/* For formats whose frames carry their own frame rate. Without it the stream keeps the rate of its
 * input caps. */
typedef struct {
  uint32_t struct_size;
  /* Returns 1 and the frame rate n/d that the frame carried (0/1 = variable), or 0 when it carried
   * none. */
  int (*rate)(weir_converter*, int32_t* n, int32_t* d);
} weir_converter_rate;

/* For formats whose frames may hold flexible tensors. Without it the output is static. */
typedef struct {
  uint32_t struct_size;
  /* Nonzero: the tensors of the frame are flexible. Each begins with its 128-byte header, which
   * `bytes` includes and which the host compares with `info`. */
  int (*is_flexible)(weir_converter*);
} weir_converter_stream;

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
