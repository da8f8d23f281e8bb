/* Converters implemented by the application: `tensor_converter mode=custom-code:NAME` calls the
 * function that the program registered under NAME.
 *
 * libweir (pkg-config weir) exports the functions below. A program that does not link with it looks
 * them up in the plug-in that GStreamer loaded, which depends on the library:
 *
 *   GstPlugin *plugin = gst_registry_find_plugin (gst_registry_get (), "weir");
 *   void *file = dlopen (gst_plugin_get_filename (plugin), RTLD_NOW);
 *   int (*add) (const char *, weir_convert_function, void *) =
 *       dlsym (file, "weir_converter_register");
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_CUSTOM_CONVERTER_H
#define WEIR_CUSTOM_CONVERTER_H
#include "weir/error.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Converts one buffer to tensors, on the streaming thread of the element that calls it.
 *
 * - host: its allocate and fail may be used; pass NULL as host_ctx of allocate.
 * - caps: those of the stream, as GStreamer text.
 * - in: one uint8 tensor for each memory of the buffer, readable until the function returns.
 * - out: n_tensors is the capacity on entry, the count on return. For each tensor the function
 *   fills `info` (shape outermost-first) and allocates memory through host->allocate. The time is
 *   preset to the input's. The host releases what a failed call has allocated.
 * - data: the pointer that was registered.
 *
 * Returns 0; a code below 0 with `error` filled through host->fail; > 0 to drop the frame. */
typedef int (*weir_convert_function)(const weir_host* host, const char* caps, const weir_frame* in,
                                     weir_frame* out, void* data, weir_error* error);

/* Registers `convert` under `name`, which is copied. An element looks the name up at its first
 * frame. `data` must stay valid until weir_converter_unregister has returned. Thread-safe. Returns
 * 0; -WEIR_OPTION_VALUE when the name is empty or taken or `convert` is NULL;
 * -WEIR_OUT_OF_MEMORY. */
WEIR_EXPORT int weir_converter_register(const char* name, weir_convert_function convert,
                                        void* data);
/* Releases the name. Waits for calls on other threads: once it has returned, the function is not
 * running and is not called again. Later frames fail with CONVERTER_UNKNOWN until the name is
 * registered again. May be called from the function itself. Thread-safe. Returns 0, or
 * -WEIR_CONVERTER_UNKNOWN when no function has this name. */
WEIR_EXPORT int weir_converter_unregister(const char* name);

#ifdef __cplusplus
}
#endif
#endif /* WEIR_CUSTOM_CONVERTER_H */
