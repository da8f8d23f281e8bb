/* A program that changes properties while its pipelines play: each is written between two frames,
 * the stream continues, and the property reads back the accepted value, or the previous one after a
 * warning.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <gst/gst.h>
#include <nnstreamer_plugin_api_util.h>
#include <stdio.h>
#include <string.h>
#include <tensor_filter_custom_easy.h>

#define SOURCE \
  "videotestsrc pattern=white ! video/x-raw,format=RGB,width=4,height=2,framerate=30/1 ! "
#define TENSORS SOURCE "tensor_converter ! "

typedef struct {
  const char *line, *property, *value;
  int taken; /* 0: rejected with a warning */
} Tuning;

static const Tuning kTunings[] = {
    {TENSORS "tensor_transform name=it mode=arithmetic option=add:1", "option", "add:2", 1},
    {TENSORS "tensor_transform name=it mode=arithmetic option=add:1", "option",
     "typecast:int16,add:1", 1},
    {TENSORS "tensor_transform name=it mode=arithmetic option=add:1", "option", "::", 0},
    {TENSORS "tensor_transform name=it mode=typecast option=int16", "acceleration", "false", 1},
    {TENSORS "tensor_transform name=it mode=typecast option=int16", "apply", "0", 1},
    {TENSORS "tensor_transform name=it mode=typecast option=int16", "apply", "x", 0},
    {TENSORS "tensor_transform name=it mode=typecast option=int16", "silent", "false", 1},
    {TENSORS "tensor_aggregator name=it frames-out=2 frames-dim=3", "frames-out", "3", 1},
    {TENSORS "tensor_aggregator name=it frames-out=2 frames-dim=3", "frames-flush", "1", 1},
    {TENSORS "tensor_aggregator name=it frames-out=2 frames-dim=3", "frames-dim", "1", 1},
    {TENSORS "tensor_aggregator name=it frames-out=2 frames-dim=0", "frames-in", "3", 1},
    {TENSORS "tensor_aggregator name=it frames-out=2 frames-dim=3", "concat", "false", 1},
    {TENSORS "tensor_aggregator name=it frames-out=2 frames-dim=3", "silent", "false", 1},
    {SOURCE "tensor_converter name=it", "frames-per-tensor", "2", 1},
    {SOURCE "tensor_converter name=it", "set-timestamp", "false", 1},
    {SOURCE "tensor_converter name=it", "mode", "custom-code:absent", 0},
    {SOURCE "tensor_converter name=it", "silent", "false", 1},
    {TENSORS "tensor_decoder name=it mode=direct_video", "option1", "BGR", 1},
    {TENSORS "tensor_decoder name=it mode=direct_video", "mode", "octet_stream", 1},
    {TENSORS "tensor_decoder name=it mode=direct_video", "mode", "no_such_decoder", 0},
    {TENSORS "tensor_decoder name=it mode=direct_video", "silent", "false", 1},
    {TENSORS "tensor_demux name=it tensorpick=0 it.src_0", "tensorpick", "0,0", 1},
    {TENSORS "tensor_demux name=it tensorpick=0 it.src_0", "tensorpick", "7", 0},
    {TENSORS "tensor_split name=it tensorseg=3:4:1,3:4:1 it.src_0", "tensorpick", "1", 1},
    {TENSORS "tensor_split name=it tensorseg=3:4:1,3:4:1 it.src_0", "tensorseg", "3:2,3:6", 1},
    {TENSORS "tensor_split name=it tensorseg=3:4:1,3:4:1 it.src_0", "tensorseg", "3:99", 0},
    {TENSORS "tensor_split name=it tensorseg=3:4:2 it.src_0 ! tensor_filter framework=custom-easy "
             "model=same",
     "tensorseg", "3:2:2,3:2:2", 0},
    {TENSORS "tensor_merge name=it", "option", "1", 1},
    {TENSORS "tensor_merge name=it", "option", "17", 0},
    {TENSORS "tensor_merge name=it", "mode", "stacked", 0},
    {TENSORS "tensor_merge name=it", "silent", "false", 1},
    {TENSORS "tensor_filter name=it framework=custom-easy model=same", "inputname", "mine", 1},
    {TENSORS "tensor_filter name=it framework=custom-easy model=same", "input", "3:4:2", 1},
    {TENSORS "tensor_filter name=it framework=custom-easy model=same", "input", "3:4:3", 0},
    {TENSORS "tensor_filter name=it framework=custom-easy model=same", "inputtype", "uint8", 1},
    {TENSORS "tensor_filter name=it framework=custom-easy model=same", "inputlayout", "NHWC", 1},
    {TENSORS "tensor_filter name=it framework=custom-easy model=same", "output", "3:4:2", 1},
    {TENSORS "tensor_filter name=it framework=custom-easy model=same", "outputtype", "float32", 0},
    {TENSORS "tensor_filter name=it framework=custom-easy model=same", "outputname", "mine", 1},
    {TENSORS "tensor_filter name=it framework=custom-easy model=same", "outputlayout", "NCHW", 1},
    {TENSORS "tensor_filter name=it framework=custom-easy model=same", "accelerator", "true:cpu",
     1},
    {TENSORS "tensor_filter name=it framework=custom-easy model=same", "framework", "none-such", 0},
    {TENSORS "tensor_filter name=it framework=custom-easy model=same", "input-combination", "0", 1},
    {TENSORS "tensor_filter name=it framework=custom-easy model=same", "output-combination",
     "i0,o0", 1},
    {TENSORS "tensor_filter name=it framework=custom-easy model=same", "output-combination", "o3",
     0},
    {TENSORS "tensor_filter name=it framework=custom-easy model=same", "suspend", "60000", 1},
    {TENSORS "tensor_filter name=it framework=custom-easy model=same", "invoke-async", "true", 0},
    {TENSORS "tensor_filter name=it framework=custom-easy model=same", "invoke-dynamic", "true", 0},
    {TENSORS "tensor_filter name=it framework=custom-easy model=same", "shared-tensor-filter-key",
     "mine", 1},
    {TENSORS "tensor_filter name=it framework=custom-easy model=same", "workers", "2", 0},
    {TENSORS "tensor_filter name=it framework=custom-easy model=same", "silent", "false", 1},
};

