 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* Converters of the process itself: `tensor_converter mode=custom-code:NAME` calls a function that
 * the program registered under NAME.
 *
 * The functions below are exported by libweir (pkg-config weir). A program that does not link with
 * it takes them from the plug-in that GStreamer loaded, which brings the library along:
 *
 *   GstPlugin *plugin = gst_registry_find_plugin (gst_registry_get (), "weir");
 *   void *file = dlopen (gst_plugin_get_filename (plugin), RTLD_NOW);
 *   int (*add) (const char *, weir_convert_function, void *) = dlsym (file,
 * "weir_converter_register");
 */
#ifndef WEIR_CUSTOM_CONVERTER_H
#define WEIR_CUSTOM_CONVERTER_H
#include "weir/abi.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Makes tensors of one buffer, on the streaming thread of the element that calls it.
 *   host  its allocate and fail; host_ctx of allocate is NULL.
 *   caps  of the stream, as GStreamer text.
 *   in    one uint8 tensor for each memory of the buffer, readable until the function returns.
 *   out   n_tensors in: room, out: count. For each tensor the function fills `info` (shape
 *         outermost-first) and gets memory through host->allocate. The time is the input's until
 *         it is changed. What a failed call allocated is released by the host.
 *   data  as it was registered.
 * Returns 0; a code below 0 with `error` filled through host->fail; above 0 to drop the frame. */
typedef int (*weir_convert_function)(const weir_host* host, const char* caps, const weir_frame* in,
                                     weir_frame* out, void* data, weir_error* error);

#ifndef WEIR_EXPORT
#define WEIR_EXPORT __attribute__((visibility("default")))
#endif

/* Registers `convert` under `name`, which is copied. An element looks the name up at its first
 * frame; `data` must live until weir_converter_unregister has returned. Thread-safe. Returns 0,
 * -WEIR_OPTION_VALUE when the name is empty or taken or `convert` is NULL, -WEIR_OUT_OF_MEMORY. */
WEIR_EXPORT int weir_converter_register(const char* name, weir_convert_function convert,
                                        void* data);
/* Frees the name. No call of the function runs once this returns and none begins: it waits for the
 * calls of other threads, and later frames are errors (CONVERTER_UNKNOWN) until the name is
 * registered again. The function may call it. Thread-safe. Returns 0, or
 * -WEIR_CONVERTER_UNKNOWN when no function has this name. */
WEIR_EXPORT int weir_converter_unregister(const char* name);

#ifdef __cplusplus
}
#endif
#endif /* WEIR_CUSTOM_CONVERTER_H */
