/* The plug-in ABI of Weir, version 1: engines, decoders and converters, Weir's own and a user's.
 *
 * A module is a shared object that exports one symbol, weir_module_entry. Rules:
 *  (A) structs that travel in arrays are frozen: reserved words, 0 = absent;
 *  (B) other structs start with struct_size, are passed by pointer, members are only appended: who
 *      reads or fills one that the other side made looks no further than its struct_size says;
 *  (C) shapes are outermost-first as in NumPy, -1 = unknown; only the text grammar of caps and
 *      properties is innermost-first.
 * Functions that return int: 0 = success, -code (codes.h) = failure with the weir_error filled
 * through host->fail, and for invoke and decode > 0 = drop this frame silently.
 * Strings are UTF-8, zero-terminated, owned by the giver and valid for the call unless said. */
#ifndef WEIR_ABI_H
#define WEIR_ABI_H
#include <stddef.h>
#include <stdint.h>

#include "weir/codes.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A module of another major version is refused; minor versions only append. */
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
/* What the maps of a frame belong to: one for all tensors or one for each; or, for batches, one for
 * each index of the outermost dimension, of every tensor. */
enum weir_maps_of { WEIR_MAPS_OF_TENSORS = 0, WEIR_MAPS_OF_REGIONS };
enum weir_frame_flag { WEIR_FRAME_DISCONT = 1, WEIR_FRAME_GAP = 2, WEIR_FRAME_LAST = 4 };
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
/* NEEDS_NO_MODEL: model= may be left out. MODEL_IS_NO_FILE: what model= says is a name or text that
 * the engine understands; the host does not look for a file. */
enum weir_engine_flag { WEIR_ENGINE_NEEDS_NO_MODEL = 1, WEIR_ENGINE_MODEL_IS_NO_FILE = 2 };
/* WARM: do now what a first invoke would do. SUSPEND: give back what RESUME can bring again;
 * without it the host closes the model and opens it again. RESET_STATE: what follows does not
 * continue what was. SET_OPTION: the options came with the call. A code below 0: not known here. */
enum weir_control { WEIR_WARM = 0, WEIR_SUSPEND, WEIR_RESUME, WEIR_RESET_STATE, WEIR_SET_OPTION };
enum weir_log_level { WEIR_LOG_ERROR = 1, WEIR_LOG_WARNING, WEIR_LOG_INFO, WEIR_LOG_DEBUG };

