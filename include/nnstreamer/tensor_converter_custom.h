/* Converters implemented by the application: `tensor_converter mode=custom-code:NAME`. Link with
 * pkg-config nnstreamer.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef NNSTREAMER_TENSOR_CONVERTER_CUSTOM_H
#define NNSTREAMER_TENSOR_CONVERTER_CUSTOM_H
#include <gst/gst.h>

#include "nnstreamer_util.h"
#include "tensor_typedef.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Returns the tensors of one buffer, which the caller keeps; NULL = failed. `config` is empty on
 * entry; fill it with the description of the result. The stream renegotiates when it changes. */
typedef GstBuffer* (*tensor_converter_custom)(GstBuffer* in_buf, void* data,
                                              GstTensorsConfig* config);

/* Returns 0; -EINVAL for an empty, reserved or taken name or a NULL function; -ENOMEM. Return
 * values derived. Thread-safe. */
NNS_EXPORT int nnstreamer_converter_custom_register(const char* name, tensor_converter_custom func,
                                                    void* data);
/* Returns 0, or -EINVAL if the name is not registered. */
NNS_EXPORT int nnstreamer_converter_custom_unregister(const char* name);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_TENSOR_CONVERTER_CUSTOM_H */
