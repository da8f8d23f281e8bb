// Decodes a clip in a pipeline.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "floor_clip.hpp"

#include <gst/app/gstappsink.h>
#include <gst/gst.h>

#include <stdexcept>

namespace control {

DecodedClip::DecodedClip(const std::string& file) {
  gst_init(nullptr, nullptr);
  pipeline_ = gst_parse_launch(
      "filesrc name=file ! decodebin ! appsink name=pictures sync=false max-buffers=4", nullptr);
  if (!pipeline_) throw std::runtime_error("GStreamer lacks filesrc, decodebin or appsink");
  GstElement* source = gst_bin_get_by_name(GST_BIN(pipeline_), "file");
  g_object_set(source, "location", file.c_str(), nullptr);
  gst_object_unref(source);
  sink_ = gst_bin_get_by_name(GST_BIN(pipeline_), "pictures");
  gst_element_set_state(pipeline_, GST_STATE_PLAYING);
  // An error does not end the appsink, but the state change reports it.
  if (gst_element_get_state(pipeline_, nullptr, nullptr, GST_CLOCK_TIME_NONE) ==
          GST_STATE_CHANGE_FAILURE ||
      !next()) {
    gst_element_set_state(pipeline_, GST_STATE_NULL);
    gst_object_unref(sink_);
    gst_object_unref(pipeline_);
    throw std::runtime_error(file + " cannot be decoded");
  }
}

DecodedClip::~DecodedClip() {
  gst_element_set_state(pipeline_, GST_STATE_NULL);
  gst_object_unref(sink_);
  gst_object_unref(pipeline_);
}

bool DecodedClip::next() {
  GstSample* sample = gst_app_sink_pull_sample(GST_APP_SINK(sink_));
  if (sample) gst_sample_unref(sample);
  return sample != nullptr;
}

}  // namespace control
