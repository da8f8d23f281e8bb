// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/pads/timed_tensors.hpp"

#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/error.hpp"
#include "gstcpp/element/result_events.hpp"

namespace weir::gst {

GstClockTime running_time(const GstSegment& segment, GstClockTime time) {
  if (segment.format != GST_FORMAT_TIME) return GST_CLOCK_TIME_NONE;
  return gst_segment_to_running_time(&segment, GST_FORMAT_TIME, time);
}

TimedTensors::TimedTensors() {
  gst_segment_init(&segment_, GST_FORMAT_TIME);
}

Status TimedTensors::handle(GstEvent* event) {
  switch (GST_EVENT_TYPE(event)) {
    case GST_EVENT_CAPS: {
      GstCaps* caps = nullptr;
      gst_event_parse_caps(event, &caps);
      auto spec = spec_from_caps(caps);
      if (!spec) return spec.error();
      spec->roles = roles_from_caps(caps);
      if (auto status = accept(*spec); !status) return status;
      spec_ = *std::move(spec);
      set_labels(labels_);
      break;
    }
    case GST_EVENT_CUSTOM_DOWNSTREAM_STICKY:
      if (auto labels = parse_labels_event(event)) {
        labels_[labels->source] = std::move(labels->labels);
        set_labels(labels_);
      } else if (const auto zones = parse_zones_event(event)) {
        set_zones(*zones);
      }
      break;
    case GST_EVENT_SEGMENT: {
      const GstSegment* segment = nullptr;
      gst_event_parse_segment(event, &segment);
      segment_ = *segment;
      break;
    }
    case GST_EVENT_GAP:
      gap(event);
      break;
    case GST_EVENT_EOS:
      end();
      break;
    case GST_EVENT_FLUSH_START:
      flush(true);
      break;
    case GST_EVENT_FLUSH_STOP:
      gst_segment_init(&segment_, GST_FORMAT_TIME);
      flush(false);
      break;
    default:
      break;
  }
  return ok();
}

void TimedTensors::forget_stream() {
  spec_ = {};
  labels_.clear();
  gst_segment_init(&segment_, GST_FORMAT_TIME);
}

Status TimedTensors::receive(GstBuffer* buffer) {
  if (spec_.format == Format::End)
    return buffer_before_caps("other/tensors,format=static,num_tensors=1,...");
  Status status = reader_.read(buffer, spec_);
  if (status) {
    const GstClockTime time = running_time(segment_, GST_BUFFER_PTS(buffer));
    status = push(buffer, reader_.tensors(),
                  GST_CLOCK_TIME_IS_VALID(time) ? static_cast<int64_t>(time) : INT64_MIN);
  }
  reader_.clear();
  return status;
}

void TimedTensors::gap(GstEvent* event) {
  GstClockTime begin = 0, duration = 0;
  gst_event_parse_gap(event, &begin, &duration);
  const GstClockTime end = begin + (GST_CLOCK_TIME_IS_VALID(duration) ? duration : 0);
  const GstClockTime time = running_time(segment_, end);
  if (GST_CLOCK_TIME_IS_VALID(time)) advance(static_cast<int64_t>(time));
}

}  // namespace weir::gst
