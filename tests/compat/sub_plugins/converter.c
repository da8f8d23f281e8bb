/* An NNStreamer converter as users write them: bytes of x-test/NAME become uint8 tensors. The caps
 * field `what` selects a fault. WEIR_NAME is the name of its file, WEIR_REGISTERS the registered
 * name if it differs; WEIR_FAULT_... omits something.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <nnstreamer_plugin_api_converter.h>
#include <stdlib.h>
#include <string.h>

#ifndef WEIR_REGISTERS
#define WEIR_REGISTERS WEIR_NAME
#endif

static char what[32];
static int opened, closed;

static int asked(const char* word) {
  return strcmp(what, word) == 0;
}

static void one_tensor(GstTensorsConfig* config, gsize bytes) {
  gst_tensors_config_init(config);
  config->info.num_tensors = 1;
  config->info.info[0].type = _NNS_UINT8;
  config->info.info[0].dimension[0] = (uint32_t)bytes;
  config->info.info[0].dimension[1] = 1;
  config->rate_n = asked("rate") ? 7 : 10;
  config->rate_d = 1;
}

static gboolean get_out_config(const GstCaps* in_caps, GstTensorsConfig* config) {
  const GstStructure* structure = gst_caps_get_structure(in_caps, 0);
  const gchar* word = gst_structure_get_string(structure, "what");
  g_strlcpy(what, word ? word : "", sizeof what);
  one_tensor(config, 4);
  if (asked("first-dims")) config->info.info[0].dimension[0] = 0;
  return !asked("refuse");
}

static GstCaps* query_caps(const GstTensorsConfig* config) {
  (void)config;
#ifdef WEIR_FAULT_QUERY
  return NULL;
#else
  return gst_caps_new_empty_simple("x-test/" WEIR_NAME);
#endif
}

static GstBuffer* flexible(GstBuffer* in_buf, GstTensorsConfig* config) {
  GstTensorMetaInfo meta;
  GstMapInfo map;
  gst_buffer_map(in_buf, &map, GST_MAP_READ);
  guint8* bytes = g_malloc(128 + map.size);
  gst_tensor_info_convert_to_meta(&config->info.info[0], &meta);
  gst_tensor_meta_info_update_header(&meta, bytes);
  memcpy(bytes + 128, map.data, map.size);
  gst_buffer_unmap(in_buf, &map);
  config->info.format = _NNS_TENSOR_FORMAT_FLEXIBLE;
  return gst_buffer_new_wrapped(bytes, asked("cut") ? 100 : 128 + gst_buffer_get_size(in_buf));
}

static GstBuffer* two(GstBuffer* in_buf, GstTensorsConfig* config) {
  GstBuffer* out = gst_buffer_copy(in_buf);
  config->info.num_tensors = 2;
  config->info.info[0].dimension[0] = 1;
  config->info.info[1] = config->info.info[0];
  config->info.info[1].dimension[0] = (uint32_t)gst_buffer_get_size(in_buf) - 1;
  return out;
}

static GstBuffer* convert(GstBuffer* in_buf, GstTensorsConfig* config, void* priv) {
  (void)priv;
  if (asked("null")) return NULL;
  if (asked("no-buffer")) return (GstBuffer*)gst_caps_new_any();
  one_tensor(config, gst_buffer_get_size(in_buf));
  if (asked("count")) config->info.num_tensors = 300;
  if (asked("none")) config->info.num_tensors = 0;
  if (asked("extra")) config->info.num_tensors = 20;
  if (asked("type")) config->info.info[0].type = (tensor_type)77;
  if (asked("dims")) config->info.info[0].dimension[0] = 0;
  if (asked("size")) config->info.info[0].dimension[0] += 1;
  if (asked("format")) config->info.format = (tensor_format)9;
  if (asked("flexible") || asked("cut")) return flexible(in_buf, config);
  if (asked("two")) return two(in_buf, config);
  if (asked("same")) return in_buf;
  if (asked("same-referenced")) return gst_buffer_ref(in_buf);
  if (asked("changed")) {
    GstBuffer* out = gst_buffer_make_writable(in_buf);
    gst_buffer_memset(out, 0, 9, 1);
    return out;
  }
  return gst_buffer_copy_deep(in_buf);
}

static int open_script(const char* script_path, void** priv) {
  opened = 1;
  *priv = &opened;
  return strstr(script_path, "missing") ? -2 : 0;
}

static void close_script(void** priv) {
  closed += *priv == &opened;
}

static NNStreamerExternalConverter bytes = {
#ifndef WEIR_FAULT_NAME
    .name = WEIR_REGISTERS,
#endif
#ifndef WEIR_FAULT_FUNCTIONS
    .convert = convert,
    .get_out_config = get_out_config,
    .query_caps = query_caps,
#endif
    .open = open_script,
    .close = close_script,
};

__attribute__((constructor)) static void load(void) {
  registerExternalConverter(&bytes);
}
