/* A function of the application as a filter: `tensor_filter framework=custom-easy model=NAME`.
 *
 * Link with pkg-config nnstreamer. The functions return 0; -EINVAL for an empty, reserved (any,
 * auto) or taken name, a NULL, or an invalid description; -ENOMEM. The reason is in the log.
 * Thread-safe.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef NNSTREAMER_TENSOR_FILTER_CUSTOM_EASY_H
#define NNSTREAMER_TENSOR_FILTER_CUSTOM_EASY_H
#include "nnstreamer_util.h"
#include "tensor_filter_custom.h"
#include "tensor_typedef.h"

#ifdef __cplusplus
extern "C" {
#endif

/* `func` gets `data` as priv and is called for one frame at a time. The descriptions are copied.
 * One of format flexible gives only the number of tensors: each frame carries the info of its
 * inputs, and each output has that of the input with the same index. */
NNS_EXPORT int NNS_custom_easy_register(const char* name, NNS_custom_invoke func, void* data,
                                        const GstTensorsInfo* in_info,
                                        const GstTensorsInfo* out_info);
/* For elements with invoke-dynamic=true; other filters need it false. */
NNS_EXPORT int NNS_custom_easy_dynamic_register(const char* name, NNS_custom_invoke_dynamic func,
                                                void* data, const GstTensorsInfo* in_info);
/* Releases the name. Elements that use the filter continue with it, so `data` must stay valid until
 * they have stopped. -EINVAL if the name is not registered. */
NNS_EXPORT int NNS_custom_easy_unregister(const char* name);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_TENSOR_FILTER_CUSTOM_EASY_H */
