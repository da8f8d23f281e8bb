/* An NNStreamer decoder as users write them. WEIR_NAME is the name of its file, WEIR_REGISTERS the
 * registered name if it differs; WEIR_FAULT_... omits something. option1 selects a fault at run
 * time, option2 is added to each byte, option3 is rejected.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <nnstreamer_plugin_api_decoder.h>
#include <stdlib.h>
#include <string.h>

#ifndef WEIR_REGISTERS
#define WEIR_REGISTERS WEIR_NAME
#endif

typedef struct {
  char what[32];
  int add;
} Adder;

static int adder_init(void** priv) {
#ifdef WEIR_FAULT_INIT
  (void)priv;
  return FALSE;
#else
  *priv = calloc(1, sizeof(Adder));
  return *priv != NULL;
#endif
}

static void adder_exit(void** priv) {
  free(*priv);
  *priv = NULL;
}

static int adder_set_option(void** priv, int op_num, const char* param) {
  Adder* adder = *priv;
  if (op_num == 0) strncpy(adder->what, param, sizeof adder->what - 1);
  if (op_num == 1) adder->add = atoi(param);
  return op_num < 2;
}

static int asked(void** priv, const char* what) {
  const Adder* adder = *priv;
  return strcmp(adder->what, what) == 0;
}

static GstCaps* adder_caps(void** priv, const GstTensorsConfig* config) {
  GstCaps* caps;
  if (asked(priv, "no-caps")) return NULL;
  if (asked(priv, "any-caps")) return gst_caps_new_any();
  if (asked(priv, "empty-caps")) return gst_caps_new_empty();
  if (asked(priv, "no-caps-at-all")) return (GstCaps*)gst_buffer_new();
  if (asked(priv, "picture"))
    caps = gst_caps_from_string("video/x-raw,format=RGBA,width=4,height=2");
  else
    caps = gst_caps_new_simple("application/octet-stream", "tensors", G_TYPE_INT,
                               (int)config->info.num_tensors, NULL);
  if (config->rate_n >= 0 && config->rate_d > 0)
    gst_caps_set_simple(caps, "framerate", GST_TYPE_FRACTION, config->rate_n, config->rate_d, NULL);
  return caps;
}

static GstFlowReturn adder_decode(void** priv, const GstTensorsConfig* config,
                                  const GstTensorMemory* input, GstBuffer* outbuf) {
  const Adder* adder = *priv;
  if (asked(priv, "error")) return GST_FLOW_ERROR;
  if (asked(priv, "not-negotiated")) return GST_FLOW_NOT_NEGOTIATED;
  if (asked(priv, "drop")) return GST_FLOW_CUSTOM_SUCCESS;
  if (asked(priv, "nothing")) return GST_FLOW_OK;
  for (unsigned int t = 0; t < config->info.num_tensors; ++t) {
    guint8* out = g_malloc(input[t].size);
    for (size_t i = 0; i < input[t].size; ++i)
      out[i] = (guint8)(((const guint8*)input[t].data)[i] + adder->add);
    gst_buffer_append_memory(
        outbuf, gst_memory_new_wrapped(0, out, input[t].size, 0, input[t].size, out, g_free));
  }
  return GST_FLOW_OK;
}

static GstTensorDecoderDef adder = {
#ifndef WEIR_FAULT_NAME
    .modename = (char*)WEIR_REGISTERS,
#endif
    .init = adder_init,
    .exit = adder_exit,
    .setOption = adder_set_option,
#ifndef WEIR_FAULT_FUNCTIONS
    .getOutCaps = adder_caps,
    .decode = adder_decode,
#endif
};

__attribute__((constructor)) static void load(void) {
#ifndef WEIR_FAULT_SILENT
  if (nnstreamer_decoder_probe(&adder))
    nnstreamer_decoder_set_custom_property_desc(WEIR_REGISTERS, "option2", "added to each byte",
                                                NULL);
#endif
}

__attribute__((destructor)) static void unload(void) {
  nnstreamer_decoder_exit(WEIR_NAME);
}
