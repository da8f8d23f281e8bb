// tensor_converter: converts media to tensors; each Medium defines its own tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <atomic>
#include <cstring>

#include "elements/tensor_converter/media.hpp"
#include "elements/tensor_converter/negotiation.hpp"
#include "elements/tensor_converter/tensor_stream.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/query_meta.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/backwards_time.hpp"
#include "gstcpp/element/base_classes.hpp"
#include "gstcpp/element/model_event.hpp"
#include "gstcpp/pads/expected_caps.hpp"
#include "weir/join.hpp"

namespace weir {
namespace {

using gst::Ref;

class TensorConverter : public gst::Element<TensorConverter, gst::PlainElement> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirTensorConverter", "tensor_converter",
                                          "TensorConverter", "Converter/Tensor",
                                          "Converts media to tensors"};
  static void add_pad_templates(GstElementClass* element) {
    const auto add = [element](const char* name, GstPadDirection direction,
                               const Ref<GstCaps>& caps) {
      gst_element_class_add_pad_template(
          element, gst_pad_template_new(name, direction, GST_PAD_ALWAYS, caps.get()));
    };
    add("sink", GST_PAD_SINK, caps_of_media());
    add("src", GST_PAD_SRC,
        Ref<GstCaps>::adopt(
            gst_caps_from_string(WEIR_CAPS_TENSOR "; " WEIR_CAPS_TENSORS("{ static, flexible }"))));
  }

  using Settings = ConverterSettings;
  std::string sub_plugins() const { return join(converter_names(), ","); }
  static constexpr auto kPlaying = gst::Changeable::WhilePlaying;
  static constexpr std::tuple kProperties{
      gst::Property{"input-dim", &Settings::input_dim, "Dimensions of the tensors in a byte stream",
                    kPlaying},
      gst::Property{"input-type", &Settings::input_type,
                    "Element types of the tensors in a byte stream", kPlaying},
      gst::Property{"frames-per-tensor", &Settings::frames_per_tensor,
                    "Number of frames in each output", kPlaying, 1u, G_MAXUINT},
      gst::Property{"set-timestamp", &Settings::set_timestamp,
                    "Fill in missing timestamps and durations", kPlaying},
      gst::Property{"on-backwards-time", &Settings::on_backwards_time,
                    "What to do with a frame whose timestamp is earlier than the previous one"},
      gst::Property{"silent", &Settings::silent, "Accepted for compatibility; has no effect",
                    gst::Changeable::WhilePlaying},
      gst::Property{"mode", &Settings::mode,
                    "custom-code:NAME = a registered function makes the tensors, "
                    "custom-script:PATH = a Python script does; empty = the caps decide",
                    kPlaying},
      gst::ReadOnly{"sub-plugins", &TensorConverter::sub_plugins, "Installed external converters"},
  };

  void constructed() {
    sink_ = add_pad("sink");
    source_ = add_pad("src");
    stream_.send_to(source_);
    gst_pad_set_chain_function(sink_, (chain<&TensorConverter::on_buffer>));
    gst_pad_set_event_function(sink_, (pad_event<&TensorConverter::on_event>));
    gst_pad_set_query_function(sink_, (pad_query<&TensorConverter::on_query>));
    gst_pad_set_query_function(source_, (pad_query<&TensorConverter::on_source_query>));
  }

  Status check_change(const char*, const Settings& wanted) const {
    const auto mode = parse_converter_mode(wanted.mode);
    if (!mode) return mode.error();
    const bool unknown =
        mode->kind == ConverterMode::Kind::CustomCode && !is_custom_code(mode->name);
    return unknown ? Status(no_function(mode->name)) : ok();
  }
  void property_changed(const char* name) {
    expected_.forget();
    if (std::strcmp(name, "mode") != 0) return;
    const auto mode = parse_converter_mode(settings().mode);
    mode_is_reported_ = false;
    if (!mode)
      warn_of_mode(mode.error());
    else if (mode->kind == ConverterMode::Kind::CustomCode && !is_custom_code(mode->name))
      gst::post_warning(element(), no_function(mode->name));
  }

