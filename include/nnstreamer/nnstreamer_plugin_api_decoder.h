 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* Decoder sub-plugins: tensors to something else, for `tensor_decoder mode=NAME`.
 *
 * A sub-plugin is a shared object libnnstreamer_decoder_NAME.so whose constructor calls
 * nnstreamer_decoder_probe(). Functions that return int give TRUE when done. */
#ifndef NNSTREAMER_PLUGIN_API_DECODER_H
#define NNSTREAMER_PLUGIN_API_DECODER_H
#include <gst/gst.h>

#include "nnstreamer_plugin_api.h"
#include "nnstreamer_util.h"
#include "tensor_typedef.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A decoder; it must stay until nnstreamer_decoder_exit(). modename, init, getOutCaps and decode
 * must be there. */
typedef struct _GstTensorDecoderDef {
  char* modename;           /* of mode=; "any" and "auto" are reserved */
  int (*init)(void** priv); /* one for each element */
  void (*exit)(void** priv);
  /* optionN of the element: op_num = N - 1. Called in any order, also again. */
  int (*setOption)(void** priv, int op_num, const char* param);
  /* Caps of what the decoder makes of such a stream, the caller's; NULL refuses it. */
  GstCaps* (*getOutCaps)(void** priv, const GstTensorsConfig* config);
  /* Appends what it makes of one frame to `outbuf`, which comes without memory. `input` has
   * config->info.num_tensors entries; of a flexible stream each begins with its header. */
  GstFlowReturn (*decode)(void** priv, const GstTensorsConfig* config, const GstTensorMemory* input,
                          GstBuffer* outbuf);
  /* Or NULL. Bytes of the output for caps and bytes of the input, 0 = not known before. Signature
   * derived; Weir needs no size before and does not call it. */
  size_t (*getTransformSize)(void** priv, const GstTensorsConfig* config, GstCaps* caps,
                             size_t size, GstCaps* othercaps, GstPadDirection direction);
} GstTensorDecoderDef;

/* Registers it. TRUE, or FALSE with the reason in the log. Thread-safe. */
NNS_EXPORT int nnstreamer_decoder_probe(GstTensorDecoderDef* decoder);
/* Frees the name. */
NNS_EXPORT void nnstreamer_decoder_exit(const char* name);
/* The descriptor: a registered one, one from a file of that name, or one of Weir's own decoders.
 * NULL when there is none of this name. */
NNS_EXPORT const GstTensorDecoderDef* nnstreamer_decoder_find(const char* name);
/* Describes options: pairs of key and text, ended with NULL. Copied. */
NNS_EXPORT void nnstreamer_decoder_set_custom_property_desc(const char* name, const char* key,
                                                            ...) NNS_SENTINEL;

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_PLUGIN_API_DECODER_H */
