/* Filters implemented by the application. `tensor_filter framework=custom-easy model=NAME` calls
 * the function that the program registered under NAME. `framework=cpp model=NAME` opens models of a
 * class, which may be in a library: `model=NAME,lib.so`. In C++: custom_filter.hpp.
 *
 * libweir (pkg-config weir) exports the functions below. A program that does not link with it looks
 * them up in the plug-in that GStreamer loaded, as custom_converter.h shows.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_CUSTOM_FILTER_H
#define WEIR_CUSTOM_FILTER_H
#include "weir/error.h"

#ifdef __cplusplus
extern "C" {
#endif

/* DYNAMIC: the function chooses the outputs' sizes for each frame; such a filter requires
 * invoke-dynamic=true, all others require false. THREAD_SAFE: several threads may call the function
 * at once; without it calls are serialised across all elements that name the filter. STATEFUL:
 * frames must arrive in order, hence workers=1. */
enum weir_filter_flag {
  WEIR_FILTER_DYNAMIC = 1,
  WEIR_FILTER_THREAD_SAFE = 2,
  WEIR_FILTER_STATEFUL = 4
};

/* Computes the outputs of one frame, on a thread of the element.
 *
 * - host: its allocate, fail and log may be used; pass NULL as host_ctx of allocate.
 * - in: the inputs: dense, shapes outermost-first, read-only, readable until the function returns;
 *   pts and duration in ns, -1 = none.
 * - out: the outputs, with info set. Write `bytes` bytes into each `data` and change nothing else.
 *   For a DYNAMIC filter `data` is NULL: fill `info` and allocate through host->allocate.
 * - data: the pointer that was registered.
 *
 * Returns 0; > 0 to drop the frame; a code below 0, with `error` filled through host->fail, to end
 * the stream with that error. Must not throw. */
typedef int (*weir_filter_invoke)(const weir_host* host, const weir_frame* in, weir_frame* out,
                                  void* data, weir_error* error);

/* Computes the outputs' types and shapes for these inputs when the description leaves them open.
 * Returns 0, or a code below 0 with `error` filled, which rejects the stream with that error. */
typedef int (*weir_filter_resolve)(const weir_host* host, const weir_tensor_info* in, uint32_t n_in,
                                   weir_tensor_info* out, uint32_t n_out, void* data,
                                   weir_error* error);

typedef struct {
  uint32_t struct_size, flags; /* weir_filter_flag */
  uint32_t n_inputs, n_outputs;
  /* Copied, including names. Shapes are outermost-first, -1 = the stream decides; rank
   * WEIR_RANK_UNKNOWN and type WEIR_TYPE_END are open as well. */
  const weir_tensor_info *inputs, *outputs;
  weir_filter_invoke invoke;
  weir_filter_resolve resolve; /* or NULL: the outputs are known, or the filter is DYNAMIC */
  void* data;
  void (*release)(void* data); /* or NULL; called once, when no element uses the filter any more */
} weir_filter;

/* Registers `filter` under `name`. Copies both and takes ownership of `data`. Thread-safe. Returns
 * 0, or a code below 0 and, unless `error` is NULL, the reason in *error (error.h); the caller then
 * keeps `data`. WEIR_OPTION_VALUE: the name is empty, reserved or taken, or the description is
 * invalid. */
WEIR_EXPORT int weir_filter_register(const char* name, const weir_filter* filter,
                                     weir_error** error);
/* Releases the name. With a `release` function, elements that use the filter continue with it, and
 * `release` is called when the last one stops, immediately if there is none. Without one, it waits
 * for calls on other threads: once it has returned, the filter is not running and is not called
 * again; later frames fail with CALLBACK_UNKNOWN. May be called from a function of the filter.
 * Thread-safe. Returns 0, or -WEIR_CALLBACK_UNKNOWN when no filter has this name. */
WEIR_EXPORT int weir_filter_unregister(const char* name);

/* Registers an engine of the process under `name` for framework=cpp; each element that names it
 * opens its own model. `entry` is called immediately and returns one engine (abi.h). Its tables are
 * copied; its functions must stay loaded until the last element has stopped. A library named in
 * model= either calls this function when it is loaded (in a constructor), or exports
 * weir_module_entry with an engine called NAME and links nothing of Weir. Thread-safe. Returns 0,
 * or a code below 0 and, unless `error` is NULL, the reason in *error. WEIR_OPTION_VALUE: the name
 * is empty, reserved or taken; WEIR_MODULE_REFUSED: the tables of `entry` are unusable. */
WEIR_EXPORT int weir_filter_class_register(const char* name,
                                           const weir_module* (*entry)(const weir_host*),
                                           weir_error** error);
/* Releases the name. Open models continue. Thread-safe. Returns 0, or -WEIR_CALLBACK_UNKNOWN when
 * no class has this name. */
WEIR_EXPORT int weir_filter_class_unregister(const char* name);

#ifdef __cplusplus
}
#endif
#endif /* WEIR_CUSTOM_FILTER_H */