typedef struct {
  GMutex mutex;
  GCond changed;
  int frames;
} Count;

static void count_one(Count* count) {
  g_mutex_lock(&count->mutex);
  ++count->frames;
  g_cond_broadcast(&count->changed);
  g_mutex_unlock(&count->mutex);
}
static void on_data(GstElement* sink, GstBuffer* buffer, gpointer data) {
  (void)sink;
  UNUSED(buffer);
  count_one(data);
}
static void on_handoff(GstElement* sink, GstBuffer* buffer, GstPad* pad, gpointer data) {
  (void)sink;
  (void)buffer;
  (void)pad;
  count_one(data);
}

/* Whether `more` frames arrive within a minute. */
static int wait_for(Count* count, int more) {
  const gint64 end = g_get_monotonic_time() + 60 * G_TIME_SPAN_SECOND;
  int came = 1;
  g_mutex_lock(&count->mutex);
  more += count->frames;
  while (came && count->frames < more)
    came = g_cond_wait_until(&count->changed, &count->mutex, end);
  g_mutex_unlock(&count->mutex);
  return came;
}

static gchar* read_back(GstElement* element, const char* property) {
  GValue value = G_VALUE_INIT;
  gchar* text;
  g_value_init(&value,
               g_object_class_find_property(G_OBJECT_GET_CLASS(element), property)->value_type);
  g_object_get_property(G_OBJECT(element), property, &value);
  text = G_VALUE_HOLDS_STRING(&value) ? g_value_dup_string(&value) : gst_value_serialize(&value);
  g_value_unset(&value);
  return text;
}

/* A decoder's output is not tensors. */
static int decodes(const Tuning* tuning) {
  return strstr(tuning->line, "tensor_decoder") != NULL;
}

