 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* Filters of the process itself. `tensor_filter framework=custom-easy model=NAME` calls a function
 * that the program registered under NAME; `framework=cpp model=NAME` opens models of a class, which
 * a library may bring: `model=NAME,lib.so`. In C++: custom_filter.hpp.
 *
 * The functions below are exported by libweir (pkg-config weir). A program that does not link with
 * it takes them from the plug-in that GStreamer loaded, as custom_converter.h shows.
 */
#ifndef WEIR_CUSTOM_FILTER_H
#define WEIR_CUSTOM_FILTER_H
#include "weir/error.h"

#ifdef __cplusplus
extern "C" {
#endif

/* DYNAMIC: the function decides the outputs' sizes with each frame; such a filter needs
 * invoke-dynamic=true, every other one needs it false. THREAD_SAFE: several threads may be in the
 * function at once; without it they wait for each other, whichever elements name the filter.
 * STATEFUL: frames must come in their order: workers=1. */
enum weir_filter_flag {
  WEIR_FILTER_DYNAMIC = 1,
  WEIR_FILTER_THREAD_SAFE = 2,
  WEIR_FILTER_STATEFUL = 4
};

/* Makes the outputs of one frame, on a thread of the element.
 *   host  its allocate, fail and log; host_ctx of allocate is NULL.
 *   in    the inputs: dense, shapes outermost-first, not to be written, readable until the function
 *         returns; pts and duration in ns, -1 = none.
 *   out   the outputs, described. Their memory is there, `bytes` long, to be written into; nothing
 *         else of them may be changed. Of a DYNAMIC filter `data` is NULL: the function fills
 *         `info` and gets memory through host->allocate.
 *   data  as it was registered.
 * Returns 0; above 0 to drop the frame; a code below 0 with `error` filled through host->fail: the
 * stream ends with its words. Nothing may be thrown. */
typedef int (*weir_filter_invoke)(const weir_host* host, const weir_frame* in, weir_frame* out,
                                  void* data, weir_error* error);

/* Says the outputs' types and shapes for inputs of these, where the description leaves them open.
 * Returns 0, or a code below 0 with `error` filled: the stream is refused with its words. */
typedef int (*weir_filter_resolve)(const weir_host* host, const weir_tensor_info* in, uint32_t n_in,
                                   weir_tensor_info* out, uint32_t n_out, void* data,
                                   weir_error* error);

typedef struct {
  uint32_t struct_size, flags; /* weir_filter_flag */
  uint32_t n_inputs, n_outputs;
  /* Copied, with their names. Shapes outermost-first, -1 = the stream decides; the rank
   * WEIR_RANK_UNKNOWN and the type WEIR_TYPE_END are open too. */
  const weir_tensor_info *inputs, *outputs;
  weir_filter_invoke invoke;
  weir_filter_resolve resolve; /* or NULL: the outputs are known, or the filter is DYNAMIC */
  void* data;
  void (*release)(void* data); /* or NULL; called once, when no element has the filter any more */
} weir_filter;

/* Registers `filter` under `name`; both are copied, `data` is taken over. Thread-safe. Returns 0,
 * or a code below 0 and, where `error` is not NULL, the words in *error (error.h); `data` stays the
 * caller's then. WEIR_OPTION_VALUE: the name is empty, reserved or taken, or the description cannot
 * be. */
WEIR_EXPORT int weir_filter_register(const char* name, const weir_filter* filter,
                                     weir_error** error);
/* Frees the name. With a `release` function, elements that have the filter go on with it, and
 * `release` is called when the last one stops, at once where there is none. Without one, no call of
 * the filter runs once this returns and none begins: it waits for the calls of other threads, and
 * later frames are errors (CALLBACK_UNKNOWN). A function of the filter may call it. Thread-safe.
 * Returns 0, or -WEIR_CALLBACK_UNKNOWN when no filter has this name. */
WEIR_EXPORT int weir_filter_unregister(const char* name);

/* Registers an engine of the process under `name`, for framework=cpp: each element that names it
 * opens a model of its own. `entry` is called at once, and gives one engine (abi.h); its tables are
 * copied, its functions must stay until the last element has stopped. A library that is named in
 * model= may call this when it is loaded (a constructor), or export weir_module_entry with an
 * engine called NAME instead, and link nothing of Weir. Thread-safe. Returns 0, or a code below 0
 * and, where `error` is not NULL, the words in *error. WEIR_OPTION_VALUE: the name is empty,
 * reserved or taken; WEIR_MODULE_REFUSED: what `entry` gave cannot be used. */
WEIR_EXPORT int weir_filter_class_register(const char* name,
                                           const weir_module* (*entry)(const weir_host*),
                                           weir_error** error);
/* Frees the name. Models that are open go on. Thread-safe. Returns 0, or -WEIR_CALLBACK_UNKNOWN
 * when no class has this name. */
WEIR_EXPORT int weir_filter_class_unregister(const char* name);

#ifdef __cplusplus
}
#endif
#endif /* WEIR_CUSTOM_FILTER_H */