  GstStateChangeReturn change_state(GstStateChange change) {
    if (change == GST_STATE_CHANGE_READY_TO_PAUSED) {
      if (auto status = check_values(); !status) {
        gst::post_error(element(), status.error());
        return GST_STATE_CHANGE_FAILURE;
      }
      reset();
      ledger_.reset();
      stream_.reset_counts();
      missing_times_ = clients_replaced_ = 0;
      times_.reset();
    }
    const auto result = parent_class()->change_state(element(), change);
    if (change == GST_STATE_CHANGE_PAUSED_TO_READY) reset();
    return result;
  }

  Status check_values() const {
    const Settings s = settings();
    // A mode without a name is ignored.
    const auto mode = parse_converter_mode(s.mode);
    if (!mode && mode.error().code != Code::OPTION_SYNTAX) return mode.error();
    if (mode && mode->kind == ConverterMode::Kind::CustomScript)
      if (auto status = check_script(mode->name); !status) return status;
    const auto preferences = read_preferences(s);
    return preferences ? ok() : Status(preferences.error());
  }

  GstFlowReturn on_buffer(GstBuffer* raw) {
    ledger_.received();
    auto input = Ref<GstBuffer>::adopt(raw);
    if (stream_.is_configured() && is_written()) follow_properties(input.get());
    auto frames = stream_.convert(std::move(input));
    if (!frames) return fail(frames.error());
    if (frames->warning) gst::post_warning(element(), *frames->warning);
    if (!frames->buffer) {
      ledger_.dropped(DropReason::Policy);
      if (frames->gap && !stream_.waits_for_frame())
        gst_pad_push_event(source_, frames->gap.release());
      return GST_FLOW_OK;
    }
    // Copies memory that cannot be shared if the buffer has other owners.
    auto buffer = Ref<GstBuffer>::adopt(gst_buffer_make_writable(frames->buffer.release()));
    if (!buffer) return fail(gst::memory_not_mapped());
    const auto client = gst::get_client_id(buffer.get());
    ClientStream& waiting = streams_.of(client.value_or(0));
    if (!GST_BUFFER_PTS_IS_VALID(buffer.get())) ++missing_times_;
    if (!times_.may_pass(element(), GST_BUFFER_PTS(buffer.get()), &waiting.times)) {
      ledger_.dropped(DropReason::Time);
      return GST_FLOW_OK;
    }
    Chunker& chunker = waiting.chunker;
    const size_t size = gst_buffer_get_size(buffer.get());
    const StreamPlan& plan = stream_.plan();
    if (plan.frame_bytes == 0) chunker.configure(size, plan.frames_out, plan.spec.rate);
    const uint64_t count = plan.frame_bytes == 0 ? 1 : size / plan.frame_bytes;
    if (set_timestamp_) chunker.stamp(buffer.get(), count, fallback_time());
    if (auto status = chunker.push(std::move(buffer), buffer_limit_); !status)
      return fail(status.error());
    const GstFlowReturn flow = push_all(&chunker, client);
    ledger_.consumed(chunker.take_finished());
    return flow;
  }

  gboolean on_event(GstPad* pad, GstEvent* event) {
    switch (GST_EVENT_TYPE(event)) {
      case GST_EVENT_CAPS: {
        const auto owned = Ref<GstEvent>::adopt(event);
        GstCaps* caps = nullptr;
        gst_event_parse_caps(event, &caps);
        const Status status = negotiate(caps, take_settings(&followed_), false);
        if (!status) gst::post_error(element(), status.error());
        if (status && stream_.plan().warning) gst::post_warning(element(), *stream_.plan().warning);
        return status.has_value();
      }
      case GST_EVENT_SEGMENT:
        return on_segment(event);
      case GST_EVENT_EOS:
        drop_waiting(DropReason::Eos);
        break;
      case GST_EVENT_FLUSH_STOP:
        drop_waiting(DropReason::Flush);
        stream_.flush();
        gst_segment_init(&segment_, GST_FORMAT_TIME);
        break;
      case GST_EVENT_CUSTOM_DOWNSTREAM_STICKY:
        if (!gst::is_model_event(event)) break;
        gst_event_unref(event);  // the output has other tensors
        return TRUE;
      case GST_EVENT_GAP:
        if (!stream_.waits_for_frame()) break;
        gst_event_unref(event);
        return TRUE;
      default:
        break;
    }
    return gst_pad_event_default(pad, GST_OBJECT_CAST(self()), event);
  }