static GstElement* make_pipeline(const Tuning* tuning, Count* count) {
  gchar* line = g_strconcat(tuning->line,
                            decodes(tuning) ? " ! fakesink signal-handoffs=true" : " ! tensor_sink",
                            " name=out sync=false", NULL);
  GstElement* pipeline = gst_parse_launch(line, NULL);
  GstElement* sink = gst_bin_get_by_name(GST_BIN(pipeline), "out");
  if (decodes(tuning))
    g_signal_connect(sink, "handoff", G_CALLBACK(on_handoff), count);
  else
    g_signal_connect(sink, "new-data", G_CALLBACK(on_data), count);
  gst_object_unref(sink);
  g_free(line);
  return pipeline;
}

/* The number of messages of this kind; empties the bus. */
static int messages_on(GstElement* pipeline, int* warnings) {
  GstBus* bus = gst_element_get_bus(pipeline);
  GstMessage* message;
  int errors = 0;
  *warnings = 0;
  while ((message = gst_bus_pop_filtered(bus, GST_MESSAGE_ERROR | GST_MESSAGE_WARNING))) {
    ++*(GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR ? &errors : warnings);
    gst_message_unref(message);
  }
  gst_object_unref(bus);
  return errors;
}

/* "" without a fault. */
static const char* find_fault(const Tuning* tuning) {
  Count count = {{0}, {0}, 0};
  GstElement *pipeline, *element;
  gchar *before, *after;
  const char* fault = "";
  int warnings;
  g_mutex_init(&count.mutex);
  g_cond_init(&count.changed);
  pipeline = make_pipeline(tuning, &count);
  element = gst_bin_get_by_name(GST_BIN(pipeline), "it");
  gst_element_set_state(pipeline, GST_STATE_PLAYING);
  if (!wait_for(&count, 2)) fault = "no frame came";
  before = read_back(element, tuning->property);
  messages_on(pipeline, &warnings);
  gst_util_set_object_arg(G_OBJECT(element), tuning->property, tuning->value);
  if (!*fault && !wait_for(&count, 4)) fault = "the stream does not go on";
  after = read_back(element, tuning->property);
  if (messages_on(pipeline, &warnings)) fault = "an error was posted";
  if (!*fault && tuning->taken && g_strcmp0(after, tuning->value) != 0) fault = "it was not taken";
  if (!*fault && !tuning->taken && g_strcmp0(after, before) != 0) fault = "it reads back as taken";
  if (!*fault && !tuning->taken && !warnings) fault = "it was refused without a warning";
  if (*fault)
    fprintf(stderr, "%s=%s (%s): %s; it reads %s\n", tuning->property, tuning->value, tuning->line,
            fault, after ? after : "NULL");
  gst_element_set_state(pipeline, GST_STATE_NULL);
  g_free(before);
  g_free(after);
  gst_object_unref(element);
  gst_object_unref(pipeline);
  g_mutex_clear(&count.mutex);
  g_cond_clear(&count.changed);
  return fault;
}

static int same(void* data, const GstTensorFilterProperties* prop, const GstTensorMemory* input,
                GstTensorMemory* output) {
  (void)data;
  UNUSED(prop);
  memcpy(output[0].data, input[0].data, output[0].size);
  return 0;
}

int main(int argc, char** argv) {
  GstTensorsInfo info;
  size_t i;
  int failed = 0;
  gst_init(&argc, &argv);
  gst_tensors_info_init(&info);
  info.num_tensors = gst_tensors_info_parse_dimensions_string(&info, "3:4:2:1");
  gst_tensors_info_parse_types_string(&info, "uint8");
  if (NNS_custom_easy_register("same", same, NULL, &info, &info) != 0) return 1;
  gst_tensors_info_free(&info);
  for (i = 0; i < G_N_ELEMENTS(kTunings); ++i) failed += *find_fault(&kTunings[i]) != '\0';
  NNS_custom_easy_unregister("same");
  if (!failed) printf("as wanted\n");
  return failed != 0;
}
