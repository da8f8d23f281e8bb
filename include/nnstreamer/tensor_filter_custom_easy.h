 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* A function of the program itself as a filter: `tensor_filter framework=custom-easy model=NAME`.
 *
 * Link with pkg-config nnstreamer. The functions return 0; -EINVAL for a name that is empty,
 * reserved (any, auto) or taken, a NULL, or descriptions that are not valid; -ENOMEM. The words of
 * a refusal are in the log. Thread-safe. */
#ifndef NNSTREAMER_TENSOR_FILTER_CUSTOM_EASY_H
#define NNSTREAMER_TENSOR_FILTER_CUSTOM_EASY_H
#include "nnstreamer_util.h"
#include "tensor_filter_custom.h"
#include "tensor_typedef.h"

#ifdef __cplusplus
extern "C" {
#endif

/* `func` gets `data` as priv and is called for one frame at a time. The descriptions are copied.
 * One of format flexible says how many tensors there are and no more: each frame says its own
 * inputs, and outputs are as the inputs of the same number. */
NNS_EXPORT int NNS_custom_easy_register(const char* name, NNS_custom_invoke func, void* data,
                                        const GstTensorsInfo* in_info,
                                        const GstTensorsInfo* out_info);
/* For elements with invoke-dynamic=true; a filter of the other kind needs it false. */
NNS_EXPORT int NNS_custom_easy_dynamic_register(const char* name, NNS_custom_invoke_dynamic func,
                                                void* data, const GstTensorsInfo* in_info);
/* Frees the name; elements that have the filter go on with it, so `data` must stay until they have
 * stopped. -EINVAL when there is none of this name. */
NNS_EXPORT int NNS_custom_easy_unregister(const char* name);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_TENSOR_FILTER_CUSTOM_EASY_H */
