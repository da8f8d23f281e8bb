/* Decoders implemented by the application: `tensor_decoder mode=custom-code option1=NAME`. Link
 * with pkg-config nnstreamer.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef NNSTREAMER_TENSOR_DECODER_CUSTOM_H
#define NNSTREAMER_TENSOR_DECODER_CUSTOM_H
#include <gst/gst.h>

#include "nnstreamer_util.h"
#include "tensor_typedef.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Appends the output of one frame to `out_buf`; the stream is application/octet-stream. Returns
 * GST_FLOW_OK (0), or below 0 on failure. */
typedef int (*tensor_decoder_custom)(const GstTensorMemory* input, const GstTensorsConfig* config,
                                     void* data, GstBuffer* out_buf);

/* Returns 0; -EINVAL for an empty, reserved or taken name or a NULL function; -ENOMEM. Return
 * values derived. Thread-safe. */
NNS_EXPORT int nnstreamer_decoder_custom_register(const char* name, tensor_decoder_custom func,
                                                  void* data);
/* Returns 0, or -EINVAL if the name is not registered. */
NNS_EXPORT int nnstreamer_decoder_custom_unregister(const char* name);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_TENSOR_DECODER_CUSTOM_H */