  gboolean on_query(GstPad* pad, GstQuery* query) {
    const auto mode = parse_converter_mode(settings().mode);
    const bool any_media = mode && mode->kind != ConverterMode::Kind::ByCaps;
    GstCaps* caps = nullptr;
    if (GST_QUERY_TYPE(query) == GST_QUERY_CAPS) {
      gst_query_parse_caps(query, &caps);
      gst_query_set_caps_result(query, offered_caps(pad, source_, caps, any_media).get());
      return TRUE;
    }
    if (GST_QUERY_TYPE(query) == GST_QUERY_ACCEPT_CAPS) {
      gst_query_parse_accept_caps(query, &caps);
      if (is_accepted_by_element(caps, any_media)) {
        gst_query_set_accept_caps_result(query, TRUE);
        return TRUE;
      }
    }
    if (GST_QUERY_TYPE(query) == GST_QUERY_ALLOCATION && stream_.is_configured()) {
      stream_.offer(query);
      return TRUE;
    }
    return gst_pad_query_default(pad, GST_OBJECT_CAST(self()), query);
  }

  gboolean on_source_query(GstPad* pad, GstQuery* query) {
    // Before PAUSED, while pads are linked, the template decides: the peer may spell the tensors
    // differently.
    if (GST_QUERY_TYPE(query) == GST_QUERY_CAPS && gst_pad_is_active(pad) &&
        !gst_pad_has_current_caps(sink_)) {
      GstCaps* filter = nullptr;
      gst_query_parse_caps(query, &filter);
      const auto expected = expected_.query(sink_, filter, [this](GstCaps* input) {
        return expected_caps(input, source_, settings());
      });
      if (!gst_caps_is_empty(expected.get())) {
        gst_query_set_caps_result(query, expected.get());
        return TRUE;
      }
    }
    return gst_pad_query_default(pad, GST_OBJECT_CAST(self()), query);
  }

  void add_stats(GstStructure* stats) const {
    gst_structure_set(stats, "missing-times", G_TYPE_UINT64, missing_times_.load(),
                      "backwards-times", G_TYPE_UINT64, times_.count(), "clients-given-up",
                      G_TYPE_UINT64, clients_replaced_.load(), "bytes-copied", G_TYPE_UINT64,
                      ledger_.snapshot().bytes_copied + stream_.bytes_gathered(), nullptr);
  }

  Settings settings_;
  Ledger ledger_;
  BufferLimit buffer_limit_{kInfo.factory_name};

 private:
  static Error no_function(const std::string& name) {
    return {.code = Code::CONVERTER_UNKNOWN,
            .what = "no function is registered under this name yet",
            .offered = "mode=custom-code:" + name,
            .fix = "weir_converter_register(\"" + name + "\", function, data)"};
  }

  GstFlowReturn fail(const Error& error) {
    ledger_.dropped(DropReason::Error);
    gst::post_error(element(), error);
    return error.code == Code::NOT_NEGOTIATED ? GST_FLOW_NOT_NEGOTIATED : GST_FLOW_ERROR;
  }

  // Without a bus the warning is lost; it is then repeated when caps arrive.
  void warn_of_mode(const Error& error) {
    mode_is_reported_ = GST_ELEMENT_BUS(element()) != nullptr;
    gst::post_warning(element(), error);
  }

  void on_client_replaced(uint64_t lost) {
    if (lost == 0) return;  // the client had no waiting frames
    ledger_.dropped(DropReason::Policy, lost);
    if (clients_replaced_++ == 0)
      gst::post_warning(element(),
                        {.code = Code::LIMIT_EXCEEDED,
                         .what = "more clients are active than frames are kept for",
                         .offered = std::to_string(gst::kClientLimit + 1) + " clients",
                         .needed = "at most " + std::to_string(gst::kClientLimit),
                         .difference = "the client that has been idle longest loses its frames",
                         .fix = "a pipeline for each group of clients"});
  }

  // Drops waiting frames that do not fill a tensor.
  void drop_waiting(DropReason reason) {
    const uint64_t lost = streams_.clear();
    if (lost > 0) ledger_.dropped(reason, lost);
  }

