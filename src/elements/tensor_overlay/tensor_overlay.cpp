// tensor_overlay: draws the boxes, key points and labels of one stream on the pictures of another.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>
#include <gst/video/video.h>

#include <atomic>
#include <cmath>
#include <optional>

#include "core/text/text.hpp"
#include "elements/tensor_overlay/overlay_settings.hpp"
#include "elements/tensor_overlay/overlay_video.hpp"
#include "elements/tensor_overlay/results_pad.hpp"
#include "elements/tensor_overlay/text_painter.hpp"
#include "elements/tensor_preprocess/video_negotiation.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/frame_pool.hpp"
#include "gstcpp/buffer/memory_part.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/pads/paired_transform.hpp"
#include "weir/label_file.hpp"
#include "weir/result.hpp"

namespace weir {
namespace {

// Writable copies of shared buffers, in pooled memory.
class BufferCopies {
 public:
  // Copies all bytes into one memory, with times, flags and metas. OUT_OF_MEMORY, MAPPING_FAILED.
  Result<gst::Ref<GstBuffer>> make_copy(GstBuffer* buffer);
  void clear() { pool_ = {}; }

 private:
  Status set_size(size_t bytes);

  gst::FramePool pool_;
  size_t bytes_ = 0;  // size of the pool's buffers
};

// gst_buffer_copy_into() leaves out metas that describe the memory when it does not copy the
// memory, such as where the planes of a padded picture lie.
void copy_layout(GstBuffer* from, GstBuffer* to) {
  GstVideoMeta* layout = gst_buffer_get_video_meta(from);
  if (!layout || gst_buffer_get_video_meta(to)) return;
  GstVideoMeta* copy = gst_buffer_add_video_meta_full(
      to, layout->flags, layout->format, layout->width, layout->height, layout->n_planes,
      layout->offset, layout->stride);
  copy->id = layout->id;
}

Status BufferCopies::set_size(size_t bytes) {
  if (pool_ && bytes_ == bytes) return ok();
  pool_ = {};
  if (bytes > UINT32_MAX) return gst::memory_ran_out(bytes);
  const TensorSpec all{ElementType::UInt8, Shape{static_cast<uint32_t>(bytes)}, ""};
  auto pool = gst::FramePool::make({all}, Format::Static);
  if (!pool) return pool.error();
  pool_ = *std::move(pool);
  bytes_ = bytes;
  return ok();
}

Result<gst::Ref<GstBuffer>> BufferCopies::make_copy(GstBuffer* buffer) {
  const size_t bytes = gst_buffer_get_size(buffer);
  if (auto status = set_size(bytes); !status) return status.error();
  auto out = pool_.acquire();
  if (!out) return out;
  const gst::Mapped map(out->get(), GST_MAP_WRITE);
  if (!map) return gst::memory_ran_out(bytes);
  if (gst_buffer_extract(buffer, 0, map.bytes().data(), bytes) != bytes)
    return gst::memory_not_mapped();
  constexpr int kAllButMemory =
      GST_BUFFER_COPY_FLAGS | GST_BUFFER_COPY_TIMESTAMPS | GST_BUFFER_COPY_META;
  gst_buffer_copy_into(out->get(), buffer, static_cast<GstBufferCopyFlags>(kAllButMemory), 0,
                       static_cast<gsize>(-1));
  copy_layout(buffer, out->get());
  return out;
}

using gst::Ref;

#define WEIR_OVERLAY_VIDEO                                                                        \
  "video/x-raw, format=(string){ RGB, BGR, RGBx, BGRx, xRGB, xBGR, RGBA, BGRA, ARGB, ABGR, "      \
  "GRAY8, NV12, NV21, I420, YV12, YUY2, UYVY }, width=(int)[ 1, 65536 ], height=(int)[ 1, 65536 " \
  "], " WEIR_CAPS_RATE

class TensorOverlay : public gst::PairedTransform<TensorOverlay, ResultsPad> {
  using Paired = gst::PairedTransform<TensorOverlay, ResultsPad>;

