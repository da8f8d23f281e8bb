// tensor_zones: finds the zones in which the objects of a stream of results are, and counts them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/records/source_labels.hpp"
#include "core/records/zoned_results.hpp"
#include "core/text/text.hpp"
#include "core/zone/zone_counter.hpp"
#include "core/zone/zone_file.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"
#include "gstcpp/element/counted_transform.hpp"
#include "gstcpp/element/result_events.hpp"
#include "gstcpp/pads/timed_tensors.hpp"
#include "weir/result.hpp"

namespace weir {
namespace {

// The zones of a file that may be replaced while a stream plays.
//
// One thread.
class WatchedZones {
 public:
  // Reads the file. Errors: read_zones(), and OPTION_VALUE without a path.
  Status open(const std::string& path);
  // Call before a frame: reads the file again if `path` is another one or its file has changed.
  // True when the zones were replaced. An error is returned once for each change, and the zones
  // stay.
  Result<bool> follow(const std::string& path);
  const std::shared_ptr<const zone::ZoneSet>& zones() const noexcept { return zones_; }

 private:
  std::string path_;
  zone::FileState state_;
  std::shared_ptr<const zone::ZoneSet> zones_;
};

void add_number(const char* name, float number, GstStructure* out) {
  if (std::isfinite(number)) gst_structure_set(out, name, G_TYPE_DOUBLE, double{number}, nullptr);
}

Status WatchedZones::open(const std::string& path) {
  zones_.reset();
  if (path.empty())
    return Error{.code = Code::OPTION_VALUE,
                 .what = "tensor_zones has no zones",
                 .offered = "zones=\"\"",
                 .needed = "a JSON file as docs/zones.md defines it",
                 .fix = "tensor_zones zones=/path/to/zones.json"};
  const auto read = follow(path);
  return read ? ok() : Status(read.error());
}

Result<bool> WatchedZones::follow(const std::string& path) {
  // The state before reading: what is written meanwhile is read before the next frame.
  const zone::FileState state = zone::state_of_file(path);
  if (zones_ && path == path_ && state == state_) return false;
  path_ = path;
  state_ = state;
  auto read = zone::read_zones(path);
  if (!read) return read.error();
  zones_ = std::make_shared<const zone::ZoneSet>(*std::move(read));
  return true;
}

// Posts the element message "weir-zone-event"; docs/zones.md lists its fields. `labels` names
// classes and may be null.
void post_zone_event(GstElement* element, const zone::Event& event, const zone::Zone& zone,
                     const std::vector<std::string>* labels, GstClockTime running_time) {
  GstStructure* out =
      gst_structure_new("weir-zone-event", "event", G_TYPE_STRING, zone::to_string(event.kind),
                        "zone", G_TYPE_STRING, zone.name.c_str(), "track", G_TYPE_UINT, event.track,
                        "running-time", G_TYPE_UINT64, running_time, nullptr);
  if (event.class_index != zone::kNoClass) {
    const auto index = static_cast<size_t>(event.class_index);
    const std::string label =
        labels && index < labels->size() ? (*labels)[index] : std::to_string(index);
    gst_structure_set(out, "class", G_TYPE_INT, event.class_index, "label", G_TYPE_STRING,
                      label.c_str(), nullptr);
  }
  add_number("dwell", event.dwell, out);
  add_number("speed", event.speed.pixels, out);
  add_number("ground-speed", event.speed.metres, out);
  gst_element_post_message(element, gst_message_new_element(GST_OBJECT_CAST(element), out));
}

Error objects_without_track() {
  return Error{.code = Code::SPEC_MISMATCH,
               .what =
                   "no object has a track number: zones count the objects inside, but none that "
                   "enter, leave or cross",
               .offered = "30 frames with objects of track 0",
               .needed = "objects that are tracked from frame to frame",
               .fix = "tensor_tracker ! tensor_zones"};
}

Error frame_without_time() {
  return Error{.code = Code::TIME_INVALID,
               .what = "a frame has no timestamp: dwell times and speeds are not updated",
               .offered = "a buffer without a PTS",
               .needed = "a PTS in a segment of format time",
               .fix = "set do-timestamp=true at the source"};
}

Error time_goes_back(GstClockTime running_time) {
  return Error{.code = Code::TIME_INVALID,
               .what =
                   "the time of a frame is before that of the last frame: all tracks end and "
                   "start again",
               .offered = "running time " + time_text(running_time),
               .needed = "times that increase",
               .fix = "put a queue or a parser that orders the frames upstream"};
}

using gst::Ref;

class TensorZones : public gst::CountedTransform<TensorZones> {
 public:
  static constexpr gst::ElementInfo kInfo{
      "WeirTensorZones", "tensor_zones", "TensorZones", "Filter/Tensor",
      "Counts tracked objects in areas and across lines, with dwell times and speeds"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE(
          "sink", GST_PAD_SINK, GST_PAD_ALWAYS,
          GST_STATIC_CAPS(WEIR_CAPS_TENSOR "; " WEIR_CAPS_TENSORS("{ static, flexible }"))),
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_CAPS_TENSORS("flexible"))),
  };
  struct Settings {
    std::string zones;
    uint64_t max_gap = 1000000000;
    uint32_t zones_per_object = 4;
    std::string source = "zones";
    bool post_messages = true;
  };
  static constexpr uint64_t kMaxGap = uint64_t{24} * 3600 * 1000000000;
  static constexpr std::tuple kProperties{
      gst::Property{"zones", &Settings::zones,
                    "Path of a JSON file with areas and lines; it is read again when it changes",
                    gst::Changeable::WhilePlaying},
      gst::Property{"max-gap", &Settings::max_gap,
                    "Nanoseconds that a track may be missing before it counts as gone",
                    gst::Changeable::InReady, uint64_t{0}, kMaxGap},
      gst::Property{"zones-per-object", &Settings::zones_per_object,
                    "Maximum number of zones that the row of an object names",
                    gst::Changeable::InReady, 1u, uint32_t{zone::kStayLimit}},
      gst::Property{"source", &Settings::source,
                    "Name of the source of the counts and events in the results"},
      gst::Property{"post-messages", &Settings::post_messages,
                    "Post an element message for each event", gst::Changeable::WhilePlaying},
  };

