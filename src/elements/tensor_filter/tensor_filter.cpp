// tensor_filter: a neural network as a filter of a stream of tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <atomic>
#include <cstring>
#include <memory>

#include "core/infer/module_library.hpp"
#include "elements/tensor_filter/admission.hpp"
#include "elements/tensor_filter/filter_change.hpp"
#include "elements/tensor_filter/filter_properties.hpp"
#include "elements/tensor_filter/filter_threads.hpp"
#include "elements/tensor_filter/frame_flow.hpp"
#include "elements/tensor_filter/isolated_filter.hpp"
#include "elements/tensor_filter/lag_watch.hpp"
#include "elements/tensor_filter/model_info.hpp"
#include "elements/tensor_filter/model_life.hpp"
#include "elements/tensor_filter/model_report.hpp"
#include "elements/tensor_filter/model_source.hpp"
#include "elements/tensor_filter/opened_model.hpp"
#include "elements/tensor_filter/output_caps.hpp"
#include "gstcpp/base_classes.hpp"
#include "gstcpp/latency.hpp"
#include "gstcpp/property_file.hpp"
#include "gstcpp/tensor_caps.hpp"

namespace weir {
namespace {

using gst::Ref;

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
    return model_ ? model_->engine() : framework_name(settings());
  }
  std::string sub_plugins() const {
    std::string out;
    for (const auto& name : infer::ModuleLibrary::instance().engine_names())
      out += (out.empty() ? "" : ",") + name;
    return out;
  }
  // What the user said of the tensors; else what they are.
  template <auto Own, bool Input, std::string (*Text)(const std::vector<ModelShape>&)>
  std::string reported() const {
    const Settings s = settings();
    return (s.*Own).empty() ? Text(tensors<Input>(s)) : s.*Own;
  }
  template <auto Own, bool Input>
  std::string reported_layouts() const {
    const Settings s = settings();
    return (s.*Own).empty() ? layouts_text(tensors<Input>(s)) : layouts_text(s.*Own);
  }
  template <bool Input>
  std::string reported_ranks() const {
    return ranks(tensors<Input>(settings()));
  }
  int latency() const {
    return settings().latency ? flow_.statistics().latency_us() : -1;
  }
  int throughput() const {
    return settings().throughput ? flow_.statistics().throughput_milli() : -1;
  }

  static constexpr auto kPlaying = gst::Changeable::WhilePlaying;
  static constexpr auto kProperties = std::tuple_cat(
      kFilterProperties,
      std::tuple{
          gst::Accessor{"input", &Settings::input,
                        &TensorFilter::reported<&Settings::input, true, dimensions_text>,
                        "Dimensions of the model's inputs, where the model leaves them open",
                        kPlaying},
          gst::Accessor{"inputtype", &Settings::inputtype,
                        &TensorFilter::reported<&Settings::inputtype, true, types_text>,
                        "Element types of the model's inputs", kPlaying},
          gst::Accessor{"inputname", &Settings::inputname,
                        &TensorFilter::reported<&Settings::inputname, true, names_text>,
                        "Names of the model's inputs", kPlaying},
          gst::Accessor{"inputlayout", &Settings::inputlayout,
                        &TensorFilter::reported_layouts<&Settings::inputlayout, true>,
                        "NCHW, NHWC, ANY or NONE for each input", kPlaying},
          gst::Accessor{"output", &Settings::output,
                        &TensorFilter::reported<&Settings::output, false, dimensions_text>,
                        "Dimensions of the model's outputs", kPlaying},
          gst::Accessor{"outputtype", &Settings::outputtype,
                        &TensorFilter::reported<&Settings::outputtype, false, types_text>,
                        "Element types of the model's outputs", kPlaying},
          gst::Accessor{"outputname", &Settings::outputname,
                        &TensorFilter::reported<&Settings::outputname, false, names_text>,
                        "Names of the model's outputs", kPlaying},
          gst::Accessor{"outputlayout", &Settings::outputlayout,
                        &TensorFilter::reported_layouts<&Settings::outputlayout, false>,
                        "NCHW, NHWC, ANY or NONE for each output", kPlaying},
          gst::Accessor{"framework", &Settings::framework, &TensorFilter::framework,
                        "Name of the engine; auto = found by the model file", kPlaying},
          gst::ReadOnly{"inputranks", &TensorFilter::reported_ranks<true>,
                        "Ranks of the model's inputs"},
          gst::ReadOnly{"outputranks", &TensorFilter::reported_ranks<false>,
                        "Ranks of the model's outputs"},
          gst::ReadOnly{"sub-plugins", &TensorFilter::sub_plugins, "Engines that are installed"},
          gst::Gauge{"latency", &Settings::latency, &TensorFilter::latency,
                     "Write 1 to enable; reads as the mean of the last 10 invokes in microseconds",
                     0, 1},
          gst::Gauge{"throughput", &Settings::throughput, &TensorFilter::throughput,
                     "Write 1 to enable; reads as outputs per second x 1000", 0, 1},
      });

