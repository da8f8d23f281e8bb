// tensor_aggregator: collects frames of a stream in windows, which may overlap.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <atomic>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "elements/tensor_aggregator/window_stream.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/query_meta.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/backwards_time.hpp"
#include "gstcpp/element/described_caps.hpp"
#include "gstcpp/element/per_client.hpp"
#include "gstcpp/element/plain_filter.hpp"
#include "gstcpp/pads/latency.hpp"
#include "gstcpp/pads/placeholder_wait.hpp"
#include "gstcpp/pads/streaming_threads.hpp"

namespace weir {
namespace {

using gst::Ref;

class TensorAggregator : public gst::PlainFilter<TensorAggregator> {
 public:
  static constexpr gst::ElementInfo kInfo{
      "WeirTensorAggregator", "tensor_aggregator", "TensorAggregator", "Filter/Tensor",
      "Collects frames of tensors into windows, or splits them"};
#define WEIR_AGGREGATOR_CAPS \
  WEIR_CAPS_TENSOR           \
  "; other/tensors, format=(string)static, num_tensors=(int)[ 1, 256 ], " WEIR_CAPS_RATE
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_AGGREGATOR_CAPS)),
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_AGGREGATOR_CAPS)),
  };
  struct Settings {
    uint32_t frames_in = 1, frames_out = 1, frames_flush = 0, frames_dim = 15;
    bool concat = true;
    OnBackwardsTime on_backwards_time = OnBackwardsTime::Pass;
    bool silent = true;
  };
  static constexpr auto kPlaying = gst::Changeable::WhilePlaying;
  static constexpr std::tuple kProperties{
      gst::Property{"frames-in", &Settings::frames_in, "Number of frames in each input buffer",
                    kPlaying, 1u, G_MAXUINT},
      gst::Property{"frames-out", &Settings::frames_out, "Number of frames in each window",
                    kPlaying, 1u, G_MAXUINT},
      gst::Property{"frames-flush", &Settings::frames_flush,
                    "Number of frames from one window to the next; 0 = frames-out", kPlaying},
      gst::Property{"frames-dim", &Settings::frames_dim,
                    "Dimension along which the frames of a buffer are arranged", kPlaying, 0u, 15u},
      gst::Property{"concat", &Settings::concat,
                    "Concatenate frames along frames-dim; false = append whole frames", kPlaying},
      gst::Property{"on-backwards-time", &Settings::on_backwards_time,
                    "What to do with a frame whose time is before that of the previous frame"},
      gst::Property{"silent", &Settings::silent, "Accepted for compatibility; has no effect",
                    gst::Changeable::WhilePlaying},
  };

  GstStateChangeReturn change_state(GstStateChange change) {
    if (change == GST_STATE_CHANGE_READY_TO_PAUSED)
      if (const auto setup = make_setup({}, settings()); !setup) {
        gst::post_error(element(), setup.error());
        return GST_STATE_CHANGE_FAILURE;
      }
    return gst::PlainFilter<TensorAggregator>::change_state(change);
  }

  // A window of another size than its caps would end the stream that runs.
  Status check_change(const char* name, const Settings& wanted) const {
    const auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(sink_));
    const auto spec = caps ? gst::fixed_spec_from_caps(caps.get()) : Result<FrameSpec>(Error{});
    if (!spec || std::strcmp(name, "frames-dim") != 0) return ok();
    const auto setup = make_setup(*spec, wanted);
    if (!setup || !(*setup)->plan.size_differs) return ok();
    return wrong_size(**setup, "the value was rejected, and the old one stays");
  }

  Status set_caps(GstCaps* caps) {
    const auto spec = gst::fixed_spec_from_caps(caps);
    if (!spec) return spec.error();
    if (is_written()) setup_ = nullptr;
    const Settings s = take_settings(&followed_);
    times_.decide(s.on_backwards_time);
    Status status = begin_stream(*spec, s);
    if (auto segment = status ? placeholder_.take_segment() : Ref<GstEvent>())
      gst_pad_push_event(source_, segment.release());
    return placeholder_.judged(*spec, std::move(status));
  }

  GstFlowReturn chain(Ref<GstBuffer> in) {
    if (const Error* refusal = placeholder_.refusal()) return refused(*refusal);
    if (!setup_) return failed(gst::buffer_before_caps());
    if (is_written())
      if (const auto flow = follow_properties(); flow != GST_FLOW_OK) {
        ledger_.dropped(DropReason::Error);
        return flow;
      }
    if (setup_->plan.passes_through) return pass(std::move(in));
    if (const auto status = buffer_limit_.check(setup_->window_bytes); !status)
      return failed(status.error());
    WindowStream& stream = clients_.of(gst::get_client_id(in.get()).value_or(0));
    if (!times_.may_pass(element(), GST_BUFFER_PTS(in.get()), &stream.times)) {
      ledger_.dropped(DropReason::Time);
      return GST_FLOW_OK;
    }
    if (const auto status = stream.push(std::move(in), &ledger_); !status)
      return failed(status.error());
    return push_windows(stream);
  }

  // Pushes the windows that are complete.
  GstFlowReturn push_windows(WindowStream& stream) {
    while (true) {
      auto out = stream.next(&ledger_);
      if (!out) return gst::post_error(element(), out.error()), GST_FLOW_ERROR;
      frames_lost_ += stream.take_frames_lost();
      if (!*out) return GST_FLOW_OK;
      ledger_.pushed();
      const auto flow = gst_pad_push(source_, out->release());
      if (flow != GST_FLOW_OK) return flow;
    }
  }

  // Counts the waiting frames; the last window may never be complete.
  void drain(DropReason reason) {
    clients_.for_each([&](WindowStream& stream) {
      stream.clear(reason, &ledger_);
      frames_lost_ += stream.take_frames_lost();
    });
  }
  void reset() {
    placeholder_.reset();
    clients_.clear();
    setup_ = nullptr;
    allocation_ = {};
    set_latency(0);
  }

  bool sink_event(GstEvent* event) {
    if (GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_STOP) placeholder_.flush();
    if (GST_EVENT_TYPE(event) == GST_EVENT_STREAM_START) frames_lost_ = 0, times_.reset();
    if (GST_EVENT_TYPE(event) == GST_EVENT_SEGMENT) {
      const GstSegment* segment = nullptr;
      gst_event_parse_segment(event, &segment);
      times_.watch_segment(*segment);
      clients_.for_each([](WindowStream& stream) { stream.times.reset(); });
    }
    return placeholder_.keeps(event);
  }

  gboolean on_query(GstPad* pad, GstQuery* query) {
    if (pad == source_ && GST_QUERY_TYPE(query) == GST_QUERY_LATENCY)
      return gst::handle_latency_query(sink_, query, latency_);
    if (pad == sink_ && GST_QUERY_TYPE(query) == GST_QUERY_ALLOCATION && setup_ &&
        setup_->plan.passes_through)
      return gst_pad_peer_query(source_, query);
    return gst::query_with_static_filter(pad, GST_OBJECT_CAST(self()), query);
  }

  void add_stats(GstStructure* stats) const {
    gst_structure_set(stats, "frames-lost", G_TYPE_UINT64, frames_lost_.load(), "backwards-times",
                      G_TYPE_UINT64, times_.count(), nullptr);
  }

  Settings settings_;
  BufferLimit buffer_limit_{kInfo.factory_name};

 private:
  Status begin_stream(const FrameSpec& spec, const Settings& s) {
    if (setup_ && setup_->input == spec) return announce(setup_.get());
    // A window cannot mix frames of different tensors.
    drain(DropReason::Flush);
    clients_.clear();
    setup_ = nullptr;
    auto setup = make_setup(spec, s);
    if (!setup) return setup.error();
    if (auto status = announce(setup->get()); !status) return status;
    setup_ = *std::move(setup);
    return ok();
  }
  // A frame whose caps could have been a placeholder's, but are not.
  GstFlowReturn refused(const Error& error) {
    failed(error);
    return GST_FLOW_NOT_NEGOTIATED;
  }

  // Called between two frames: waiting frames move to a window of the new settings.
  GstFlowReturn follow_properties() {
    std::shared_ptr<WindowSetup> made;
    const auto judge = [&](const Settings& wanted) -> Status {
      auto setup = make_setup(setup_->input, wanted);
      if (!setup) return setup.error();
      made = *std::move(setup);
      return announce(made.get());
    };
    if (!follow_settings(&followed_, judge)) return GST_FLOW_OK;
    std::vector<Ref<GstBuffer>> waiting;
    clients_.for_each([&](WindowStream& stream) {
      for (auto& buffer : stream.take_back(&ledger_)) waiting.push_back(std::move(buffer));
    });
    clients_.clear();
    setup_ = std::move(made);
    for (auto& buffer : waiting) {
      if (setup_->plan.passes_through) {
        if (const auto flow = pass(std::move(buffer)); flow != GST_FLOW_OK) return flow;
        continue;
      }
      WindowStream& stream = clients_.of(gst::get_client_id(buffer.get()).value_or(0));
      if (const auto status = stream.push(std::move(buffer), &ledger_); !status)
        return failed(status.error());
    }
    return GST_FLOW_OK;
  }

  Result<std::shared_ptr<WindowSetup>> make_setup(const FrameSpec& input, const Settings& s) const {
    auto plan = window::plan({s.frames_in, s.frames_out, s.frames_flush, s.frames_dim, s.concat},
                             input.tensors);
    if (!plan) return plan.error();
    auto setup = std::make_shared<WindowSetup>();
    setup->input = input;
    setup->plan = *std::move(plan);
    setup->dimension = s.frames_dim;
    return setup;
  }

  // Sends the caps of the windows, makes their pool and sets the latency.
  Status announce(WindowSetup* setup) {
    if (setup->plan.size_differs)
      gst::post_warning(
          element(),
          wrong_size(*setup, "the caps stay unchanged and do not match the size of the frames"));
    const FrameSpec output{Format::Static, setup->plan.output, setup->input.rate};
    setup->window_bytes =
        FrameSpec{Format::Static, setup->plan.memory, {}}.bytes().value_or(UINT64_MAX);
    if (!setup->plan.passes_through)
      if (auto status = buffer_limit_.check(setup->window_bytes); !status) return status;
    const auto caps = gst::choose_caps(source_, gst::PeerCaps(source_), output);
    if (auto status = gst::send_caps(source_, output, caps.get()); !status) return status;
    if (setup->plan.passes_through) return set_latency(0), ok();
    allocation_ = gst::wanted_by_peer(source_, caps.get(), ledger_, allocation_);
    auto pool =
        gst::FramePool::make(setup->plan.memory, Format::Static, MediaType::Tensor, allocation_);
    if (!pool) return pool.error();
    setup->pool = *std::move(pool);
    const uint64_t buffers = setup->plan.buffers_waited();
    const GstClockTime latency = window::to_time(buffers * setup->plan.in, setup->input.rate);
    const gst::Window window{latency, buffers, setup->input.bytes().value_or(0)};
    if (auto status = gst::can_collect(element(), sink_, window); !status)
      gst::post_warning(element(), status.error());
    set_latency(latency);
    return ok();
  }

  static Error wrong_size(const WindowSetup& setup, const std::string& effect) {
    const auto& shape = setup.input.tensors[0].shape;
    const size_t rank = shape.rank();
    const uint64_t frames = setup.plan.in;
    size_t fits = rank - 1;  // the outermost dimension that holds whole frames
    while (fits > 0 && shape[fits] % frames != 0) --fits;
    return {
        .code = Code::OPTION_VALUE,
        .what = "frames-dim is beyond the dimensions of the tensors: " + effect,
        .offered = "frames-dim=" + std::to_string(setup.dimension) + ", " + setup.input.to_string(),
        .needed = "0 to " + std::to_string(rank - 1),
        .fix = shape[fits] % frames != 0 ? ""
                                         : "tensor_aggregator frames-dim=" + std::to_string(fits)};
  }

  GstFlowReturn pass(Ref<GstBuffer> in) {
    if (auto status = gst::whole_frame(setup_->input, gst_buffer_get_size(in.get())); !status)
      return failed(status.error());
    ledger_.consumed_and_pushed();
    return gst_pad_push(source_, in.release());
  }

  void remove_client(WindowStream* stream) {
    stream->clear(DropReason::Policy, &ledger_);
    frames_lost_ += stream->take_frames_lost();
    GST_CAT_WARNING_OBJECT(
        category(), self(),
        "more than %zu clients: the frames of the client that has been idle longest are dropped",
        gst::kClientLimit);
  }

  // The first frame of a window waits for its last.
  void set_latency(GstClockTime latency) {
    if (latency_.exchange(latency) != latency)
      gst_element_post_message(element(), gst_message_new_latency(GST_OBJECT_CAST(self())));
  }

  // Streaming thread only:
  std::shared_ptr<WindowSetup> setup_;  // null until caps are accepted
  gst::Allocation allocation_;          // requested by the peer
  gst::BackwardsTimes times_;
  gst::PerClient<WindowStream> clients_{[this] { return WindowStream(setup_); },
                                        [this](WindowStream& s) { remove_client(&s); }};
  gst::LiveSettings<Settings> followed_;  // the settings of setup_
  gst::PlaceholderWait placeholder_;
  // Any thread:
  std::atomic<GstClockTime> latency_{0};
  std::atomic<uint64_t> frames_lost_{0};
};

}  // namespace

bool register_tensor_aggregator(GstPlugin* plugin) {
  return TensorAggregator::register_in(plugin);
}

}  // namespace weir
