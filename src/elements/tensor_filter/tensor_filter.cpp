// tensor_filter: a neural network as a filter of a stream of tensors.
#include <atomic>
#include <memory>

#include "core/infer/invoke_statistics.hpp"
#include "core/infer/module_library.hpp"
#include "elements/tensor_filter/filter_settings.hpp"
#include "elements/tensor_filter/frame_invoker.hpp"
#include "elements/tensor_filter/opened_model.hpp"
#include "elements/tensor_filter/output_queue.hpp"
#include "gstcpp/base_classes.hpp"
#include "gstcpp/tensor_caps.hpp"

namespace weir {
namespace {

using gst::Ref;

std::string join(const std::vector<std::string>& names) {
  std::string out;
  for (const auto& name : names) out += (out.empty() ? "" : ",") + name;
  return out;
}

std::string ranks(const std::vector<ModelShape>& shapes) {
  std::string out;
  for (const auto& shape : shapes) {
    const size_t rank = shape.shape.empty() ? 1 : shape.shape.size();
    out += (out.empty() ? "" : ",") + std::to_string(rank);
  }
  return out;
}

class TensorFilter : public gst::Element<TensorFilter, gst::PlainElement> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirTensorFilter", "tensor_filter", "TensorFilter",
                                          "Filter/Tensor",
                                          "Runs a neural network on a stream of tensors"};
#define WEIR_FILTER_CAPS WEIR_CAPS_TENSOR "; " WEIR_CAPS_TENSORS("{ static, flexible }")
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_FILTER_CAPS)),
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_FILTER_CAPS)),
  };

  using Settings = FilterSettings;
  std::string framework() const {
    std::lock_guard lock(model_mutex_);
    return model_ ? model_->engine() : settings().framework;
  }
  std::string sub_plugins() const {
    return join(infer::ModuleLibrary::instance().engine_names());
  }
  std::string input_ranks() const {
    std::lock_guard lock(model_mutex_);
    return model_ ? ranks(model_->inputs()) : "";
  }
  std::string output_ranks() const {
    std::lock_guard lock(model_mutex_);
    return model_ ? ranks(model_->outputs()) : "";
  }
  int latency() const {
    return settings().latency ? statistics_.latency_us() : -1;
  }
  int throughput() const {
    return settings().throughput ? statistics_.throughput_milli() : -1;
  }

  static constexpr std::tuple kProperties{
      gst::Property{"silent", &Settings::silent, "Accepted for compatibility; has no effect"},
      gst::Property{"framework", &Settings::framework,
                    "Name of the engine; auto = found by the model file"},
      gst::Property{"model", &Settings::model, "Path of the model file; several: comma list"},
      gst::Property{"input", &Settings::input,
                    "Dimensions of the model's inputs, where the model leaves them open"},
      gst::Property{"inputtype", &Settings::inputtype, "Element types of the model's inputs"},
      gst::Property{"inputname", &Settings::inputname, "Names of the model's inputs"},
      gst::Property{"inputlayout", &Settings::inputlayout,
                    "NCHW, NHWC, ANY or NONE for each input"},
      gst::ReadOnly{"inputranks", &TensorFilter::input_ranks, "Ranks of the model's inputs"},
      gst::Property{"output", &Settings::output, "Dimensions of the model's outputs"},
      gst::Property{"outputtype", &Settings::outputtype, "Element types of the model's outputs"},
      gst::Property{"outputname", &Settings::outputname, "Names of the model's outputs"},
      gst::Property{"outputlayout", &Settings::outputlayout,
                    "NCHW, NHWC, ANY or NONE for each output"},
      gst::ReadOnly{"outputranks", &TensorFilter::output_ranks, "Ranks of the model's outputs"},
      gst::Property{"custom", &Settings::custom, "Options of the engine: key:value,key:value"},
      gst::ReadOnly{"sub-plugins", &TensorFilter::sub_plugins, "Engines that are installed"},
      gst::Gauge{"latency", &Settings::latency, &TensorFilter::latency,
                 "Write 1 to enable; reads as the mean of the last 10 invokes in microseconds", 0,
                 1},
      gst::Gauge{"throughput", &Settings::throughput, &TensorFilter::throughput,
                 "Write 1 to enable; reads as outputs per second x 1000", 0, 1},
      gst::Property{"input-combination", &Settings::input_combination,
                    "Comma list of the stream's tensors that the model gets"},
      gst::Property{"output-combination", &Settings::output_combination,
                    "Comma list of i<N> (input tensor) and o<N> (model output) to push"},
      gst::Property{"qos", &Settings::qos, "Drop frames that are too late for the sink",
                    gst::Changeable::WhilePlaying},
  };

  void constructed() {
    sink_ = add_pad("sink");
    source_ = add_pad("src");
    queue_.set_pad(source_);
    gst_pad_set_chain_function(sink_, (chain<&TensorFilter::on_buffer>));
    gst_pad_set_event_function(sink_, (pad_event<&TensorFilter::on_sink_event>));
    gst_pad_set_query_function(sink_, (pad_query<&TensorFilter::on_sink_query>));
    gst_pad_set_event_function(source_, (pad_event<&TensorFilter::on_source_event>));
    gst_pad_set_query_function(source_, (pad_query<&TensorFilter::on_source_query>));
  }

  GstStateChangeReturn change_state(GstStateChange change) {
    if (change == GST_STATE_CHANGE_READY_TO_PAUSED) {
      const Status status = open();
      if (!status) {
        gst::post_error(element(), status.error());
        return GST_STATE_CHANGE_FAILURE;
      }
      queue_.resume();
    }
    if (change == GST_STATE_CHANGE_PAUSED_TO_READY) queue_.flush();
    const auto result = parent_class()->change_state(element(), change);
    if (change == GST_STATE_CHANGE_PAUSED_TO_READY) close();
    return result;
  }

  GstFlowReturn on_buffer(GstBuffer* raw) {
    const auto buffer = Ref<GstBuffer>::adopt(raw);
    ledger_.received();
    if (is_late(buffer.get())) {
      ledger_.dropped(DropReason::Qos);
      return GST_FLOW_OK;
    }
    if (!invoker_)
      return fail({Code::NOT_NEGOTIATED, "a buffer came before caps", "", "caps", "",
                   "put a capsfilter behind the source"});
    const auto ticket = queue_.submit();
    if (!ticket) {
      ledger_.dropped(DropReason::Flush);
      return GST_FLOW_FLUSHING;
    }
    auto made = invoker_->run(buffer.get());
    if (made && *made) {
      gst_buffer_copy_into(made->get(), buffer.get(), GST_BUFFER_COPY_METADATA, 0,
                           static_cast<gsize>(-1));
      invoker_->copy_maps(buffer.get(), made->get());
      return queue_.finish(*ticket, *std::move(made));
    }
    queue_.skip(*ticket);
    if (!made) return fail(made.error());
    ledger_.dropped(DropReason::Policy);
    return GST_FLOW_OK;
  }

  gboolean on_sink_event(GstPad* pad, GstEvent* event) {
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
        gst_event_copy_segment(event, &segment_);
        break;
      case GST_EVENT_FLUSH_START:
        queue_.flush();
        return gst_pad_event_default(pad, GST_OBJECT_CAST(self()), event);
      case GST_EVENT_FLUSH_STOP:
        queue_.resume();
        earliest_ = GST_CLOCK_TIME_NONE;
        gst_segment_init(&segment_, GST_FORMAT_UNDEFINED);
        return gst_pad_event_default(pad, GST_OBJECT_CAST(self()), event);
      default:
        break;
    }
    if (gst_event_type_get_flags(GST_EVENT_TYPE(event)) & GST_EVENT_TYPE_SERIALIZED)
      return queue_.send(Ref<GstEvent>::adopt(event));
    return gst_pad_event_default(pad, GST_OBJECT_CAST(self()), event);
  }

  gboolean on_source_event(GstPad* pad, GstEvent* event) {
    if (GST_EVENT_TYPE(event) == GST_EVENT_QOS) {
      GstQOSType type;
      gdouble proportion;
      GstClockTimeDiff diff;
      GstClockTime time;
      gst_event_parse_qos(event, &type, &proportion, &diff, &time);
      if (GST_CLOCK_TIME_IS_VALID(time) && (diff >= 0 || static_cast<GstClockTime>(-diff) <= time))
        earliest_ = time + static_cast<GstClockTime>(diff);
    }
    return gst_pad_event_default(pad, GST_OBJECT_CAST(self()), event);
  }

  gboolean on_sink_query(GstPad* pad, GstQuery* query) {
    if (GST_QUERY_TYPE(query) == GST_QUERY_CAPS) return answer_caps(sink_, query);
    if (GST_QUERY_TYPE(query) == GST_QUERY_ACCEPT_CAPS) {
      GstCaps* caps = nullptr;
      gst_query_parse_accept_caps(query, &caps);
      const auto ours = Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(pad));
      // Wrong sizes are answered in negotiate(), where the message can say what is needed.
      gst_query_set_accept_caps_result(query, gst_caps_can_intersect(caps, ours.get()));
      return TRUE;
    }
    if (GST_QUERY_TYPE(query) == GST_QUERY_ALLOCATION) {
      std::lock_guard lock(model_mutex_);
      if (!model_) return FALSE;
      gst::offer(query, model_->allocation());
      return TRUE;
    }
    return gst_pad_query_default(pad, GST_OBJECT_CAST(self()), query);
  }

  gboolean on_source_query(GstPad* pad, GstQuery* query) {
    if (GST_QUERY_TYPE(query) == GST_QUERY_CAPS) return answer_caps(source_, query);
    return gst_pad_query_default(pad, GST_OBJECT_CAST(self()), query);
  }

  void add_stats(GstStructure* stats) const {
    const auto s = statistics_.snapshot();
    gst_structure_set(stats, "invokes", G_TYPE_UINT64, s.count, "last-us", G_TYPE_DOUBLE, s.last_us,
                      "average-us", G_TYPE_DOUBLE, s.average_us, "p99-us", G_TYPE_DOUBLE, s.p99_us,
                      "pool-allocated", G_TYPE_UINT64, pool_allocated_.load(), nullptr);
  }

  Settings settings_;
  Ledger ledger_;

 private:
  GstPad* add_pad(const char* name) {
    GstPadTemplate* pad_template =
        gst_element_class_get_pad_template(GST_ELEMENT_GET_CLASS(element()), name);
    GstPad* pad = gst_pad_new_from_template(pad_template, name);
    gst_element_add_pad(element(), pad);
    return pad;
  }

  Status open() {
    auto opened = OpenedModel::open(settings());
    if (!opened) return opened.error();
    std::lock_guard lock(model_mutex_);
    model_ = *std::move(opened);
    ledger_.reset();
    statistics_.reset();
    pool_allocated_ = 0;
    earliest_ = GST_CLOCK_TIME_NONE;
    gst_segment_init(&segment_, GST_FORMAT_UNDEFINED);
    return ok();
  }
  // Streaming has ended: the pads are inactive.
  void close() {
    invoker_.reset();
    std::lock_guard lock(model_mutex_);
    model_.reset();
  }

  GstFlowReturn fail(const Error& error) {
    gst::post_error(element(), error);
    ledger_.dropped(DropReason::Error);
    return error.code == Code::NOT_NEGOTIATED ? GST_FLOW_NOT_NEGOTIATED : GST_FLOW_ERROR;
  }

  bool is_late(GstBuffer* buffer) {
    const GstClockTime earliest = earliest_;
    if (!GST_CLOCK_TIME_IS_VALID(earliest) || !settings().qos) return false;
    const auto running =
        gst_segment_to_running_time(&segment_, GST_FORMAT_TIME, GST_BUFFER_PTS(buffer));
    return GST_CLOCK_TIME_IS_VALID(running) && running <= earliest;
  }

  Status negotiate(GstCaps* caps) {
    const auto input = gst::fixed_spec_from_caps(caps);
    if (!input) return input.error();
    auto plan = model_->plan_for(*input);
    if (!plan) return plan.error();
    auto out_caps = output_caps(plan->output);
    if (!out_caps) return out_caps.error();
    const auto chosen = gst::spec_from_caps(out_caps->get());
    if (!chosen) return chosen.error();
    plan->output = *chosen;
    invoker_ = std::make_unique<FrameInvoker>(*std::move(plan), model_->session(), &statistics_,
                                              &ledger_, &pool_allocated_);
    if (auto status = invoker_->prepare(); !status) return status;
    // Caps that the peer takes go through, unless this element is being shut or flushed.
    queue_.send(Ref<GstEvent>::adopt(gst_event_new_caps(out_caps->get())));
    return ok();
  }

  // Rule B of the specification: the first of the possible caps that the peer takes.
  Result<Ref<GstCaps>> output_caps(const FrameSpec& spec) {
    const auto peer = Ref<GstCaps>::adopt(gst_pad_peer_query_caps(source_, nullptr));
    const auto possible = gst::possible_caps(source_, spec, peer.get());
    auto meet = Ref<GstCaps>::adopt(
        gst_caps_intersect_full(possible.get(), peer.get(), GST_CAPS_INTERSECT_FIRST));
    if (gst_caps_is_empty(meet.get())) return refused(spec, peer.get());
    return Ref<GstCaps>::adopt(gst_caps_fixate(gst_caps_truncate(meet.release())));
  }

  static Error refused(const FrameSpec& spec, GstCaps* peer) {
    const gst::UniqueText text{gst_caps_to_string(peer)};
    return Error{Code::SPEC_MISMATCH,
                 "the element behind tensor_filter does not take its output",
                 spec.to_string(),
                 text.get(),
                 "",
                 "other/tensors,format=static,num_tensors=" + std::to_string(spec.tensors.size()) +
                     ",dimensions=(string)" + join_shapes(spec.tensors) +
                     ",types=" + join_types(spec.tensors)};
  }

  gboolean answer_caps(GstPad* pad, GstQuery* query) {
    GstCaps* filter = nullptr;
    gst_query_parse_caps(query, &filter);
    auto caps = Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(pad));
    {
      std::lock_guard lock(model_mutex_);
      FrameSpec spec;
      spec.format = Format::Static;
      if (model_ && pad == sink_ && !model_->combines_inputs())
        spec.tensors = known_parts(model_->inputs());
      else if (model_ && pad == source_)
        spec.tensors = model_->known_outputs();
      if (!spec.tensors.empty()) caps = gst::possible_caps(pad, spec, filter);
    }
    if (filter) {
      const auto narrowed = [filter](GstCaps* wide) {
        return Ref<GstCaps>::adopt(gst_caps_intersect_full(filter, wide, GST_CAPS_INTERSECT_FIRST));
      };
      caps = narrowed(caps.get());
      // What does not fit the model is refused in negotiate(), where the message can say what
      // would.
      if (pad == sink_ && gst_caps_is_empty(caps.get()))
        caps = narrowed(Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(pad)).get());
    }
    gst_query_set_caps_result(query, caps.get());
    return TRUE;
  }

  GstPad* sink_ = nullptr;          // owned by the element
  GstPad* source_ = nullptr;        // owned by the element
  mutable std::mutex model_mutex_;  // guards model_ against queries while it opens and closes
  std::unique_ptr<OpenedModel> model_;
  std::unique_ptr<FrameInvoker> invoker_;  // streaming thread only
  OutputQueue queue_{&ledger_, 1};         // one frame in work, on the streaming thread
  infer::InvokeStatistics statistics_;
  std::atomic<uint64_t> pool_allocated_{0};
  std::atomic<GstClockTime> earliest_{GST_CLOCK_TIME_NONE};  // running time, from QOS events
  GstSegment segment_{};                                     // streaming thread only
};

}  // namespace

bool register_tensor_filter(GstPlugin* plugin) {
  return TensorFilter::register_in(plugin);
}

}  // namespace weir