  void constructed() {
    sink_ = add_pad("sink");
    source_ = add_pad("src");
    flow_.set_element(element(), source_);
    lag_.set_element(element(), sink_);
    admission_.set_pad(sink_);
    gst_pad_set_chain_function(sink_, (chain<&TensorFilter::on_buffer>));
    gst_pad_set_event_function(sink_, (pad_event<&TensorFilter::on_sink_event>));
    gst_pad_set_query_function(sink_, (pad_query<&TensorFilter::on_sink_query>));
    gst_pad_set_event_function(source_, (pad_event<&TensorFilter::on_source_event>));
    gst_pad_set_query_function(source_, (pad_query<&TensorFilter::on_source_query>));
  }

  Status check_change(const char*, const Settings& wanted) const {
    return check_lists(wanted);
  }
  static bool is_followed(const char* name) {
    return opens_the_model(name);
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
      const Status status = open();
      if (!status) {
        gst::post_error(element(), status.error());
        return GST_STATE_CHANGE_FAILURE;
      }
      flow_.resume();
    }
    if (change == GST_STATE_CHANGE_PAUSED_TO_READY) stop();
    const auto result = parent_class()->change_state(element(), change);
    if (change == GST_STATE_CHANGE_PAUSED_TO_READY) close();
    if (change == GST_STATE_CHANGE_READY_TO_NULL) threads_.release();
    return result;
  }

  GstFlowReturn on_buffer(GstBuffer* raw) {
    auto buffer = Ref<GstBuffer>::adopt(raw);
    ledger_.received();
    lag_.see(buffer.get());
    life_.touch();
    if (const auto flow = follow(); flow != GST_FLOW_OK) {
      ledger_.dropped(DropReason::Error);
      return flow;
    }
    if (const auto reason = admission_.refuses(buffer.get())) {
      ledger_.dropped(*reason);
      return GST_FLOW_OK;
    }
    const GstClockTime deadline = admission_.deadline_of(buffer.get());
    const auto flow = flow_.take(std::move(buffer), deadline);
    life_.touch();
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
        life_.touch();  // it may have woken the model
        if (!status) gst::post_error(element(), status.error());
        return status.has_value();
      }
      case GST_EVENT_SEGMENT:
        admission_.set_segment(event);
        lag_.set_segment(event);
        break;
      case GST_EVENT_FLUSH_START:
        flow_.flush();
        return gst_pad_event_default(pad, GST_OBJECT_CAST(self()), event);
      case GST_EVENT_FLUSH_STOP:
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
      default:
        break;
    }
    if (gst_event_type_get_flags(GST_EVENT_TYPE(event)) & GST_EVENT_TYPE_SERIALIZED)
      return flow_.send(Ref<GstEvent>::adopt(event));
    return gst_pad_event_default(pad, GST_OBJECT_CAST(self()), event);
  }

  gboolean on_source_event(GstPad* pad, GstEvent* event) {
    if (GST_EVENT_TYPE(event) == GST_EVENT_QOS &&
        admission_.hear(event) == Admission::Heard::Throttle) {
      gst_event_unref(event);
      change_settings([](Settings& s) { s.latency = 1; });
      return TRUE;
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
    if (GST_QUERY_TYPE(query) == GST_QUERY_DRAIN) flow_.drain();
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
    if (GST_QUERY_TYPE(query) == GST_QUERY_LATENCY) {
      const auto delay = flow_.delay();
      const GstClockTime own = flow_.reports_latency() ? flow_.answer_latency() : 0;
      return gst::answer_latency(sink_, query, own + delay.least, own + delay.most);
    }
    return gst_pad_query_default(pad, GST_OBJECT_CAST(self()), query);
  }

  void add_stats(GstStructure* stats) const {
    flow_.add_stats(stats);
    gst_structure_set(stats, "threads", G_TYPE_INT, engine_threads_.load(), nullptr);
    std::lock_guard lock(model_mutex_);
    if (monitor_) add_worker_stats(*monitor_, stats);
    if (model_) model_->add_stats(stats);
  }

  Settings settings_;
  Ledger ledger_;
  BufferLimit buffer_limit_{kInfo.factory_name};

 private:
  GstPad* add_pad(const char* name) {
    auto* klass = GST_ELEMENT_GET_CLASS(element());
    GstPad* pad = gst_pad_new_from_template(gst_element_class_get_pad_template(klass, name), name);
    gst_element_add_pad(element(), pad);
    return pad;
  }

  void configure() {
    const auto s = settings();
    admission_.configure(s);
    flow_.configure(s);
  }

  Status open() {
    if (auto status = config_file_.report(element()); !status) return status;
    auto chosen = take_settings(&followed_);
    threads_.claim(chosen);  // settings may have changed in READY
    chosen.threads = threads_.chosen();
    if (const auto choice = automatic_engine(chosen))
      GST_DEBUG_OBJECT(self(), "framework=auto is %s", choice->words().c_str());
    auto monitor = make_monitor(chosen, element());
    std::vector<Error> warnings;
    auto opened = OpenedModel::open(chosen, monitor, &warnings);
    if (!opened) return opened.error();
    for (const auto& warning : warnings) gst::post_warning(element(), warning);
    if (monitor) log_confinement(*monitor, element());
    std::lock_guard lock(model_mutex_);
    model_ = *std::move(opened);
    monitor_ = std::move(monitor);
    model_text_ = chosen.model;
    in_force_ = chosen;
    life_.start(model_, chosen);
    ledger_.reset();
    flow_.open(chosen);
    lag_.open(chosen.when_busy == WhenBusyChoice::Unset);
    engine_threads_ = chosen.threads;
    GST_INFO_OBJECT(self(), "%u workers, %d threads of the engine each (0 = its own choice)",
                    chosen.workers, chosen.threads);
    admission_.reset();
    configure();
    return ok();
  }
  // Nobody waits for a frame in work any more.
  void stop() {
    flow_.stop();
    std::lock_guard lock(model_mutex_);
    if (monitor_) monitor_->stop();
  }
  // Streaming has ended: the pads are inactive.
  void close() {
    life_.stop();
    flow_.close();
    report_.forget();
    std::lock_guard lock(model_mutex_);
    model_.reset();
  }

  // The property `model` was set: while the element runs, that model is there before this returns.
  void replace_model() {
    Settings wanted = settings();
    wanted.threads = engine_threads_;
    {
      std::lock_guard lock(model_mutex_);
      if (!model_) return;
    }
    if (wanted.is_updatable) {
      after_replacement(life_.replace(wanted), wanted.model);
      return;
    }
    gst::post_warning(element(), {Code::OPTION_VALUE,
                                  "the model is used from the next start on: is-updatable is false",
                                  "model=" + wanted.model, "is-updatable=true", "",
                                  "tensor_filter is-updatable=true model=" + wanted.model});
  }
  // An event asks for it: the streaming thread does not wait until the model is open.
  void replace_model_later(const std::string& model) {
    if (model.empty()) {
      gst::post_warning(element(),
                        {Code::OPTION_VALUE, "evt_update_model names no model",
                         "no text in model_files", "model_files=(string)/path/to/model", "", ""});
      return;
    }
    Settings wanted = settings();
    wanted.model = model;
    wanted.threads = engine_threads_;
    life_.replace_later(std::move(wanted), [this](const auto& replace, const std::string& name) {
      gst::guarded<void>(element(), [&] {
        const Status status = replace();
        after_replacement(status, name);
        if (status) g_object_notify(G_OBJECT(element()), "model");
      });
    });
  }
  // The property says which model runs, also when another did not fit.
  void after_replacement(const Status& status, const std::string& wanted) {
    std::string running;
    {
      std::lock_guard lock(model_mutex_);
      if (status) model_text_ = wanted;
      running = model_text_;
    }
    change_settings([&](Settings& s) { s.model = running; });
    if (!status && status.error().code != Code::CANCELLED)  // cancelled by a stop
      gst::post_warning(element(), status.error());
  }

  template <bool Input>
  std::vector<ModelShape> tensors(const Settings& s) const {
    auto known = report_.of_stream();
    if (!known) {
      std::unique_lock lock(model_mutex_);
      if (model_) return Input ? model_->inputs() : model_->outputs();
      lock.unlock();
      known = report_.of_settings(s);
    }
    if (!known) return {};
    return Input ? known->inputs : known->outputs;
  }

  // Between two frames: properties changed, or downstream asks for other caps.
  GstFlowReturn follow() {
    const bool asked = gst_pad_check_reconfigure(source_);
    if (!asked && !is_written()) return GST_FLOW_OK;
    const auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(sink_));
    if (!caps) return GST_FLOW_OK;
    const bool changed = follow_settings(
        &followed_, [&](const Settings& wanted) { return open_again(caps.get(), wanted); });
    if (!asked && !changed) return GST_FLOW_OK;
    const Status status = negotiate(caps.get(), false);
    if (status) return GST_FLOW_OK;
    gst::post_error(element(), status.error());
    return GST_FLOW_NOT_NEGOTIATED;
  }

  // The model of these properties in place of the one that runs, where it fits the stream.
  Status open_again(GstCaps* caps, const Settings& properties) {
    const auto input = gst::fixed_spec_from_caps(caps);
    if (!input) return input.error();
    Settings wanted = in_force_;
    gst::each_setting(kProperties, [&](const auto& p, size_t) {
      if (opens_the_model(p.name)) wanted.*p.field = properties.*p.field;
    });
    {
      std::lock_guard lock(model_mutex_);
      wanted.model = model_text_;
    }
    flow_.drain();
    auto monitor = make_monitor(wanted, element());
    std::vector<Error> warnings;
    auto opened = OpenedModel::open(wanted, monitor, &warnings);
    if (!opened) return opened.error();
    const auto plan = (*opened)->plan_for(*input);
    if (!plan) return plan.error();
    if (const auto out = choose_output_caps(source_, plan->output); !out) return out.error();
    for (const auto& warning : warnings) gst::post_warning(element(), warning);
    life_.stop();
    std::lock_guard lock(model_mutex_);
    model_ = *std::move(opened);
    monitor_ = std::move(monitor);
    in_force_ = wanted;
    life_.start(model_, wanted);
    return ok();
  }

  // `begins`: caps came; else downstream knows the ones that it has.
  Status negotiate(GstCaps* input_caps, bool begins) {
    const auto input = gst::fixed_spec_from_caps(input_caps);
    if (!input) return input.error();
    if (auto status = buffer_limit_.check_input(*input); !status) return status;
    flow_.drain();
    auto plan = model_->plan_for(*input);
    if (!plan) return plan.error();
    plan->limit = &buffer_limit_;
    if (auto status = check_outputs(*plan); !status) return status;
    auto caps = choose_output_caps(source_, plan->output);
    if (!caps) return caps.error();
    const auto chosen = gst::spec_from_caps(caps->get());
    if (!chosen) return chosen.error();
    plan->output = *chosen;
    if (auto status = flow_.begin(model_, *plan); !status) return status;
    report_.negotiated({plan->model_inputs, plan->model_outputs});
    const auto before = Ref<GstCaps>::adopt(gst_pad_get_current_caps(source_));
    if (!begins && before && gst_caps_is_equal(before.get(), caps->get())) return ok();
    // They go through, unless this element is being shut or flushed.
    flow_.send(Ref<GstEvent>::adopt(gst_event_new_caps(caps->get())));
    return ok();
  }

  // Of the sizes that are known before the first invoke.
  Status check_outputs(const FilterPlan& plan) const {
    return buffer_limit_.check(
        FrameSpec{Format::Static, known_parts(plan.model_outputs), Fraction{}});
  }

  gboolean answer_caps(GstPad* pad, GstQuery* query) {
    GstCaps* filter = nullptr;
    gst_query_parse_caps(query, &filter);
    std::lock_guard lock(model_mutex_);
    gst_query_set_caps_result(query, offered_caps(pad, model_.get(), filter).get());
    return TRUE;
  }

  GstPad* sink_ = nullptr;          // owned by the element
  GstPad* source_ = nullptr;        // owned by the element
  mutable std::mutex model_mutex_;  // guards model_ against queries while it opens and closes
  std::shared_ptr<const OpenedModel> model_;
  std::shared_ptr<isolate::Monitor> monitor_;  // of the last worker processes; by model_mutex_ too
  FilterThreads threads_;
  std::atomic<int> engine_threads_{0};
  mutable ModelReport report_;
  Settings in_force_;  // of model_; streaming thread, and while nothing streams
  gst::FollowedSettings<Settings> followed_;  // likewise
  std::string model_text_;                    // what `model` says of it; guarded by model_mutex_
  gst::PropertyFile config_file_;
  LagWatch lag_;
  FrameFlow flow_{&ledger_};
  Admission admission_{&flow_.statistics()};
  ModelLife life_;
};

}  // namespace

bool register_tensor_filter(GstPlugin* plugin) {
  return TensorFilter::register_in(plugin);
}

}  // namespace weir
