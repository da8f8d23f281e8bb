/* Converter sub-plugins for tensor_converter: convert a stream of given caps to tensors.
 *
 * A sub-plugin is a shared object libnnstreamer_converter_NAME.so whose constructor calls
 * registerExternalConverter().
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef NNSTREAMER_PLUGIN_API_CONVERTER_H
#define NNSTREAMER_PLUGIN_API_CONVERTER_H
#include <gst/gst.h>

#include "nnstreamer_plugin_api.h"
#include "nnstreamer_util.h"
#include "tensor_typedef.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A converter. It must stay valid until unregisterExternalConverter(). All members except open and
 * close are required. */
typedef struct _NNStreamerExternalConverter {
  const char* name;
  /* Returns the tensors of one buffer, which the caller keeps; NULL = failed. Fills `config`. */
  GstBuffer* (*convert)(GstBuffer* in_buf, GstTensorsConfig* config, void* priv);
  /* The configuration for these input caps. FALSE rejects them. */
  gboolean (*get_out_config)(const GstCaps* in_caps, GstTensorsConfig* config);
  /* The accepted caps, owned by the caller; `config` may be NULL. */
  GstCaps* (*query_caps)(const GstTensorsConfig* config);
  /* mode=custom-script:PATH only. Returns 0 or more on success and sets `*priv`. */
  int (*open)(const char* script_path, void** priv);
  void (*close)(void** priv);
} NNStreamerExternalConverter;

/* Registers the converter. TRUE, or FALSE with the reason in the log. Thread-safe. */
NNS_EXPORT int registerExternalConverter(NNStreamerExternalConverter* ex);
/* Releases the name. */
NNS_EXPORT void unregisterExternalConverter(const char* name);
/* Finds a descriptor: a registered one, one from a file of that name, or one of Weir's own
 * converters. NULL if there is none. */
NNS_EXPORT const NNStreamerExternalConverter* nnstreamer_converter_find(const char* name);
/* Describes options as pairs of key and text, NULL-terminated. Copied. */
NNS_EXPORT void nnstreamer_converter_set_custom_property_desc(const char* name, const char* key,
                                                              ...) NNS_SENTINEL;

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_PLUGIN_API_CONVERTER_H */
