// tensor_filter: runs a neural network on a stream of tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <atomic>
#include <cstring>
#include <memory>

#include "elements/tensor_filter/admission.hpp"
#include "elements/tensor_filter/filter_properties.hpp"
#include "elements/tensor_filter/frame_flow.hpp"
#include "elements/tensor_filter/input_fix.hpp"
#include "elements/tensor_filter/model_config.hpp"
#include "elements/tensor_filter/running_flow.hpp"
#include "elements/tensor_filter/running_model.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/base_classes.hpp"
#include "gstcpp/element/described_caps.hpp"
#include "gstcpp/element/model_event.hpp"
#include "gstcpp/element/property_file.hpp"
#include "gstcpp/pads/latency.hpp"
#include "gstcpp/pads/placeholder_wait.hpp"

namespace weir {
namespace {

using gst::Ref;

Error refused(GstPad* source, const GstCaps* peer, const FrameSpec& spec) {
  const bool flexible = spec.format == Format::Flexible;
  return gst::downstream_mismatch(
      source, peer,
      flexible ? "format=flexible: the model decides with each frame, or invoke-dynamic=true"
               : spec.to_string(),
      gst::caps_to_paste(spec));
}

Ref<GstCaps> offered_caps(GstPad* pad, const OpenModel* model, GstCaps* filter) {
  const bool is_sink = GST_PAD_IS_SINK(pad);
  auto caps = Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(pad));
  if (model) {
    const auto spec =
        is_sink ? model->description().sink_spec() : model->description().source_spec();
    if (spec.format == Format::Flexible || !spec.tensors.empty())
      caps = gst::possible_caps(pad, spec, filter);
  }
  if (!filter) return caps;
  const auto narrowed = [filter](GstCaps* wide) {
    return Ref<GstCaps>::adopt(gst_caps_intersect_full(filter, wide, GST_CAPS_INTERSECT_FIRST));
  };
  caps = narrowed(caps.get());
  // Caps that do not fit the model are rejected in the caps event, where an error can explain it:
  // with an empty result, a capsfilter after filesrc sends no caps and reports only that they are
  // EMPTY.
  if (is_sink && gst_caps_is_empty(caps.get()))
    caps = narrowed(Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(pad)).get());
  return caps;
}

// Rule B of docs/compatibility/types-and-caps.md 1.5: the first of the possible caps for `spec`
// that the peer of `source` accepts, fixed. SPEC_MISMATCH with both sides if it accepts none.
Result<Ref<GstCaps>> choose_output_caps(GstPad* source, const FrameSpec& spec) {
  const auto peer = Ref<GstCaps>::adopt(gst_pad_peer_query_caps(source, nullptr));
  const auto possible = gst::possible_caps(source, spec, peer.get());
  auto meet = Ref<GstCaps>::adopt(
      gst_caps_intersect_full(possible.get(), peer.get(), GST_CAPS_INTERSECT_FIRST));
  if (gst_caps_is_empty(meet.get())) return refused(source, peer.get(), spec);
  return Ref<GstCaps>::adopt(gst_caps_fixate(gst_caps_truncate(meet.release())));
}

// Handles a CAPS query on a pad of the filter from what is known of the model's tensors; `model`
// may be null. False for any other query.
bool handle_caps_query(GstPad* pad, const OpenModel* model, GstQuery* query) {
  GstCaps* caps = nullptr;
  if (GST_QUERY_TYPE(query) == GST_QUERY_CAPS) {
    gst_query_parse_caps(query, &caps);
    const auto described = gst::static_where_described(caps);
    gst_query_set_caps_result(query, offered_caps(pad, model, described.get()).get());
    return true;
  }
  if (GST_QUERY_TYPE(query) != GST_QUERY_ACCEPT_CAPS || !GST_PAD_IS_SINK(pad)) return false;
  gst_query_parse_accept_caps(query, &caps);
  const auto ours = Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(pad));
  // Wrong sizes are rejected in the caps event, where an error can name the needed ones.
  gst_query_set_accept_caps_result(query, gst_caps_can_intersect(caps, ours.get()));
  return true;
}

