/* Decoder sub-plugins for `tensor_decoder mode=NAME`: convert tensors to other media.
 *
 * A sub-plugin is a shared object libnnstreamer_decoder_NAME.so whose constructor calls
 * nnstreamer_decoder_probe(). Functions that return int return TRUE on success.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef NNSTREAMER_PLUGIN_API_DECODER_H
#define NNSTREAMER_PLUGIN_API_DECODER_H
#include <gst/gst.h>

#include "nnstreamer_plugin_api.h"
#include "nnstreamer_util.h"
#include "tensor_typedef.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A decoder. It must stay valid until nnstreamer_decoder_exit(). modename, init, getOutCaps and
 * decode are required. */
typedef struct _GstTensorDecoderDef {
  char* modename;           /* mode=; "any" and "auto" are reserved */
  int (*init)(void** priv); /* once per element */
  void (*exit)(void** priv);
  /* optionN of the element: op_num = N - 1. Called in any order, possibly repeatedly. */
  int (*setOption)(void** priv, int op_num, const char* param);
  /* The output caps for a stream, owned by the caller; NULL rejects it. */
  GstCaps* (*getOutCaps)(void** priv, const GstTensorsConfig* config);
  /* Appends the output of one frame to `outbuf`, which is empty. `input` has
   * config->info.num_tensors entries; those of a flexible stream begin with their headers. */
  GstFlowReturn (*decode)(void** priv, const GstTensorsConfig* config, const GstTensorMemory* input,
                          GstBuffer* outbuf);
  /* May be NULL. The output size in bytes for the input caps and size, 0 = not known yet. Signature
   * derived; Weir does not call it. */
  size_t (*getTransformSize)(void** priv, const GstTensorsConfig* config, GstCaps* caps,
                             size_t size, GstCaps* othercaps, GstPadDirection direction);
} GstTensorDecoderDef;

/* Registers the decoder. TRUE, or FALSE with the reason in the log. Thread-safe. */
NNS_EXPORT int nnstreamer_decoder_probe(GstTensorDecoderDef* decoder);
/* Releases the name. */
NNS_EXPORT void nnstreamer_decoder_exit(const char* name);
/* Finds a descriptor: a registered one, one from a file of that name, or one of Weir's own
 * decoders. NULL if there is none. */
NNS_EXPORT const GstTensorDecoderDef* nnstreamer_decoder_find(const char* name);
/* Describes options as pairs of key and text, NULL-terminated. Copied. */
NNS_EXPORT void nnstreamer_decoder_set_custom_property_desc(const char* name, const char* key,
                                                            ...) NNS_SENTINEL;

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_PLUGIN_API_DECODER_H */
