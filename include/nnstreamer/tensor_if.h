 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* Conditions of a program: `tensor_if compared-value=CUSTOM compared-value-option=NAME`. Link with
 * pkg-config nnstreamer. */
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

/* Puts into *result whether `then` applies to this frame. Returns false when it failed. */
typedef bool (*tensor_if_custom)(const GstTensorsInfo* info, const GstTensorMemory* input,
                                 void* user_data, bool* result);

/* 0; -EINVAL for a name that is empty, reserved or taken, or no function; -ENOMEM. Before the
 * element's properties are set. Return values derived. Thread-safe. */
NNS_EXPORT int nnstreamer_if_custom_register(const char* name, tensor_if_custom func, void* data);
/* 0, or -EINVAL when there is none of this name. */
NNS_EXPORT int nnstreamer_if_custom_unregister(const char* name);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_TENSOR_IF_H */