  Status check_change(const char* name, const Settings& wanted) const {
    if (std::strcmp(name, "zones") != 0) return ok();
    const auto zones = zone::read_zones(wanted.zones);
    return zones ? ok() : Status(zones.error());
  }

  Status start() {
    ledger_.reset();
    for (auto* count : {&events_, &files_read_, &files_refused_, &zones_left_out_}) *count = 0;
    now_ = settings();
    labels_.clear();
    zoned_.reset();
    frames_without_tracks_ = 0;
    has_warned_of_time_ = false;
    counter_ = zone::ZoneCounter({.max_gap = static_cast<int64_t>(now_.max_gap)});
    if (Status status = zones_.open(now_.zones); !status) return status;
    use_zones();
    publish();
    return ok();
  }

  GstCaps* transform_caps(GstPadDirection direction, GstCaps* caps, GstCaps* filter) {
    return caps_of_other_pad(direction, filter, [&] { return output_caps(caps); });
  }

  Status set_caps(GstCaps* in, GstCaps*) {
    auto spec = gst::fixed_spec_from_caps(in);
    if (!spec) return spec.error();
    input_ = *std::move(spec);
    auto zoned = zoned_results(in);
    if (!zoned) return zoned.error();
    zoned_ = *std::move(zoned);
    is_announced_ = false;
    return ok();
  }

  gboolean sink_event(GstEvent* event) {
    if (auto labels = gst::parse_labels_event(event))
      labels_[labels->source] = std::move(labels->labels);
    if (GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_STOP) counter_.forget_tracks();
    return parent_class()->sink_event(self(), event);
  }

