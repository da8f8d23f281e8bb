/* Conditions implemented by the application: `tensor_if compared-value=CUSTOM
 * compared-value-option=NAME` calls the function that the program registered under NAME. In C++:
 * custom_condition.hpp.
 *
 * libweir (pkg-config weir) exports the functions below. A program that does not link with it looks
 * them up in the plug-in that GStreamer loaded, as custom_converter.h shows.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_CUSTOM_CONDITION_H
#define WEIR_CUSTOM_CONDITION_H
#include "weir/error.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Decides one frame, on the streaming thread of the element that calls it.
 *
 * - host: its fail and log may be used.
 * - in: the tensors of the frame: dense, shapes outermost-first, read-only, readable until the
 *   function returns; pts and duration in ns, -1 = none.
 * - result: set it to 0 for the ELSE branch, to anything else for THEN. It is preset to 0.
 * - data: the pointer that was registered.
 *
 * Returns 0; > 0 to drop the frame; a code below 0, with `error` filled through host->fail, to end
 * the stream with that error (WEIR_CALLBACK_FAILED). Must not throw. */
typedef int (*weir_condition_function)(const weir_host* host, const weir_frame* in, int* result,
                                       void* data, weir_error* error);

/* Registers `condition` under `name`, which is copied. An element looks the name up at its first
 * frame. `data` must stay valid until weir_condition_unregister has returned. Thread-safe. Returns
 * 0; -WEIR_OPTION_VALUE when the name is empty or taken or `condition` is NULL;
 * -WEIR_OUT_OF_MEMORY. */
WEIR_EXPORT int weir_condition_register(const char* name, weir_condition_function condition,
                                        void* data);
/* Releases the name. Waits for calls on other threads: once it has returned, the function is not
 * running and is not called again. Later frames fail with CALLBACK_UNKNOWN until the name is
 * registered again. May be called from the function itself. Thread-safe. Returns 0, or
 * -WEIR_CALLBACK_UNKNOWN when no function has this name. */
WEIR_EXPORT int weir_condition_unregister(const char* name);

#ifdef __cplusplus
}
#endif
#endif /* WEIR_CUSTOM_CONDITION_H */
