/* A user's program that registers its own filter: outputs the squares of its inputs. */
/* SPDX-License-Identifier: LGPL-2.1-or-later */
#include <gst/gst.h>
#include <nnstreamer_plugin_api.h>
#include <tensor_filter_custom_easy.h>

static int square(void* data, const GstTensorFilterProperties* prop, const GstTensorMemory* input,
                  GstTensorMemory* output) {
  const guint8* x = input[0].data;
  guint32* y = output[0].data;
  gsize i;
  (void)data;
  (void)prop;
  for (i = 0; i < input[0].size; ++i) y[i] = (guint32)x[i] * x[i];
  return 0;
}

static void on_data(GstElement* sink, GstBuffer* buffer, gpointer data) {
  GstMapInfo map;
  (void)sink;
  (void)data;
  gst_buffer_map(buffer, &map, GST_MAP_READ);
  g_print("%u\n", ((const guint32*)map.data)[0]);
  gst_buffer_unmap(buffer, &map);
}

int main(int argc, char** argv) {
  GstTensorsInfo in, out;
  GstElement *pipeline, *sink;
  GstMessage* message;
  gchar* version;
  int failed;
  gst_init(&argc, &argv);
  version = nnstreamer_version_string();
  g_print("%s\n", version);
  g_free(version);
  gst_tensors_info_init(&in);
  gst_tensors_info_init(&out);
  in.num_tensors = gst_tensors_info_parse_dimensions_string(&in, "1:4:4:1");
  gst_tensors_info_parse_types_string(&in, "uint8");
  gst_tensors_info_copy(&out, &in);
  out.info[0].type = _NNS_UINT32;
  if (NNS_custom_easy_register("square", square, NULL, &in, &out) != 0) return 1;
  gst_tensors_info_free(&in);
  gst_tensors_info_free(&out);
  pipeline = gst_parse_launch(
      "videotestsrc pattern=white num-buffers=2 ! "
      "video/x-raw,format=GRAY8,width=4,height=4,framerate=30/1 ! "
      "tensor_converter ! tensor_filter framework=custom-easy model=square ! tensor_sink name=out",
      NULL);
  sink = gst_bin_get_by_name(GST_BIN(pipeline), "out");
  g_signal_connect(sink, "new-data", G_CALLBACK(on_data), NULL);
  gst_object_unref(sink);
  gst_element_set_state(pipeline, GST_STATE_PLAYING);
  message = gst_bus_timed_pop_filtered(GST_ELEMENT_BUS(pipeline), 60 * GST_SECOND,
                                       GST_MESSAGE_EOS | GST_MESSAGE_ERROR);
  failed = !message || GST_MESSAGE_TYPE(message) != GST_MESSAGE_EOS;
  if (message) gst_message_unref(message);
  gst_element_set_state(pipeline, GST_STATE_NULL);
  gst_object_unref(pipeline);
  NNS_custom_easy_unregister("square");
  return failed;
}
