/* Plays a pipeline text that begins with a filter `f` and executes commands from stdin: "frame"
 * (pushes two float32 and waits until they are being processed), "flush" or "stop".
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <gst/gst.h>
#include <stdio.h>
#include <string.h>

static guint64 get_stat(GstElement* filter, const char* name) {
  GstStructure* stats = NULL;
  guint64 value = 0;
  g_object_get(filter, "stats", &stats, NULL);
  gst_structure_get_uint64(stats, name, &value);
  gst_structure_free(stats);
  return value;
}

static void say(GstElement* filter, const char* done) {
  printf("%s: held %u, pushed %u\n", done, (unsigned)get_stat(filter, "held"),
         (unsigned)get_stat(filter, "pushed"));
}

static void begin(GstPad* pad) {
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  gst_pad_send_event(pad, gst_event_new_segment(&segment));
}

static void start(GstPad* pad) {
  GstCaps* caps = gst_caps_from_string(
      "other/tensor,dimension=(string)2,type=(string)float32,framerate=(fraction)0/1");
  gst_pad_send_event(pad, gst_event_new_stream_start("frames"));
  gst_pad_send_event(pad, gst_event_new_caps(caps));
  gst_caps_unref(caps);
  begin(pad);
}

static void flush(GstPad* pad) {
  gst_pad_send_event(pad, gst_event_new_flush_start());
  gst_pad_send_event(pad, gst_event_new_flush_stop(TRUE));
  begin(pad);
}

static void add_frame(GstPad* pad) {
  GstBuffer* frame = gst_buffer_new_allocate(NULL, 8, NULL);
  gst_buffer_memset(frame, 0, 0, 8);
  gst_pad_chain(pad, frame);
}

int main(int argc, char** argv) {
  GError* error = NULL;
  char line[16];
  gst_init(NULL, NULL);
  GstElement* pipeline = argc == 2 ? gst_parse_launch(argv[1], &error) : NULL;
  if (!pipeline || error) {
    fprintf(stderr, "%s\n", error ? error->message : "a line of text is needed");
    return 1;
  }
  GstElement* filter = gst_bin_get_by_name(GST_BIN(pipeline), "f");
  GstPad* pad = gst_element_get_static_pad(filter, "sink");
  gst_element_set_state(pipeline, GST_STATE_PLAYING);
  start(pad);
  while (fgets(line, sizeof line, stdin)) {
    if (strcmp(line, "flush\n") == 0) {
      flush(pad);
      say(filter, "flushed");
    } else if (strcmp(line, "frame\n") == 0) {
      add_frame(pad);
    } else {
      gst_element_set_state(pipeline, GST_STATE_NULL);
      say(filter, "stopped");
    }
  }
  gst_object_unref(pad);
  gst_object_unref(filter);
  gst_object_unref(pipeline);
  return 0;
}