 public:
  static constexpr gst::ElementInfo kInfo{
      "WeirTensorOverlay", "tensor_overlay", "TensorOverlay", "Filter/Editor/Video",
      "Draws boxes, key points, labels, trails and zones from a stream of tensors on video"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_OVERLAY_VIDEO)),
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_OVERLAY_VIDEO)),
      GST_STATIC_PAD_TEMPLATE(
          "results", GST_PAD_SINK, GST_PAD_ALWAYS,
          GST_STATIC_CAPS(WEIR_CAPS_TENSOR "; " WEIR_CAPS_TENSORS("{ static, flexible }"))),
  };
  using Settings = OverlaySettings;
  static constexpr auto kProperties = kOverlayProperties;

  Status start() {
    ledger_.reset();
    boxes_ = outside_ = below_score_ = pictures_drawn_ = pictures_copied_ = 0;
    style_changed_ = true;
    const Settings s = settings();
    names_.clear();
    painter_.reset();
    no_text_.reset();
    forget_trails();
    try {
      if (!s.labels.empty())
        for (const auto path : split(s.labels, ";"))
          names_.push_back(path.empty() ? std::vector<std::string>()
                                        : read_label_file("labels", std::string(path)));
    } catch (const Failure& failure) {
      return failure.error();
    }
    if (names_.empty() && !s.show_scores) return ok();
    auto painter = make_text_painter(s.text_size);  // set_caps() makes one of another size
    if (painter)
      painter_ = *std::move(painter);
    else if (!names_.empty())
      return painter.error();
    else
      no_text_ = painter.error();
    return ok();
  }

  bool stop() {
    video_.reset();
    copies_.clear();
    return Paired::stop();
  }

  void property_changed(const char* name) {
    const std::string_view property = name;
    if (property == "text-size") has_text_size_ = true;
    if (property == "line-width") has_line_width_ = true;
    if (property == "point-size") has_point_size_ = true;
    style_changed_ = true;
  }

  Status start_results(const Settings& s) {
    results_.start(s.sync, s.coordinates);
    return ok();
  }

  Status set_caps(GstCaps* in, GstCaps*) {
    GstVideoInfo info;
    picture_height_ = gst_video_info_from_caps(&info, in)
                          ? static_cast<uint32_t>(GST_VIDEO_INFO_HEIGHT(&info))
                          : 0;
    style_changed_ = true;
    if (painter_ && settings().auto_size && !has_text_size_) {
      auto painter = make_text_painter(draw::text_size_for(picture_height_));
      if (!painter) return painter.error();
      painter_ = *std::move(painter);
    }
    names_drawn_.reset();
    auto video = OverlayVideo::make(in, names_, settings().show_scores, painter_);
    if (!video) return video.error();
    video_ = *std::move(video);
    return ok();
  }

  gboolean sink_event(GstEvent* event) {
    if (GST_EVENT_TYPE(event) == GST_EVENT_CAPS) {
      GstCaps* caps = nullptr;
      gst_event_parse_caps(event, &caps);
      if (const Status known = check_drawable(caps); !known) {
        gst_event_unref(event);
        refused_ = true;
        gst::post_error(element(), known.error());
        return FALSE;
      }
      refused_ = !parent_class()->sink_event(self(), event);
      return !refused_;
    }
    if (GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_STOP) forget_trails();
    return Paired::sink_event(event);
  }

  gboolean query(GstPadDirection direction, GstQuery* query) {
    const bool sink_side = direction == GST_PAD_SINK;
    GstCaps* caps = nullptr;
    // A pad rejects caps without an error: accept unsupported formats here, sink_event posts the
    // error.
    if (sink_side && GST_QUERY_TYPE(query) == GST_QUERY_ACCEPT_CAPS) {
      gst_query_parse_accept_caps(query, &caps);
      if (!check_drawable(caps)) return gst_query_set_accept_caps_result(query, TRUE), TRUE;
    }
    if (!Paired::query(direction, query)) return FALSE;
    if (sink_side && GST_QUERY_TYPE(query) == GST_QUERY_CAPS) {
      GstCaps* filter = nullptr;
      gst_query_parse_caps(query, &filter);
      gst_query_parse_caps_result(query, &caps);
      const auto all = with_other_formats(sink(), Ref<GstCaps>::share(caps), filter);
      gst_query_set_caps_result(query, all.get());
    }
    return TRUE;
  }

  // Pictures are drawn in place: no pool is needed.
  gboolean decide_allocation(GstQuery* query) {
    while (gst_query_get_n_allocation_pools(query) > 0)
      gst_query_remove_nth_allocation_pool(query, 0);
    return parent_class()->decide_allocation(self(), query);
  }

  GstFlowReturn prepare_output_buffer(GstBuffer* in, GstBuffer** out) {
    *out = in;
    if (!video_ || refused_) {
      ledger_.dropped(DropReason::Error);
      return GST_FLOW_NOT_NEGOTIATED;
    }
    if (style_changed_.exchange(false)) read_style();
    if (!take_results(in)) {
      ledger_.dropped(DropReason::Flush);
      return GST_FLOW_FLUSHING;
    }
    follow_trails();
    if (!found_ || found_->empty() || gst::can_be_written(in)) return GST_FLOW_OK;
    auto copy = copies_.make_copy(in);
    if (!copy) return failed(copy.error());
    ledger_.copied(gst_buffer_get_size(in));
    ++pictures_copied_;
    *out = copy->release();
    return GST_FLOW_OK;
  }

  GstFlowReturn transform_ip(GstBuffer* buffer) {
    if (const auto found = std::exchange(found_, nullptr); found && !found->empty()) {
      if (no_text_ && found->scored) {
        gst::post_warning(element(), *no_text_);
        no_text_.reset();
      }
      use_names(*found);
      const auto drawn = video_->draw(*found, style_, &trails_, buffer, &ledger_);
      if (!drawn) return failed(drawn.error());
      ++pictures_drawn_;
      boxes_ += drawn->boxes;
      outside_ += drawn->outside;
      below_score_ += drawn->below_score;
    }
    ledger_.consumed_and_pushed();
    return GST_FLOW_OK;
  }

  void add_stats(GstStructure* stats) const {
    gst_structure_set(stats, "pictures-drawn", G_TYPE_UINT64, pictures_drawn_.load(),
                      "pictures-copied", G_TYPE_UINT64, pictures_copied_.load(), "boxes-drawn",
                      G_TYPE_UINT64, boxes_.load(), "boxes-outside", G_TYPE_UINT64, outside_.load(),
                      "boxes-below-score", G_TYPE_UINT64, below_score_.load(), nullptr);
    results_.add_stats(stats);
  }

  Settings settings_;

 private:
  GstPad* sink() const { return GST_BASE_TRANSFORM_SINK_PAD(self()); }

  void read_style() {
    const Settings s = settings();
    style_ = {.line_width = s.line_width, .point_size = s.point_size, .min_score = s.min_score};
    if (s.auto_size && !has_line_width_) style_.line_width = draw::line_width_for(picture_height_);
    if (s.auto_size && !has_point_size_) style_.point_size = draw::point_size_for(picture_height_);
    style_.mask_opacity = static_cast<uint8_t>(std::lround(s.mask_opacity * 255));
    style_.shows_zones = s.show_zones;
    style_.has_track_colors = s.color_by == ColorBy::Track;
    trails_.set_length(s.trail_length);
    limits_.max_age = s.max_age;
  }

  // The same results may be drawn on several pictures: they are one step of a trail.
  void follow_trails() {
    if (!found_ || found_ == in_trails_) return;
    in_trails_ = found_;
    trails_.add(*found_);
  }
  void forget_trails() {
    in_trails_.reset();
    trails_.clear();
  }

  // The names that came with the results count where the user gives none.
  void use_names(const draw::Detections& found) {
    if (!names_.empty() || found.names == names_drawn_) return;
    names_drawn_ = found.names;
    video_->set_names(names_drawn_ ? *names_drawn_ : draw::ClassNames());
  }

  draw::ClassNames names_;                               // of the user
  std::shared_ptr<const draw::ClassNames> names_drawn_;  // of the stream
  std::shared_ptr<draw::TextPainter> painter_;
  std::optional<Error> no_text_;  // why scores are not drawn; posted once
  std::atomic<bool> style_changed_{true};
  // Whether the property was set: then it does not follow the height of the picture.
  std::atomic<bool> has_text_size_{false}, has_line_width_{false}, has_point_size_{false};
  // Used by the streaming thread of the pictures.
  draw::Style style_;
  draw::Trails trails_;
  std::shared_ptr<const draw::Detections> in_trails_;  // the last that were added
  uint32_t picture_height_ = 0;                        // pixels; of the caps
  std::optional<OverlayVideo> video_;
  // Whether the last caps were rejected: later frames do not have the earlier caps, which the base
  // class does not set again when they return.
  bool refused_ = false;
  BufferCopies copies_;
  std::atomic<uint64_t> boxes_{0}, outside_{0}, below_score_{0};
  std::atomic<uint64_t> pictures_drawn_{0}, pictures_copied_{0};
};

}  // namespace

bool register_tensor_overlay(GstPlugin* plugin) {
  return TensorOverlay::register_in(plugin);
}

}  // namespace weir