  GstFlowReturn prepare_output_buffer(GstBuffer* in, GstBuffer** out) {
    *out = gst_buffer_new();
    gst_buffer_copy_into(*out, in, GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
    return GST_FLOW_OK;
  }

  GstFlowReturn transform(GstBuffer* in, GstBuffer* out) {
    if (!zoned_) return failed(gst::buffer_before_caps());
    follow_zones();
    announce();
    const Status status = convert(in, out);
    reader_.clear();
    if (!status) return failed(status.error());
    publish();
    ledger_.consumed_and_pushed();
    return GST_FLOW_OK;
  }

  void add_stats(GstStructure* stats) const {
    const auto add = [stats](const char* name, uint64_t value) {
      gst_structure_set(stats, name, G_TYPE_UINT64, value, nullptr);
    };
    add("zones", n_zones_);
    add("tracks", tracks_);
    add("events", events_);
    add("zones-files-read", files_read_);
    add("zones-files-refused", files_refused_);
    add("zones-not-named", zones_left_out_);
    add("beyond-limit", beyond_limit_);
    add("times-backward", times_backward_);
  }

  Settings settings_;

 private:
  Result<records::ZonedResults> zoned_results(const GstCaps* caps) const {
    const Settings s = settings();
    return records::ZonedResults::make(
        gst::roles_from_caps(caps), {.zones_per_object = s.zones_per_object, .source = s.source});
  }

  // For queries too: caps that cannot be used have the caps of the template; set_caps() reports the
  // reason.
  Ref<GstCaps> output_caps(const GstCaps* in) const {
    auto out =
        Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(GST_BASE_TRANSFORM_SRC_PAD(self())));
    if (!gst_caps_is_fixed(in)) return out;
    out = Ref<GstCaps>::adopt(gst_caps_make_writable(out.release()));
    const GValue* rate = gst_structure_get_value(gst_caps_get_structure(in, 0), "framerate");
    if (rate) gst_caps_set_value(out.get(), "framerate", rate);
    const auto zoned = zoned_results(in);
    return zoned ? gst::with_roles(std::move(out), zoned->roles()) : out;
  }

  void use_zones() {
    counter_.set_zones(zones_.zones());
    ++files_read_;
    is_announced_ = false;
    GST_CAT_INFO_OBJECT(category(), self(), "%zu zones from %s", zones_.zones()->zones.size(),
                        now_.zones.c_str());
  }
  // Between two frames: a file that has changed, or another one.
  void follow_zones() {
    now_ = settings();
    const auto changed = zones_.follow(now_.zones);
    if (!changed) {
      ++files_refused_;
      Error error = changed.error();
      error.what += "; the zones stay as they were";
      return gst::post_warning(element(), error);
    }
    if (*changed) use_zones();
  }

  // Sends the names of the zones and the zones after caps, and after each change.
  void announce() {
    if (std::exchange(is_announced_, true)) return;
    gst::LabelsOfSource names{now_.source, {}};
    for (const zone::Zone& zone : zones_.zones()->zones) names.labels.push_back(zone.name);
    GstPad* const pad = GST_BASE_TRANSFORM_SRC_PAD(self());
    gst_pad_push_event(pad, gst::make_labels_event(names).release());
    gst_pad_push_event(pad, gst::make_zones_event({now_.source, zones_.zones()->text}).release());
  }

  Status convert(GstBuffer* in, GstBuffer* out) {
    std::vector<gst::TensorPiece> pieces;
    if (auto status = reader_.read(in, input_); !status) return status;
    ledger_.copied(reader_.bytes_copied());
    if (auto status = gst::append_pieces(in, reader_, &ledger_, &pieces); !status) return status;
    std::vector<records::ResultTensor> tensors;
    for (const auto& view : reader_.tensors()) tensors.push_back({view.spec, view.payload});
    if (auto status = zoned_->read(tensors, &sightings_); !status) return status;
    const GstClockTime time = gst::running_time(self()->segment, GST_BUFFER_PTS(in));
    warn_once(time);
    const auto maps = gst::source_maps(in);
    if (!maps.empty()) counter_.set_picture({maps[0].source_width, maps[0].source_height});
    counter_.update(GST_CLOCK_TIME_IS_VALID(time) ? static_cast<int64_t>(time) : zone::kNoTime,
                    sightings_);
    post_events(time);
    if (tensors.empty()) return ok();
    uint64_t unnamed = 0;
    const auto outputs = zoned_->write(tensors, counter_, &unnamed);
    zones_left_out_ += unnamed;
    if (outputs.size() > kTensorLimit) return too_many_tensors(tensors.size());
    insert_maps(in, outputs, out);
    return append(outputs, &pieces, out);
  }

