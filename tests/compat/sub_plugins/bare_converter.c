/* A converter with structs laid out by hand from the published interface, without our headers. It
 * links with nothing, so the host must provide the function. Converts each byte of x-test/bare to
 * two int16 values: the byte and its negative.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <gst/gst.h>

#include "../by_hand.h"

struct converter {
  const char* name;
  GstBuffer* (*convert)(GstBuffer*, struct config*, void*);
  gboolean (*get_out_config)(const GstCaps*, struct config*);
  GstCaps* (*query_caps)(const struct config*);
  int (*open)(const char*, void**);
  void (*close)(void**);
};
int registerExternalConverter(struct converter*);

static void say(struct config* config, gsize bytes) {
  config->info.num = 1;
  config->info.first[0].type = 2;
  config->info.first[0].dimension[0] = 2;
  config->info.first[0].dimension[1] = (uint32_t)bytes;
}

static gboolean get_out_config(const GstCaps* caps, struct config* config) {
  say(config, 1);
  config->info.format = 0;
  return gst_structure_get_fraction(gst_caps_get_structure(caps, 0), "framerate", &config->rate_n,
                                    &config->rate_d);
}

static GstCaps* query_caps(const struct config* config) {
  (void)config;
  return gst_caps_from_string("x-test/bare, framerate=(fraction)[ 0/1, 2147483647/1 ]");
}

static GstBuffer* convert(GstBuffer* in, struct config* config, void* priv) {
  GstMapInfo map;
  if (priv || !gst_buffer_map(in, &map, GST_MAP_READ)) return NULL;
  int16_t* out = g_new(int16_t, 2 * map.size);
  for (gsize i = 0; i < map.size; ++i) {
    out[2 * i] = map.data[i];
    out[2 * i + 1] = (int16_t)-map.data[i];
  }
  const gsize bytes = map.size;
  gst_buffer_unmap(in, &map);
  say(config, bytes);
  return gst_buffer_new_wrapped(out, 2 * bytes * sizeof *out);
}

static struct converter bare = {"bare", convert, get_out_config, query_caps, NULL, NULL};

__attribute__((constructor)) static void load(void) {
  registerExternalConverter(&bare);
}
