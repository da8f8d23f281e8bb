// Boxes in.
#include "elements/tensor_preprocess/regions_pad.hpp"

#include "gstcpp/tensor_caps.hpp"

namespace weir {

using preprocess::Box;

GstClockTime running_time(const GstSegment& segment, GstClockTime time) {
  if (segment.format != GST_FORMAT_TIME) return GST_CLOCK_TIME_NONE;
  return gst_segment_to_running_time(&segment, GST_FORMAT_TIME, time);
}

GstSegment RegionsPad::initial_segment() noexcept {
  GstSegment out;
  gst_segment_init(&out, GST_FORMAT_TIME);
  return out;
}

void RegionsPad::start() {
  queue_.clear();
  queue_.flush(false);
}

Status RegionsPad::handle(GstEvent* event) {
  switch (GST_EVENT_TYPE(event)) {
    case GST_EVENT_CAPS: {
      GstCaps* caps = nullptr;
      gst_event_parse_caps(event, &caps);
      return set_caps(caps);
    }
    case GST_EVENT_SEGMENT: {
      const GstSegment* segment = nullptr;
      gst_event_parse_segment(event, &segment);
      segment_ = *segment;
      break;
    }
    case GST_EVENT_GAP: {
      GstClockTime begin = 0, duration = 0;
      gst_event_parse_gap(event, &begin, &duration);
      gap(begin, duration);
      break;
    }
    case GST_EVENT_EOS:
      queue_.end();
      break;
    case GST_EVENT_FLUSH_START:
      queue_.flush(true);
      break;
    case GST_EVENT_FLUSH_STOP:
      segment_ = initial_segment();
      start();
      break;
    default:
      break;
  }
  return ok();
}

Status RegionsPad::set_caps(const GstCaps* caps) {
  auto spec = gst::spec_from_caps(caps);
  if (!spec) return spec.error();
  if (spec->format == Format::Static) {
    if (spec->tensors.size() != 1)
      return Error{Code::SPEC_MISMATCH,
                   "the stream of regions is not of boxes",
                   spec->to_string(),
                   "one tensor uint32 4:N or float32 4:N: x, y, width and height of each box",
                   "number of tensors",
                   ""};
    if (auto status = preprocess::check_boxes(spec->tensors[0]); !status) return status;
  }
  spec_ = *std::move(spec);
  return ok();
}

// A frame without tensors is one without boxes.
Status RegionsPad::read_boxes(std::vector<Box>* boxes) const {
  const auto& tensors = reader_.tensors();
  if (tensors.empty()) return ok();
  if (tensors.size() > 1) return preprocess::check_boxes(TensorSpec{});
  if (auto status = preprocess::check_boxes(tensors[0].spec); !status) return status;
  preprocess::read_boxes(tensors[0].spec, tensors[0].payload, boxes);
  return ok();
}

Status RegionsPad::receive(GstBuffer* buffer) {
  std::vector<Box> boxes;
  Status status = reader_.read(buffer, spec_);
  if (status) status = read_boxes(&boxes);
  reader_.clear();
  if (!status) return status;
  const GstClockTime time = running_time(segment_, GST_BUFFER_PTS(buffer));
  // Without a time boxes find no picture; before the first one they count as unused.
  queue_.bring(GST_CLOCK_TIME_IS_VALID(time) ? static_cast<int64_t>(time) : INT64_MIN,
               std::move(boxes));
  return ok();
}

void RegionsPad::gap(GstClockTime begin, GstClockTime duration) {
  const GstClockTime end = begin + (GST_CLOCK_TIME_IS_VALID(duration) ? duration : 0);
  const GstClockTime time = running_time(segment_, end);
  if (GST_CLOCK_TIME_IS_VALID(time)) queue_.advance(static_cast<int64_t>(time));
}

preprocess::BoxQueue::Outcome RegionsPad::take(GstClockTime time, GstClockTime most,
                                               std::vector<Box>* out) {
  constexpr GstClockTime kMost = 24 * 3600 * GST_SECOND;
  const std::chrono::nanoseconds wait(std::min(most, kMost));
  return queue_.take(static_cast<int64_t>(time), wait, out);
}

}  // namespace weir