class TensorFilter final : public gst::Element<TensorFilter, gst::PlainElement>,
                           public ModelReport {
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
  static constexpr auto kProperties = kFilterProperties;

  void constructed() {
    sink_ = add_pad("sink");
    source_ = add_pad("src");
    start_flow({});
    admission_.set_element(element(), sink_);
    gst_pad_set_chain_function(sink_, (chain<&TensorFilter::on_buffer>));
    gst_pad_set_event_function(sink_, (pad_event<&TensorFilter::on_sink_event>));
    gst_pad_set_query_function(sink_, (pad_query<&TensorFilter::on_sink_query>));
    gst_pad_set_event_function(source_, (pad_event<&TensorFilter::on_source_event>));
    gst_pad_set_query_function(source_, (pad_query<&TensorFilter::on_source_query>));
  }

  Status check_change(const char* name, const Settings& wanted) const {
    if (std::strcmp(name, "config-file") == 0) return gst::check_property_file(wanted.config_file);
    return check_lists(wanted);
  }
  static bool is_followed(const char* name) {
    return reopens_model(name);
  }
  void property_changed(const char* name) {
    if (std::strcmp(name, "config-file") == 0)
      config_file_.read(G_OBJECT(element()), settings().config_file);
    if (std::strcmp(name, "model") == 0) replace_model();
    configure();
  }

  GstStateChangeReturn change_state(GstStateChange change) {
    if (change == GST_STATE_CHANGE_NULL_TO_READY) threads_.claim(settings());
    if (change == GST_STATE_CHANGE_READY_TO_PAUSED) {
      if (const Status status = open(); !status) {
        gst::post_error(element(), status.error());
        return GST_STATE_CHANGE_FAILURE;
      }
      flow_.start();
    }
    if (change == GST_STATE_CHANGE_PAUSED_TO_READY) stop();
    const auto result = parent_class()->change_state(element(), change);
    const bool not_started =
        change == GST_STATE_CHANGE_READY_TO_PAUSED && result == GST_STATE_CHANGE_FAILURE;
    if (not_started) stop();
    if (change == GST_STATE_CHANGE_PAUSED_TO_READY || not_started) close();
    if (change == GST_STATE_CHANGE_READY_TO_NULL) threads_.release();
    return result;
  }

  GstFlowReturn on_buffer(GstBuffer* raw) {
    auto buffer = Ref<GstBuffer>::adopt(raw);
    ledger_.received();
    admission_.warn_if_late(buffer.get());
    const auto flow = process(std::move(buffer));
    admission_.note_idle();
    return flow;
  }

  GstFlowReturn process(Ref<GstBuffer> buffer) {
    model_.touch();
    if (const auto flow = follow(); flow != GST_FLOW_OK) {
      ledger_.dropped(flow == GST_FLOW_FLUSHING ? DropReason::Flush : DropReason::Error);
      return flow;
    }
    if (const Error* refusal = placeholder_.refusal()) {
      ledger_.dropped(DropReason::Error);
      const auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(sink_));
      gst::post_error(element(), with_fix(*refusal, caps.get()));
      return GST_FLOW_NOT_NEGOTIATED;
    }
    if (const auto reason = admission_.drop_reason(buffer.get())) {
      ledger_.dropped(*reason);
      return GST_FLOW_OK;
    }
    if (is_flexible_ && gst::has_empty_tensor(buffer.get()) && !model_.get()->takes_empty()) {
      ledger_.dropped(DropReason::Policy);
      if (auto gap = gst::gap_like(buffer.get())) flow_->send(std::move(gap));
      return GST_FLOW_OK;
    }
    const GstClockTime deadline = admission_.get_deadline(buffer.get());
    const auto flow = flow_->push(std::move(buffer), deadline);
    model_.touch();
    return flow;
  }

  gboolean on_sink_event(GstPad* pad, GstEvent* event) {
    switch (GST_EVENT_TYPE(event)) {
      case GST_EVENT_CAPS: {
        const auto owned = Ref<GstEvent>::adopt(event);
        GstCaps* caps = nullptr;
        gst_event_parse_caps(event, &caps);
        gst_pad_check_reconfigure(source_);
        const Status status = negotiate(caps, true);
        model_.touch();  // negotiation may have opened a suspended model
        if (!status) gst::post_error(element(), with_fix(status.error(), caps));
        return status.has_value();
      }
      case GST_EVENT_SEGMENT:
        admission_.set_segment(event);
        break;
      case GST_EVENT_FLUSH_START:
        flow_.flush();
        break;
      case GST_EVENT_FLUSH_STOP:
        placeholder_.flush();
        flow_.resume();
        admission_.restart();
        return gst_pad_event_default(pad, GST_OBJECT_CAST(self()), event);
      case GST_EVENT_CUSTOM_DOWNSTREAM:
      case GST_EVENT_CUSTOM_DOWNSTREAM_OOB:
        if (const auto model = wanted_model(event); model && settings().is_updatable) {
          gst_event_unref(event);
          replace_model_later(*model);
          return TRUE;
        }
        break;
      case GST_EVENT_CUSTOM_DOWNSTREAM_STICKY:
        if (!gst::is_model_event(event)) break;
        gst_event_unref(event);  // of a model upstream, whose outputs end here
        return TRUE;
      default:
        break;
    }
    if (placeholder_.keeps(event)) return TRUE;
    if (gst_event_type_get_flags(GST_EVENT_TYPE(event)) & GST_EVENT_TYPE_SERIALIZED)
      return flow_->send(Ref<GstEvent>::adopt(event));
    return gst_pad_event_default(pad, GST_OBJECT_CAST(self()), event);
  }

  gboolean on_source_event(GstPad* pad, GstEvent* event) {
    if (GST_EVENT_TYPE(event) == GST_EVENT_QOS &&
        admission_.handle_qos(event) == FrameAdmission::QosResult::Throttle) {
      gst_event_unref(event);
      change_settings([](Settings& s) { s.latency = 1; });
      return TRUE;
    }
    return gst_pad_event_default(pad, GST_OBJECT_CAST(self()), event);
  }

  gboolean on_sink_query(GstPad* pad, GstQuery* query) {
    if (handle_caps_query(pad, opened().get(), query)) return TRUE;
    if (GST_QUERY_TYPE(query) == GST_QUERY_DRAIN) flow_->drain();
    if (GST_QUERY_TYPE(query) == GST_QUERY_ALLOCATION) {
      const auto model = opened();
      if (!model) return FALSE;
      gst::offer(query, model->allocation());
      return TRUE;
    }
    return gst_pad_query_default(pad, GST_OBJECT_CAST(self()), query);
  }

  gboolean on_source_query(GstPad* pad, GstQuery* query) {
    if (handle_caps_query(pad, opened().get(), query)) return TRUE;
    if (GST_QUERY_TYPE(query) == GST_QUERY_LATENCY) {
      const auto delay = flow_->report_latency();
      return gst::handle_latency_query(sink_, query, delay.min, delay.max);
    }
    return gst_pad_query_default(pad, GST_OBJECT_CAST(self()), query);
  }

  void add_stats(GstStructure* stats) const {
    flow_->add_stats(stats);
    gst_structure_set(stats, "threads", G_TYPE_INT, engine_threads_.load(), nullptr);
    if (const auto monitor = model_.monitor()) add_worker_stats(*monitor, stats);
    if (const auto model = model_.get()) model->add_stats(stats);
  }

  std::shared_ptr<const OpenModel> opened() const override {
    return model_.get();
  }

  Settings current_settings() const override {
    return settings();
  }

  Settings settings_;
  Ledger ledger_;
  BufferLimit buffer_limit_{kInfo.factory_name};

 private:
  // Called without active pads; all counters start at 0.
  void start_flow(const Settings& s) {
    statistics_.reset();
    flow_.set(make_flow(s));
  }
  std::shared_ptr<FrameFlow> make_flow(const Settings& s) {
    return FrameFlow::make({element(), source_, &ledger_, &statistics_}, s);
  }

  void configure() {
    const auto s = settings();
    admission_.configure(s);
    flow_->configure(s);
  }

  Status open() {
    if (auto status = config_file_.report(element()); !status) return status;
    auto chosen = take_settings(&followed_);
    threads_.claim(chosen);  // settings may have changed while in READY
    chosen.threads = threads_.chosen();
    if (const auto choice = automatic_engine(chosen))
      GST_CAT_INFO_OBJECT(category(), self(), "framework=auto selected %s",
                          choice->to_string().c_str());
    model_.start();
    if (auto status = open_model(chosen, [](const auto&) { return ok(); }); !status) return status;
    if (const auto monitor = model_.monitor()) log_confinement(*monitor, element());
    in_force_.workers = chosen.workers = model_.get()->workers();
    ledger_.reset();
    start_flow(chosen);
    engine_threads_ = chosen.threads;
    GST_CAT_INFO_OBJECT(
        category(), self(),
        "model %s: engine %s, %u workers with %d threads each (0: the engine chooses)",
        chosen.model.c_str(), model_.get()->engine().c_str(), chosen.workers, chosen.threads);
    admission_.reset(chosen);
    placeholder_.reset();
    configure();
    if (settings().model != model_.file()) replace_model();  // set while the model was opened
    return ok();
  }
  Status open_model(Settings wanted, const RunningModel::Check& check) {
    std::vector<Error> warnings;
    const auto monitor = [&] { return make_monitor(wanted, element()); };
    if (auto status = model_.open(&wanted, monitor, check, &warnings); !status) return status;
    for (const auto& warning : warnings) gst::post_warning(element(), warning);
    in_force_ = wanted;
    return ok();
  }
  // Ends all waiting, for frames in progress and for worker processes.
  void stop() {
    flow_.stop();
    model_.stop();
  }
  // Call after streaming has ended, with inactive pads.
  void close() {
    model_.close();
    flow_->close();
    forget();
    described_.reset();
    plan_.reset();
  }

  // Called when the property `model` was set. While the element runs, the new model is installed on
  // return.
  void replace_model() {
    if (!opened()) return;
    const Settings s = settings();
    if (s.is_updatable) return static_cast<void>(replace_model({}));
    gst::post_warning(
        element(),
        {.code = Code::OPTION_VALUE,
         .what = "the model takes effect at the next start, because is-updatable is false",
         .offered = "model=" + s.model,
         .needed = "is-updatable=true",
         .fix = "tensor_filter is-updatable=true model=" + s.model});
  }
  // For evt_update_model: the streaming thread does not wait until the model is open.
  void replace_model_later(const std::string& model) {
    if (model.empty()) {
      gst::post_warning(element(), {.code = Code::OPTION_VALUE,
                                    .what = "the event evt_update_model contains no model",
                                    .offered = "no text in model_files",
                                    .needed = "model_files=(string)/path/to/model"});
      return;
    }
    model_.replace_later(model, [this](const std::string& name) {
      gst::guarded<void>(element(), [&] {
        if (replace_model(name)) g_object_notify(G_OBJECT(element()), "model");
      });
    });
  }
  // Replaces the model by that of `name`, otherwise by that of the property. Afterwards the
  // property is the running model, also if the replacement failed, unless it was set again
  // meanwhile.
  bool replace_model(const std::optional<std::string>& name) {
    std::unique_lock turn(replacing_mutex_);
    const std::string shown = settings().model;
    const Status status = model_.replace([&] {
      Settings wanted = settings();
      wanted.model = name.value_or(shown);
      wanted.threads = engine_threads_;
      return wanted;
    });
    change_settings([&, running = model_.file()](Settings& s) {
      if (s.model == shown) s.model = running;
    });
    turn.unlock();
    if (!status && status.error().code != Code::CANCELLED)  // CANCELLED by stop()
      gst::post_warning(element(), status.error());
    return status.has_value();
  }

  // Called between two frames: handles changed properties and reconfigure requests from downstream.
  GstFlowReturn follow() {
    const bool must_reconfigure = gst_pad_check_reconfigure(source_);
    if (described_ && described_->lease().shared()->reloads() != described_reloads_)
      describe(described_, plan_, false);
    if (!must_reconfigure && !is_written()) return GST_FLOW_OK;
    const auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(sink_));
    if (!caps) return GST_FLOW_OK;
    const bool changed = follow_settings(
        &followed_, [&](const Settings& wanted) { return open_again(caps.get(), wanted); });
    if (model_.stopped()) return GST_FLOW_FLUSHING;
    if (!must_reconfigure && !changed) return GST_FLOW_OK;
    const Status status = negotiate(caps.get(), false);
    if (status) return GST_FLOW_OK;
    gst::post_error(element(), with_fix(status.error(), caps.get()));
    return GST_FLOW_NOT_NEGOTIATED;
  }

  // Opens the model of these properties and installs it if it fits the stream.
  Status open_again(GstCaps* caps, const Settings& properties) {
    const auto input = gst::fixed_spec_from_caps(caps);
    if (!input) return input.error();
    const bool was_async = in_force_.invoke_async;
    Settings wanted = in_force_;
    each_flagged([&](const auto& p) {
      if (p.flags.reopens) wanted.*p.field = properties.*p.field;
    });
    flow_->drain();
    Status status = open_model(wanted, [&](const OpenModel& opened) -> Status {
      const auto plan = opened.plan_for(*input);
      if (!plan) return plan.error();
      const auto out = choose_output_caps(source_, plan->output);
      return out ? ok() : Status(out.error());
    });
    // A stop is not an error of the properties: the next start opens the model.
    if (model_.stopped()) return ok();
    if (status && wanted.invoke_async != was_async)
      flow_.replace([&] {
        auto made = make_flow(wanted);
        made->configure(settings());
        return made;
      });
    return status;
  }

  // An error of these caps, with what to paste.
  Error with_fix(const Error& error, GstCaps* caps) const {
    const auto input = gst::fixed_spec_from_caps(caps);
    const auto model = opened();
    if (!input || !model) return error;
    return with_input_fix(error, *model, input->tensors, gst::find_upstream_medium(sink_));
  }

  // `begins`: caps arrived; otherwise downstream already has the current caps.
  Status negotiate(GstCaps* caps, bool begins) {
    const auto input = gst::fixed_spec_from_caps(caps);
    if (!input) return input.error();
    Status status = begin_stream(*input, begins);
    if (auto segment = status ? placeholder_.take_segment() : Ref<GstEvent>())
      flow_->send(std::move(segment));
    return placeholder_.judged(*input, std::move(status));
  }
  Status begin_stream(const FrameSpec& input, bool begins) {
    if (auto status = buffer_limit_.check_input(input); !status) return status;
    flow_->drain();
    const auto model = model_.get();
    auto plan = model->plan_for(input);
    if (!plan) return plan.error();
    plan->limit = &buffer_limit_;
    plan->medium = gst::find_upstream_medium(sink_);
    // Only sizes that are known before the first invoke.
    const FrameSpec outputs{Format::Static, known_parts(plan->model_outputs), Fraction{}};
    if (auto status = buffer_limit_.check(outputs); !status) return status;
    auto caps = choose_output_caps(source_, plan->output);
    if (!caps) return caps.error();
    const auto chosen = gst::spec_from_caps(caps->get());
    if (!chosen) return chosen.error();
    plan->output = *chosen;
    const auto begun = std::make_shared<const FilterPlan>(*plan);
    if (auto status = flow_->begin(model, begun); !status) return status;
    is_flexible_ = input.format == Format::Flexible;
    describe(model, begun, begins);
    report({plan->model_inputs, plan->model_outputs});
    const auto before = Ref<GstCaps>::adopt(gst_pad_get_current_caps(source_));
    if (!begins && before && gst_caps_is_equal(before.get(), caps->get())) return ok();
    // The peer accepts them, unless this element is shutting down or flushing.
    gst::log_output_caps(source_, caps->get());
    flow_->send(Ref<GstEvent>::adopt(gst_event_new_caps(caps->get())));
    return ok();
  }

  // Says downstream what is known of the model: before the caps of a stream, and when it changes.
  void describe(std::shared_ptr<const OpenModel> model, std::shared_ptr<const FilterPlan> plan,
                bool begins) {
    described_ = std::move(model);
    plan_ = std::move(plan);
    described_reloads_ = described_->lease().shared()->reloads();
    auto description = described_->described(*plan_);
    if (!description || (!begins && *description == description_)) return;
    description_ = *std::move(description);
    flow_->send(gst::make_model_event(description_));
  }

  GstPad* sink_ = nullptr;      // owned by the element
  bool is_flexible_ = false;    // the input; streaming thread
  GstPad* source_ = nullptr;    // owned by the element
  std::mutex replacing_mutex_;  // held while `model` is read and written; taken before other locks
  FilterThreads threads_;
  std::atomic<int> engine_threads_{0};
  Settings in_force_;  // of model_; used by the streaming thread, or while not streaming
  gst::LiveSettings<Settings> followed_;  // likewise
  gst::PropertyFile config_file_;
  RunningFlow flow_;
  FrameAdmission admission_{&statistics_};
  gst::PlaceholderWait placeholder_;
  // The model of the last model event; streaming thread.
  std::shared_ptr<const OpenModel> described_;
  std::shared_ptr<const FilterPlan> plan_;
  uint64_t described_reloads_ = 0;
  DescribedModel description_;
  RunningModel model_;  // declared last, so that its thread ends first
};

}  // namespace

bool register_tensor_filter(GstPlugin* plugin) {
  return TensorFilter::register_in(plugin);
}

}  // namespace weir