/* One tensor's description. FROZEN, 192 bytes on LP64. */
typedef struct {
  uint32_t type, rank;
  int64_t shape[WEIR_RANK_LIMIT]; /* outermost-first, -1 = unknown */
  const char* name;               /* or NULL; lives as long as its giver says */
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

/* Where the pixels of a tensor lie in the picture that it was made from, in pixels from the left
 * upper corner, whole numbers being the edges between pixels: source x = xx * x + xy * y + x0,
 * source y = yx * x + yy * y + y0. FROZEN, 80 bytes on LP64. */
typedef struct {
  double xx, xy, x0, yx, yy, y0;
  uint32_t source_width, source_height, width, height; /* of the picture, of the tensor */
  uint32_t x_dimension, y_dimension;                   /* of the tensor, 0 = innermost */
  uint64_t reserved[1];
} weir_picture_map;

typedef struct {
  uint32_t struct_size, n_tensors;
  weir_tensor* tensors;
  int64_t pts, duration, deadline; /* ns; the deadline in running time; -1 = none */
  uint64_t stream_id, sequence;
  uint32_t flags;
  uint32_t n_maps, maps_of; /* weir_maps_of */
  const weir_picture_map* maps;
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

/* Given by the host; a module needs no other symbol of Weir. Lives until the process ends. */
typedef struct {
  uint32_t struct_size;
  uint16_t abi_major, abi_minor;
  /* Fills the error (NULL parts are left out, any length, copied) and returns -code. */
  int (*fail)(weir_error*, int code, const char* what, const char* offered, const char* needed,
              const char* difference, const char* fix);
  void (*log)(int level, const char* module, const char* text);
  /* Memory of the host for one tensor: sets data, bytes, capacity, release, owner. */
  int (*allocate)(void* host_ctx, uint32_t memory_kind, uint64_t bytes, uint32_t alignment,
                  weir_tensor* out);
  /* Ends or continues a submit(), from any thread: 1..N times, the last with more = 0, after which
   * the request and its input are gone. status: as invoke returns; out: one output, or NULL = none
   * with this call. Its tensors are taken over: the host releases them. May wait until earlier
   * outputs were taken, but not for the end of other requests. */
  void (*complete)(weir_request*, int status, weir_frame* out, uint32_t more);
  /* The request's error, to be filled through fail() before complete() with a status below 0. */
  weir_error* (*error_of)(weir_request*);
  /* Nobody waits for this request any more: complete it as soon as may be. Cheap, to be polled. */
  int (*cancelled)(const weir_request*);
  const void* (*extension)(const char* id); /* "weir.sink/1" = const weir_sink_calls* */
} weir_host;

/* Where a decoder or converter puts what it makes; got through host->extension("weir.sink/1"). */
typedef struct {
  uint32_t struct_size;
  /* configure: the caps of the output stream as GStreamer text; framerate is added by the host. */
  int (*set_caps)(weir_sink*, const char* caps, weir_error*);
  /* Writable memory of the frame's output, `bytes` long, valid until the call returns. More than
   * one call appends further memories. NULL when memory ran out. */
  void* (*reserve)(weir_sink*, uint64_t bytes);
  /* Appends tensor `index` of the input frame, shared, not copied. */
  int (*share_input)(weir_sink*, uint32_t index, weir_error*);
} weir_sink_calls;

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

typedef struct {
  uint32_t struct_size, flags;
  uint32_t n_inputs, n_outputs;
  const weir_tensor_info *inputs, *outputs; /* and names: live until the model is closed */
  /* Bytes, 0 = none. Every input starts at a multiple of alignment (a power of two up to 4096) and
   * has input_padding readable bytes behind it (up to 65536): where a stream's memory lacks them,
   * the host copies, so ask for what is needed only. */
  uint32_t alignment, input_padding;
  uint64_t memory_kinds; /* bit per weir_memory_kind */
  /* Sessions at a time, 0 = any; submitted and not completed ones of a session, 0 = 1; frames of an
   * invoke, 0 = the engine does not say. */
  uint32_t max_sessions, max_in_flight, preferred_batch;
  uint64_t weight_bytes;
  const char* metadata_json; /* or NULL */
} weir_model_info;

typedef struct {
  uint32_t struct_size;
  uint16_t abi_major, abi_minor;
  const char *name, *version, *aliases, *extensions; /* lists: comma-separated, "tflite" no dot */
  /* What custom= takes: [{"name":"threads","type":"integer","default":"1","help":"..."}], or NULL.
   * type: boolean, integer, number, text, file, values: "a|b". "setting":"group/key" of weir.ini */
  const char* options_json;
  uint64_t flags; /* weir_engine_flag */
  /* Looks at the first n bytes: no load, no side effect. score 0 (not mine) to 100 (surely). */
  int (*probe)(const char* path, const void* head, size_t n, int* score, weir_error*);
  int (*open)(const weir_open*, weir_model**, weir_error*);
  void (*close)(weir_model*);
  int (*info)(weir_model*, weir_model_info*, weir_error*);
  int (*session_new)(weir_model*, const weir_option*, uint32_t n, weir_session**, weir_error*);
  void (*session_free)(weir_session*);
  /* Given the inputs' shapes, says the outputs'. What stays unknown keeps -1. */
  int (*resolve)(weir_session*, const weir_tensor_info* in, uint32_t n_in, weir_tensor_info* out,
                 uint32_t n_out, weir_error*);
  int (*invoke)(weir_session*, const weir_frame* in, weir_frame* out, weir_error*);
  /* Optional: begins what host->complete() ends. `in` may be read until then; nothing is completed
   * where this returns below 0. */
  int (*submit)(weir_session*, const weir_frame* in, weir_request*, weir_error*);
  void (*cancel)(weir_session*, weir_request*); /* optional; complete() still comes */
  int (*control)(weir_session*, int op, const weir_option*, weir_error*); /* weir_control */
  /* "weir.accelerators/1" = const char*, a comma list of what it runs on ("cpu,cpu.simd,gpu"), its
   * automatic choice first. Another id: NULL. */
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

/* A decoder: tensors become pixels, text or bytes. */
typedef struct {
  uint32_t struct_size;
  uint16_t abi_major, abi_minor;
  const char *name, *aliases;
  const char* options_json; /* [{"name":"option1","type":"file","default":"","help":"..."}] */
  int (*open)(const weir_option*, uint32_t n, void* host_ctx, weir_decoder**, weir_error*);
  void (*close)(weir_decoder*);
  /* The input's tensors are known: says the output caps through the sink's set_caps. */
  int (*configure)(weir_decoder*, const weir_tensor_info* in, uint32_t n,
                   const char* downstream_caps, weir_sink*, weir_error*);
  int (*decode)(weir_decoder*, const weir_frame* in, weir_sink*, weir_error*);
  int (*set_option)(weir_decoder*, const weir_option*, weir_error*);
  void (*reset)(weir_decoder*); /* after a flush: what follows does not continue what was */
  const void* (*extension)(const char* id);
} weir_decoder_type;

/* An external converter: a media stream becomes tensors. */
typedef struct {
  uint32_t struct_size;
  uint16_t abi_major, abi_minor;
  const char *name, *aliases;
  const char* caps; /* what it takes, as GStreamer caps text */
  const char* options_json;
  int (*open)(const weir_option*, uint32_t n, void* host_ctx, weir_converter**, weir_error*);
  void (*close)(weir_converter*);
  /* Input caps (text) -> tensors; n_out in: room, out: count; 0 or open parts: not known before
   * the first frame. */
  int (*configure)(weir_converter*, const char* caps, weir_tensor_info* out, uint32_t* n_out,
                   weir_error*);
  /* `in` holds one uint8 tensor per memory, readable until convert returns. out->n_tensors in:
   * room, out: count; the tensors are allocated by the converter through host->allocate, their info
   * filled: it may differ from configure's and renegotiates then. out's time is the input's until
   * it is changed. What a failed call allocated is released by the host. */
  int (*convert)(weir_converter*, const weir_frame* in, weir_frame* out, weir_error*);
  void (*reset)(weir_converter*);
  const void* (*extension)(const char* id);
} weir_converter_type;

typedef struct {
  uint32_t struct_size;
  uint16_t abi_major, abi_minor;
  const weir_engine* const* engines; /* lists: NULL-terminated, or NULL */
  const weir_decoder_type* const* decoders;
  const weir_converter_type* const* converters;
  const void* const* trainers;
  const void* (*extension)(const char* id);
} weir_module;

/* The one exported symbol. NULL = not usable here; the reason went through host->log. */
const weir_module* weir_module_entry(const weir_host*);

#ifdef __cplusplus
}
#endif
#endif /* WEIR_ABI_H */
