// Decodes a file: filesrc ! decodebin ! videoconvert ! appsink.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pictures.hpp"

namespace control {
namespace {

std::string make_line(const Source& source) {
  std::string line = "filesrc name=file ! decodebin ! videoconvert ! video/x-raw,format=RGB ! ";
  if (source.rate > 0)
    line += "videorate drop-only=true ! capsfilter caps=video/x-raw,framerate=(fraction)" +
            std::to_string(static_cast<int>(source.rate * 1000)) + "/1000 ! ";
  if (source.live) line += "identity sync=true ! ";
  // Like a subscriber with a queue of one: keeps the newest live picture.
  return line +
         "appsink name=pictures sync=false max-buffers=1 drop=" + (source.live ? "true" : "false");
}

void hand_over(GstSample* sample, const std::function<void(const cv::Mat&, int64_t)>& function) {
  GstBuffer* buffer = gst_sample_get_buffer(sample);
  const GstStructure* caps = gst_caps_get_structure(gst_sample_get_caps(sample), 0);
  int width = 0, height = 0;
  gst_structure_get_int(caps, "width", &width);
  gst_structure_get_int(caps, "height", &height);
  GstMapInfo map;
  if (!gst_buffer_map(buffer, &map, GST_MAP_READ)) return;
  const auto stride = static_cast<size_t>((3 * width + 3) / 4 * 4);
  function(cv::Mat(height, width, CV_8UC3, map.data, stride),
           static_cast<int64_t>(GST_BUFFER_PTS(buffer)));
  gst_buffer_unmap(buffer, &map);
}

// Returns the pipeline's error, "" without one.
std::string get_error(GstElement* pipeline) {
  GstBus* bus = gst_element_get_bus(pipeline);
  GstMessage* message = gst_bus_pop_filtered(bus, GST_MESSAGE_ERROR);
  gst_object_unref(bus);
  if (!message) return "";
  GError* error = nullptr;
  gst_message_parse_error(message, &error, nullptr);
  std::string text = error->message;
  g_error_free(error);
  gst_message_unref(message);
  return text;
}

}  // namespace

bool for_each_picture(const Source& source,
                      const std::function<void(const cv::Mat&, int64_t)>& function) {
  GError* error = nullptr;
  GstElement* pipeline = gst_parse_launch(make_line(source).c_str(), &error);
  if (error) return std::fprintf(stderr, "control: %s\n", error->message), false;
  GstElement* file = gst_bin_get_by_name(GST_BIN(pipeline), "file");
  g_object_set(file, "location", source.file.c_str(), nullptr);
  GstAppSink* sink = GST_APP_SINK(gst_bin_get_by_name(GST_BIN(pipeline), "pictures"));
  gst_element_set_state(pipeline, GST_STATE_PLAYING);
  // After an error before the first picture, neither a picture nor EOS arrives.
  std::string fault;
  while (fault.empty()) {
    if (GstSample* sample = gst_app_sink_try_pull_sample(sink, GST_SECOND / 5)) {
      hand_over(sample, function);
      gst_sample_unref(sample);
    } else if (gst_app_sink_is_eos(sink)) {
      break;
    } else {
      fault = get_error(pipeline);
    }
  }
  gst_element_set_state(pipeline, GST_STATE_NULL);
  gst_object_unref(sink);
  gst_object_unref(file);
  gst_object_unref(pipeline);
  if (!fault.empty()) std::fprintf(stderr, "control: %s\n", fault.c_str());
  return fault.empty();
}

}  // namespace control
