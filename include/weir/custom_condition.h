 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* Conditions of the process itself: `tensor_if compared-value=CUSTOM compared-value-option=NAME`
 * calls a function that the program registered under NAME. In C++: custom_condition.hpp.
 *
 * The functions below are exported by libweir (pkg-config weir). A program that does not link with
 * it takes them from the plug-in that GStreamer loaded, as custom_converter.h shows.
 */
#ifndef WEIR_CUSTOM_CONDITION_H
#define WEIR_CUSTOM_CONDITION_H
#include "weir/abi.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Decides for one frame, on the streaming thread of the element that calls it.
 *   host    its fail and log.
 *   in      the tensors of the frame: dense, shapes outermost-first, readable until the function
 *           returns, not to be written; pts and duration in ns, -1 = none.
 *   result  to be set: 0 for the ELSE branch, anything else for THEN. It is 0 before.
 *   data    as it was registered.
 * Returns 0; a code below 0 with `error` filled through host->fail (WEIR_CALLBACK_FAILED is shown
 * with its words, and the stream ends); above 0 to drop the frame. Nothing may be thrown. */
typedef int (*weir_condition_function)(const weir_host* host, const weir_frame* in, int* result,
                                       void* data, weir_error* error);

#ifndef WEIR_EXPORT
#define WEIR_EXPORT __attribute__((visibility("default")))
#endif

/* Registers `condition` under `name`, which is copied. An element looks the name up at its first
 * frame; `data` must live until weir_condition_unregister has returned. Thread-safe. Returns 0,
 * -WEIR_OPTION_VALUE when the name is empty or taken or `condition` is NULL, -WEIR_OUT_OF_MEMORY.
 */
WEIR_EXPORT int weir_condition_register(const char* name, weir_condition_function condition,
                                        void* data);
/* Frees the name. No call of the function runs once this returns and none begins: it waits for the
 * calls of other threads, and later frames are errors (CALLBACK_UNKNOWN) until the name is
 * registered again. The function may call it. Thread-safe. Returns 0, or -WEIR_CALLBACK_UNKNOWN
 * when no function has this name. */
WEIR_EXPORT int weir_condition_unregister(const char* name);

#ifdef __cplusplus
}
#endif
#endif /* WEIR_CUSTOM_CONDITION_H */