  void reset() {
    drop_waiting(DropReason::Flush);
    stream_.reset();
    expected_.forget();
    gst_segment_init(&segment_, GST_FORMAT_TIME);
  }

  GstClockTime fallback_time() const {
    if (stream_.plan().spec.rate.numerator <= 0) {
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
      times_.watch_segment(segment_);
      streams_.times_begin_again();
      return stream_.send_segment(Ref<GstEvent>::adopt(event));
    }
    const bool bytes = segment->format == GST_FORMAT_BYTES;
    const uint64_t start = segment->start;
    gst_event_unref(event);
    if (!bytes) {
      gst::post_error(element(), {.code = Code::FORMAT_UNSUPPORTED,
                                  .what = "the segment has no known unit",
                                  .needed = "time or bytes"});
      return FALSE;
    }
    gst_segment_init(&segment_, GST_FORMAT_TIME);
    times_.watch_segment(segment_);
    streams_.times_begin_again();
    const StreamPlan& plan = stream_.plan();
    const bool timed = stream_.is_configured() && plan.frame_bytes > 0 && known(plan.spec.rate);
    segment_.start = timed ? to_time(start / plan.frame_bytes, plan.spec.rate) : 0;
    segment_.time = segment_.position = segment_.start;
    return stream_.send_segment(Ref<GstEvent>::adopt(gst_event_new_segment(&segment_)));
  }

  // Called before the frame `next`: renegotiates the stream; if that fails, or the new settings do
  // not fit the frame, restores the old ones.
  void follow_properties(const GstBuffer* next) {
    const auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(sink_));
    if (!caps) return;
    follow_settings(&followed_, [&](const Settings& wanted) {
      Status status = negotiate(caps.get(), wanted, true, next);
      if (!status) static_cast<void>(negotiate(caps.get(), followed_.in_force, true));
      return status;
    });
  }

  Status negotiate(const GstCaps* caps, const Settings& s, bool goes_on,
                   const GstBuffer* next = nullptr) {
    const auto mode = parse_converter_mode(s.mode);
    if (!mode && mode.error().code != Code::OPTION_SYNTAX) {
      stream_.close();
      return mode.error();
    }
    if (!mode && !mode_is_reported_) warn_of_mode(mode.error());
    // A mode without a name is ignored.
    auto status = stream_.configure(caps, s, mode ? *mode : ConverterMode{}, goes_on, next);
    if (!status) return status;
    set_timestamp_ = s.set_timestamp;
    times_.decide(s.on_backwards_time);
    return ok();
  }

  // Pushes what the chunker has.
  GstFlowReturn push_all(Chunker* chunker, const std::optional<gint64>& client) {
    for (;;) {
      auto out = chunker->next();
      if (!out) {
        gst::post_error(element(), out.error());
        return GST_FLOW_ERROR;
      }
      if (!*out) return GST_FLOW_OK;
      ledger_.copied(chunker->take_copied());
      if (client) gst::set_client(out->get(), *client);
      auto buffer = stream_.make_output(*std::move(out));
      if (!buffer) {
        gst::post_error(element(), buffer.error());
        return GST_FLOW_ERROR;
      }
      ledger_.pushed();
      if (const auto flow = gst_pad_push(source_, buffer->release()); flow != GST_FLOW_OK)
        return flow;
    }
  }

  GstPad* sink_ = nullptr;    // owned by the element
  GstPad* source_ = nullptr;  // owned by the element
  // Streaming thread only:
  gst::LiveSettings<Settings> followed_;  // the settings of stream_
  bool set_timestamp_ = true;
  gst::BackwardsTimes times_;
  GstSegment segment_{};
  ClientStreams streams_{[this](uint64_t lost) { on_client_replaced(lost); }};
  TensorStream stream_{&ledger_, &buffer_limit_, &streams_};
  gst::ExpectedCaps expected_;
  std::atomic<bool> mode_is_reported_{false};  // posted while there was a bus
  // Written by the streaming thread, read by stats:
  std::atomic<uint64_t> missing_times_{0}, clients_replaced_{0};
};

}  // namespace

bool register_tensor_converter(GstPlugin* plugin) {
  return TensorConverter::register_in(plugin);
}

}  // namespace weir
