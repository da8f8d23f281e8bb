// tensor_converter: video frames and bytes become tensors.
#include <gst/video/video.h>

#include <cstring>
#include <memory>

#include "core/convert/video_tensor.hpp"
#include "core/infer/module_library.hpp"
#include "elements/tensor_converter/chunker.hpp"
#include "elements/tensor_converter/dense_video.hpp"
#include "elements/tensor_converter/tensor_memories.hpp"
#include "gstcpp/base_classes.hpp"
#include "gstcpp/tensor_caps.hpp"

namespace weir {
namespace {

using gst::Ref;

class TensorConverter : public gst::Element<TensorConverter, gst::PlainElement> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirTensorConverter", "tensor_converter",
                                          "TensorConverter", "Converter/Tensor",
                                          "Turns video frames and bytes into tensors"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE(
          "sink", GST_PAD_SINK, GST_PAD_ALWAYS,
          GST_STATIC_CAPS(
              "video/x-raw, format=(string){ RGB, BGR, RGBx, BGRx, xRGB, xBGR, RGBA, BGRA, ARGB, "
              "ABGR, GRAY8, GRAY16_BE, GRAY16_LE, RGBP, BGRP }, width=(int)[ 1, 2147483647 ], "
              "height=(int)[ 1, 2147483647 ], " WEIR_CAPS_RATE
              ", interlace-mode=(string)progressive; application/octet-stream")),
      GST_STATIC_PAD_TEMPLATE(
          "src", GST_PAD_SRC, GST_PAD_ALWAYS,
          GST_STATIC_CAPS(WEIR_CAPS_TENSOR "; " WEIR_CAPS_TENSORS("{ static, flexible }"))),
  };

  struct Settings {
    std::string input_dim, input_type;
    uint32_t frames_per_tensor = 1;
    bool set_timestamp = true;
    bool silent = true;
  };
  std::string sub_plugins() const {
    std::string out;
    for (const auto& name : infer::ModuleLibrary::instance().converter_names())
      out += (out.empty() ? "" : ",") + name;
    return out;
  }
  static constexpr std::tuple kProperties{
      gst::Property{"input-dim", &Settings::input_dim,
                    "Dimensions of the tensors in a byte stream"},
      gst::Property{"input-type", &Settings::input_type,
                    "Element types of the tensors in a byte stream"},
      gst::Property{"frames-per-tensor", &Settings::frames_per_tensor, "Frames in each output",
                    gst::Changeable::InReady, 1u, G_MAXUINT},
      gst::Property{"set-timestamp", &Settings::set_timestamp,
                    "Fill in missing time-stamps and durations"},
      gst::Property{"silent", &Settings::silent, "Accepted for compatibility; has no effect"},
      gst::ReadOnly{"sub-plugins", &TensorConverter::sub_plugins,
                    "External converters that are installed"},
  };

  void constructed() {
    for (const char* name : {"sink", "src"}) {
      GstPad* pad = gst_pad_new_from_template(
          gst_element_class_get_pad_template(GST_ELEMENT_GET_CLASS(element()), name), name);
      gst_element_add_pad(element(), pad);
      (std::strcmp(name, "sink") == 0 ? sink_ : source_) = pad;
    }
    gst_pad_set_chain_function(sink_, (chain<&TensorConverter::on_buffer>));
    gst_pad_set_event_function(sink_, (pad_event<&TensorConverter::on_event>));
    gst_pad_set_query_function(sink_, (pad_query<&TensorConverter::on_query>));
  }

  GstStateChangeReturn change_state(GstStateChange change) {
    if (change == GST_STATE_CHANGE_READY_TO_PAUSED) {
      ledger_.reset();
      reset();
    }
    const auto result = parent_class()->change_state(element(), change);
    if (change == GST_STATE_CHANGE_PAUSED_TO_READY) reset();
    return result;
  }