  static Error too_many_tensors(size_t count) {
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "a frame has too many tensors to append the counts and events of zones",
                 .offered = std::to_string(count) + " tensors",
                 .needed = "at most 254 tensors",
                 .fix = "tensor_demux tensorpick=... upstream of tensor_zones"};
  }

  void warn_once(GstClockTime time) {
    const auto has_track = [](const zone::Sighting& one) { return one.track > 0; };
    constexpr uint32_t kFrames = 30;
    if (std::any_of(sightings_.begin(), sightings_.end(), has_track))
      frames_without_tracks_ = kFrames + 1;
    else if (!sightings_.empty() && frames_without_tracks_ <= kFrames &&
             ++frames_without_tracks_ == kFrames)
      gst::post_warning(element(), objects_without_track());
    const bool is_backward = counter_.is_backward(
        GST_CLOCK_TIME_IS_VALID(time) ? static_cast<int64_t>(time) : zone::kNoTime);
    if (has_warned_of_time_ || (GST_CLOCK_TIME_IS_VALID(time) && !is_backward)) return;
    has_warned_of_time_ = true;
    gst::post_warning(element(), is_backward ? time_goes_back(time) : frame_without_time());
  }

  void post_events(GstClockTime time) {
    events_ += counter_.events().size();
    if (!now_.post_messages) return;
    for (const zone::Event& event : counter_.events()) {
      const auto labels = labels_.find(zoned_->get_source(event.group));
      post_zone_event(element(), event, counter_.zones()->zones[event.zone],
                      labels == labels_.end() ? nullptr : &labels->second, time);
    }
  }

  // Maps of single tensors move with their tensors.
  static void insert_maps(GstBuffer* in, const std::vector<records::OutputTensor>& outputs,
                          GstBuffer* out) {
    const auto maps = gst::source_maps(in);
    if (maps.size() < 2 || gst::maps_of(in) != gst::MapsOf::Tensors) return;
    std::vector<SourceMap> moved;
    moved.reserve(outputs.size());
    size_t next = 0;
    for (const auto& output : outputs)
      moved.push_back(output.is_table || next == maps.size() ? maps[0] : maps[next++]);
    gst::set_source_maps(out, std::move(moved));
  }

  Status append(const std::vector<records::OutputTensor>& outputs,
                std::vector<gst::TensorPiece>* pieces, GstBuffer* out) {
    std::vector<gst::TensorPiece> all;
    for (const auto& output : outputs) {
      if (output.input < 0) {
        auto piece = gst::make_piece({.spec = output.spec, .format = Format::Flexible},
                                     std::as_bytes(std::span(output.numbers)));
        if (!piece) return piece.error();
        all.push_back(*std::move(piece));
        continue;
      }
      auto& piece = (*pieces)[static_cast<size_t>(output.input)];
      if (input_.format == Format::Flexible) {
        all.push_back(std::move(piece));
        continue;
      }
      auto with = gst::with_header(piece, &ledger_);
      if (!with) return with.error();
      all.push_back(*std::move(with));
    }
    return gst::append_tensors(all, out, &ledger_);
  }

  // For `stats`, which any thread reads.
  void publish() {
    n_zones_ = counter_.zones()->zones.size();
    tracks_ = counter_.tracks();
    beyond_limit_ = counter_.left_out();
    times_backward_ = counter_.times_backward();
  }

  // Streaming thread.
  Settings now_;
  FrameSpec input_;
  std::optional<records::ZonedResults> zoned_;
  WatchedZones zones_;
  zone::ZoneCounter counter_;
  records::LabelsBySource labels_;
  bool is_announced_ = false;
  uint32_t frames_without_tracks_ = 0;  // in a row, with objects
  bool has_warned_of_time_ = false;
  gst::FrameLayout reader_;
  std::vector<zone::Sighting> sightings_;

  std::atomic<uint64_t> n_zones_{0}, tracks_{0}, events_{0}, files_read_{0}, files_refused_{0};
  std::atomic<uint64_t> zones_left_out_{0}, beyond_limit_{0}, times_backward_{0};
};

}  // namespace

bool register_tensor_zones(GstPlugin* plugin) {
  return TensorZones::register_in(plugin);
}

}  // namespace weir
