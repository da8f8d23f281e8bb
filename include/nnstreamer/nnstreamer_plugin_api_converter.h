 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* Converter sub-plugins: a stream of some caps to tensors, for tensor_converter.
 *
 * A sub-plugin is a shared object libnnstreamer_converter_NAME.so whose constructor calls
 * registerExternalConverter(). */
#ifndef NNSTREAMER_PLUGIN_API_CONVERTER_H
#define NNSTREAMER_PLUGIN_API_CONVERTER_H
#include <gst/gst.h>

#include "nnstreamer_plugin_api.h"
#include "nnstreamer_util.h"
#include "tensor_typedef.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A converter; it must stay until unregisterExternalConverter(). All but open and close must be
 * there. */
typedef struct _NNStreamerExternalConverter {
  const char* name;
  /* Tensors of one buffer, which stays the caller's; NULL = failed. `config` is filled with what
   * they are. */
  GstBuffer* (*convert)(GstBuffer* in_buf, GstTensorsConfig* config, void* priv);
  /* What comes of a stream of these caps. FALSE refuses them. */
  gboolean (*get_out_config)(const GstCaps* in_caps, GstTensorsConfig* config);
  /* The caps that it takes, the caller's; `config` may be NULL. */
  GstCaps* (*query_caps)(const GstTensorsConfig* config);
  /* mode=custom-script:PATH only: 0 or more, and `*priv`. */
  int (*open)(const char* script_path, void** priv);
  void (*close)(void** priv);
} NNStreamerExternalConverter;

/* Registers it. TRUE, or FALSE with the reason in the log. Thread-safe. */
NNS_EXPORT int registerExternalConverter(NNStreamerExternalConverter* ex);
/* Frees the name. */
NNS_EXPORT void unregisterExternalConverter(const char* name);
/* The descriptor: a registered one, one from a file of that name, or one of Weir's own converters.
 * NULL when there is none of this name. */
NNS_EXPORT const NNStreamerExternalConverter* nnstreamer_converter_find(const char* name);
/* Describes options: pairs of key and text, ended with NULL. Copied. */
NNS_EXPORT void nnstreamer_converter_set_custom_property_desc(const char* name, const char* key,
                                                              ...) NNS_SENTINEL;

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_PLUGIN_API_CONVERTER_H */