  GstFlowReturn on_buffer(GstBuffer* raw) {
    auto buffer = Ref<GstBuffer>::adopt(raw);
    ledger_.received();
    auto dense = densify(std::move(buffer));
    if (!dense) {
      gst::post_error(element(), dense.error());
      ledger_.dropped(DropReason::Error);
      return dense.error().code == Code::NOT_NEGOTIATED ? GST_FLOW_NOT_NEGOTIATED : GST_FLOW_ERROR;
    }
    auto writable = Ref<GstBuffer>::adopt(gst_buffer_make_writable(dense->release()));
    const uint64_t frames = gst_buffer_get_size(writable.get()) / frame_bytes_;
    if (settings().set_timestamp) chunker_.stamp(writable.get(), frames, fallback_time());
    chunker_.push(std::move(writable));
    ledger_.consumed();
    GstFlowReturn flow = GST_FLOW_OK;
    while (flow == GST_FLOW_OK) {
      auto out = chunker_.next();
      if (!out) break;
      flow = push(std::move(out));
    }
    return flow;
  }

  gboolean on_event(GstPad* pad, GstEvent* event) {
    switch (GST_EVENT_TYPE(event)) {
      case GST_EVENT_CAPS: {
        const auto owned = Ref<GstEvent>::adopt(event);
        GstCaps* caps = nullptr;
        gst_event_parse_caps(event, &caps);
        const Status status = negotiate(caps);
        if (!status) gst::post_error(element(), status.error());
        return status.has_value();
      }
      case GST_EVENT_SEGMENT:
        return on_segment(event);
      case GST_EVENT_FLUSH_STOP:
        chunker_.clear();
        gst_segment_init(&segment_, GST_FORMAT_TIME);
        break;
      default:
        break;
    }
    return gst_pad_event_default(pad, GST_OBJECT_CAST(self()), event);
  }

