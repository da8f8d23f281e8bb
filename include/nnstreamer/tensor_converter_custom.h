 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* Converters of a program: `tensor_converter mode=custom-code:NAME`. Link with pkg-config
 * nnstreamer. */
#ifndef NNSTREAMER_TENSOR_CONVERTER_CUSTOM_H
#define NNSTREAMER_TENSOR_CONVERTER_CUSTOM_H
#include <gst/gst.h>

#include "nnstreamer_util.h"
#include "tensor_typedef.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Tensors of one buffer, which stays the caller's; NULL = failed. `config` comes empty and is
 * filled with what the result is; where it differs from the one before, the stream renegotiates. */
typedef GstBuffer* (*tensor_converter_custom)(GstBuffer* in_buf, void* data,
                                              GstTensorsConfig* config);

/* 0; -EINVAL for a name that is empty, reserved or taken, or no function; -ENOMEM. Return values
 * derived. Thread-safe. */
NNS_EXPORT int nnstreamer_converter_custom_register(const char* name, tensor_converter_custom func,
                                                    void* data);
/* 0, or -EINVAL when there is none of this name. */
NNS_EXPORT int nnstreamer_converter_custom_unregister(const char* name);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_TENSOR_CONVERTER_CUSTOM_H */
