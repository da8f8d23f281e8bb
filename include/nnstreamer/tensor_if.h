/* Conditions implemented by the application: `tensor_if compared-value=CUSTOM
 * compared-value-option=NAME`. Link with pkg-config nnstreamer.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef NNSTREAMER_TENSOR_IF_H
#define NNSTREAMER_TENSOR_IF_H
#ifndef __cplusplus
#include <stdbool.h>
#endif

#include "nnstreamer_util.h"
#include "tensor_typedef.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Sets *result to true if the `then` action applies to this frame. Returns false on failure. */
typedef bool (*tensor_if_custom)(const GstTensorsInfo* info, const GstTensorMemory* input,
                                 void* user_data, bool* result);

/* Returns 0; -EINVAL for an empty, reserved or taken name or a NULL function; -ENOMEM. Call it
 * before the element's properties are set. Return values derived. Thread-safe. */
NNS_EXPORT int nnstreamer_if_custom_register(const char* name, tensor_if_custom func, void* data);
/* Returns 0, or -EINVAL if the name is not registered. */
NNS_EXPORT int nnstreamer_if_custom_unregister(const char* name);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_TENSOR_IF_H */