  gboolean on_query(GstPad* pad, GstQuery* query) {
    if (GST_QUERY_TYPE(query) != GST_QUERY_CAPS)
      return gst_pad_query_default(pad, GST_OBJECT_CAST(self()), query);
    GstCaps* filter = nullptr;
    gst_query_parse_caps(query, &filter);
    auto caps = narrowed(Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(pad)));
    if (filter)
      caps = Ref<GstCaps>::adopt(
          gst_caps_intersect_full(filter, caps.get(), GST_CAPS_INTERSECT_FIRST));
    gst_query_set_caps_result(query, caps.get());
    return TRUE;
  }

  Settings settings_;
  Ledger ledger_;

 private:
  void reset() {
    chunker_.clear();
    is_video_ = negotiated_ = false;
    gst_segment_init(&segment_, GST_FORMAT_TIME);
  }

  GstClockTime fallback_time() const {
    const bool rate_known = spec_.rate.valid() && spec_.rate.numerator > 0;
    if (!rate_known) {
      const auto now = gst_element_get_current_running_time(element());
      if (GST_CLOCK_TIME_IS_VALID(now)) return now;
    }
    return segment_.start;
  }

  gboolean on_segment(GstEvent* event) {
    const GstSegment* segment = nullptr;
    gst_event_parse_segment(event, &segment);
    if (segment->format == GST_FORMAT_TIME) {
      gst_segment_copy_into(segment, &segment_);
      return gst_pad_event_default(sink_, GST_OBJECT_CAST(self()), event);
    }
    const bool bytes = segment->format == GST_FORMAT_BYTES;
    gst_event_unref(event);
    if (!bytes) {
      gst::post_error(element(), {Code::FORMAT_UNSUPPORTED, "the segment has no known unit", "",
                                  "time or bytes", "", ""});
      return FALSE;
    }
    gst_segment_init(&segment_, GST_FORMAT_TIME);
    segment_.start = 0;
    return gst_pad_push_event(source_, gst_event_new_segment(&segment_));
  }

  // The user's tensors, when both properties give a valid list.
  Result<std::vector<TensorSpec>> user_tensors() const {
    const Settings s = settings();
    auto shapes = parse_shape_list(s.input_dim);
    if (!shapes) return shapes.error();
    auto types = parse_type_list(s.input_type);
    if (!types) return types.error();
    if (shapes->empty() || types->empty()) return std::vector<TensorSpec>{};
    if (shapes->size() != types->size())
      return Error{Code::OPTION_VALUE,
                   "input-dim and input-type differ in number",
                   s.input_dim + " and " + s.input_type,
                   "as many types as dimensions",
                   "",
                   ""};
    std::vector<TensorSpec> out;
    for (size_t i = 0; i < shapes->size(); ++i) out.push_back({(*types)[i], (*shapes)[i], ""});
    return out;
  }

  Status negotiate(GstCaps* caps) {
    const GstStructure* s = gst_caps_get_structure(caps, 0);
    spec_ = {};
    spec_.format = Format::Static;
    if (!gst_structure_get_fraction(s, "framerate", &spec_.rate.numerator, &spec_.rate.denominator))
      spec_.rate = {0, 1};
    flexible_bytes_ = false;
    is_video_ = gst_structure_has_name(s, "video/x-raw");
    const Status status = is_video_ ? negotiate_video(caps) : negotiate_bytes();
    if (!status) return status;
    auto out = gst::choose_caps(source_, spec_);
    if (!out)
      return Error{Code::SPEC_MISMATCH,
                   "the element behind tensor_converter takes no such tensors",
                   spec_.to_string(),
                   "",
                   "",
                   ""};
    const auto chosen = gst::spec_from_caps(out.get());
    if (!chosen) return chosen.error();
    output_format_ = chosen->format;
    chunker_.configure(frame_bytes_, frames_out_, spec_.rate);
    negotiated_ = true;
    if (gst_pad_push_event(source_, gst_event_new_caps(out.get()))) return ok();
    return Error{Code::SPEC_MISMATCH,
                 "the element behind tensor_converter refuses the tensors",
                 spec_.to_string(),
                 "",
                 "",
                 ""};
  }

  Status negotiate_video(GstCaps* caps) {
    GstVideoInfo video;
    if (!gst_video_info_from_caps(&video, caps))
      return Error{Code::FORMAT_UNSUPPORTED, "the video caps cannot be read", "", "", "", ""};
    frames_out_ = settings().frames_per_tensor;
    auto tensor = video_tensor(
        GST_VIDEO_INFO_NAME(&video), static_cast<uint32_t>(GST_VIDEO_INFO_WIDTH(&video)),
        static_cast<uint32_t>(GST_VIDEO_INFO_HEIGHT(&video)), static_cast<uint32_t>(frames_out_));
    if (!tensor) return tensor.error();
    spec_.tensors = {tensor->spec};
    video_ = DenseVideo(video, *tensor);
    frame_bytes_ = video_.frame_bytes();
    auto user = user_tensors();
    if (!user) return user.error();
    if (user->empty()) return ok();
    const std::string difference = first_difference(spec_.tensors, *user);
    if (difference.empty()) return ok();
    FrameSpec needed = spec_;
    needed.tensors = *user;
    return Error{Code::SPEC_MISMATCH, "the video is not what input-dim and input-type say",
                 spec_.to_string(),   needed.to_string(),
                 difference,          "leave input-dim and input-type away: the caps say it"};
  }

  Status negotiate_bytes() {
    frames_out_ = settings().frames_per_tensor;
    auto tensors = user_tensors();
    if (!tensors) return tensors.error();
    if (tensors->empty()) *tensors = tensors_of_peer();
    if (tensors->empty()) {
      if (!gst::peer_wants_flexible(source_))
        return Error{Code::OPTION_VALUE,
                     "the tensors in the byte stream are not known",
                     "",
                     "input-dim and input-type",
                     "",
                     "tensor_converter input-dim=3:224:224:1 input-type=uint8"};
      flexible_bytes_ = true;
      spec_.format = Format::Flexible;
      frame_bytes_ = 1;
      return ok();
    }
    if (tensors->size() > 1 && frames_out_ > 1)
      return Error{Code::OPTION_VALUE,
                   "several tensors cannot be gathered",
                   "frames-per-tensor=" + std::to_string(frames_out_),
                   "1",
                   "",
                   ""};
    spec_.tensors = *std::move(tensors);
    const auto bytes = spec_.bytes();
    if (!bytes)
      return Error{Code::LIMIT_EXCEEDED, "the tensors are too big", spec_.to_string(), "", "", ""};
    frame_bytes_ = *bytes;
    return ok();
  }

  std::vector<TensorSpec> tensors_of_peer() const {
    const auto peer = Ref<GstCaps>::adopt(gst_pad_peer_query_caps(source_, nullptr));
    if (gst_caps_is_any(peer.get()) || gst_caps_is_empty(peer.get())) return {};
    const auto spec = gst::spec_from_caps(peer.get());
    return spec && spec->format == Format::Static && spec->info_valid() ? spec->tensors
                                                                        : std::vector<TensorSpec>{};
  }

  // A video format list that fits what the peer wants (specification 2, "Caps query").
  Ref<GstCaps> narrowed(Ref<GstCaps> caps) const {
    const auto wanted = tensors_of_peer();
    if (wanted.size() != 1) return caps;
    const Shape& d = wanted[0].shape;
    const char* formats = d[0] == 1   ? "{ GRAY8, GRAY16_BE, GRAY16_LE }"
                          : d[0] == 3 ? "{ RGB, BGR }"
                          : d[0] == 4 ? "{ RGBx, BGRx, xRGB, xBGR, RGBA, BGRA, ARGB, ABGR }"
                                      : nullptr;
    std::string text;
    const auto add = [&](const char* list, uint32_t width, uint32_t height) {
      if (width == 0 || height == 0) return;
      text += std::string("video/x-raw, format=(string)") + list + ", width=(int)" +
              std::to_string(width) + ", height=(int)" + std::to_string(height) +
              ", " WEIR_CAPS_RATE ", interlace-mode=(string)progressive; ";
    };
    if (formats) add(formats, d[1], d[2]);
    if (d[2] == 3) add("{ RGBP, BGRP }", d[0], d[1]);
    auto out =
        Ref<GstCaps>::adopt(gst_caps_from_string((text + "application/octet-stream").c_str()));
    // What does not fit is last: the message of the element that refuses it says more than a
    // pipeline that cannot be linked.
    return out ? Ref<GstCaps>::adopt(gst_caps_merge(out.release(), caps.release())) : caps;
  }

  Result<Ref<GstBuffer>> densify(Ref<GstBuffer> buffer) {
    if (!negotiated_)
      return Error{Code::NOT_NEGOTIATED,
                   "a buffer came before caps",
                   "",
                   "caps",
                   "",
                   "put a capsfilter behind the source"};
    const size_t size = gst_buffer_get_size(buffer.get());
    if (size == 0)
      return Error{Code::FRAME_SIZE, "a buffer is empty", "0 bytes", "at least one frame", "", ""};
    if (is_video_) return video_.from(std::move(buffer), &ledger_);
    if (!flexible_bytes_ && size % frame_bytes_ != 0)
      return Error{
          Code::FRAME_SIZE,
          "a buffer does not hold whole frames",
          std::to_string(size) + " bytes",
          "a multiple of " + std::to_string(frame_bytes_) + " bytes for " + spec_.to_string(),
          "",
          "set blocksize=" + std::to_string(frame_bytes_) + " on the source"};
    return buffer;
  }

  std::vector<TensorSpec> flexible_tensors(GstBuffer* buffer) const {
    if (!flexible_bytes_) return spec_.tensors;
    const auto size = static_cast<uint32_t>(gst_buffer_get_size(buffer));
    return {{ElementType::UInt8, Shape{size}, ""}};
  }

  GstFlowReturn push(Ref<GstBuffer> buffer) {
    if (output_format_ == Format::Flexible) {
      buffer = with_headers(buffer.get(), flexible_tensors(buffer.get()),
                            is_video_ ? MediaType::Video : MediaType::Octet, &ledger_);
    } else if (spec_.tensors.size() > 1 || gst_buffer_n_memory(buffer.get()) > 1) {
      buffer = one_memory_each(buffer.get(), spec_.tensors, &ledger_);
    }
    if (!buffer) return GST_FLOW_ERROR;
    ledger_.pushed();
    return gst_pad_push(source_, buffer.release());
  }

  GstPad* sink_ = nullptr;    // owned by the element
  GstPad* source_ = nullptr;  // owned by the element
  // Streaming thread only:
  FrameSpec spec_;  // what is made, before the peer's wish for headers
  Format output_format_ = Format::Static;
  DenseVideo video_;
  bool is_video_ = false, negotiated_ = false;
  bool flexible_bytes_ = false;  // each buffer is one tensor of its own size
  size_t frame_bytes_ = 1;
  uint64_t frames_out_ = 1;
  GstSegment segment_{};
  Chunker chunker_;
};

}  // namespace

bool register_tensor_converter(GstPlugin* plugin) {
  return TensorConverter::register_in(plugin);
}

}  // namespace weir
