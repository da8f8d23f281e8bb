/* A decoder with a struct laid out by hand from the published interface, without our headers. It
 * links with nothing, so the host must provide the functions. Outputs the sum of each tensor's
 * bytes and the stream's configuration that it received.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <gst/gst.h>
#include <stdio.h>

#include "../by_hand.h"

struct decoder {
  char* modename;
  int (*init)(void**);
  void (*exit)(void**);
  int (*set_option)(void**, int, const char*);
  GstCaps* (*get_out_caps)(void**, const struct config*);
  GstFlowReturn (*decode)(void**, const struct config*, const struct memory*, GstBuffer*);
  size_t (*get_transform_size)(void**, const struct config*, GstCaps*, size_t, GstCaps*,
                               GstPadDirection);
};
int nnstreamer_decoder_probe(struct decoder*);

static int init(void** priv) {
  return priv != NULL;
}

static GstCaps* get_out_caps(void** priv, const struct config* config) {
  (void)priv;
  return gst_caps_new_simple("text/x-raw", "format", G_TYPE_STRING, "utf8", "framerate",
                             GST_TYPE_FRACTION, config->rate_n, config->rate_d, NULL);
}

static GstFlowReturn decode(void** priv, const struct config* config, const struct memory* in,
                            GstBuffer* out) {
  (void)priv;
  GString* text = g_string_new(NULL);
  g_string_append_printf(text, "format %d, %u tensors", config->info.format, config->info.num);
  for (unsigned t = 0; t < config->info.num; ++t) {
    const struct tensor* info = t < 16 ? &config->info.first[t] : &config->info.more[t - 16];
    unsigned sum = 0;
    for (size_t i = 0; i < in[t].size; ++i) sum += ((const uint8_t*)in[t].data)[i];
    g_string_append_printf(text, "; type %d, %u:%u:%u, %zu bytes, sum %u", info->type,
                           info->dimension[0], info->dimension[1], info->dimension[2], in[t].size,
                           sum);
  }
  const gsize size = text->len;
  char* data = g_string_free(text, FALSE);
  gst_buffer_append_memory(out, gst_memory_new_wrapped(0, data, size, 0, size, data, g_free));
  return GST_FLOW_OK;
}

static struct decoder bare = {(char*)"bare", init, NULL, NULL, get_out_caps, decode, NULL};

__attribute__((constructor)) static void load(void) {
  nnstreamer_decoder_probe(&bare);
}
