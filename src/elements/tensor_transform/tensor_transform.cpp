// tensor_transform: changes the values, the type or the order of the tensors of a stream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <atomic>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "elements/tensor_transform/frame_transformer.hpp"
#include "elements/tensor_transform/transform_options.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/counted_transform.hpp"
#include "gstcpp/element/derived_setting.hpp"
#include "gstcpp/element/described_caps.hpp"
#include "gstcpp/element/model_event.hpp"
#include "gstcpp/pads/early_events.hpp"

namespace weir::gst {
template <>
struct EnumType<transform::Mode> {
  static GType type() {
    static const GEnumValue values[] = {{0, "Move one dimension to another place", "dimchg"},
                                        {1, "Change the element type", "typecast"},
                                        {2, "Add, multiply and divide", "arithmetic"},
                                        {3, "Permute the dimensions", "transpose"},
                                        {4, "Standardise by mean and deviation", "stand"},
                                        {5, "Limit values to a range", "clamp"},
                                        {6, "Add zeros around", "padding"},
                                        {-1, "Not set", "unknown"},
                                        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirTransformMode", values);
    return t;
  }
};
}  // namespace weir::gst

namespace weir {
namespace {

using gst::Ref;

class TensorTransform : public gst::CountedTransform<TensorTransform> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirTensorTransform", "tensor_transform",
                                          "TensorTransform", "Filter/Tensor",
                                          "Transforms the tensors of a stream: type, arithmetic, "
                                          "order of dimensions"};
#define WEIR_TRANSFORM_CAPS WEIR_CAPS_TENSOR "; " WEIR_CAPS_TENSORS("{ static, flexible }")
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_TRANSFORM_CAPS)),
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_TRANSFORM_CAPS)),
  };

  using Settings = TransformSettings;
  using Options = TransformOptions;
  uint32_t transpose_rank_limit() const {
    return kRankLimit;
  }
  static constexpr auto kPlaying = gst::Changeable::WhilePlaying;
  static constexpr std::tuple kProperties{
      gst::Property{"silent", &Settings::silent, "Accepted for compatibility; has no effect",
                    gst::Changeable::WhilePlaying},
      gst::Property{"mode", &Settings::mode, "What to do with each tensor", kPlaying},
      gst::Property{"option", &Settings::option, "Parameters of the mode, in its own syntax",
                    kPlaying},
      gst::Property{"acceleration", &Settings::acceleration,
                    "Use SIMD; the results are the same without it", kPlaying},
      gst::Property{"apply", &Settings::apply,
                    "Comma list of the tensors to transform, by index; empty = all", kPlaying},
      gst::ReadOnly{"transpose-rank-limit", &TensorTransform::transpose_rank_limit,
                    "Highest rank that transpose accepts"},
  };

  Status start() {
    ledger_.reset();
    fused_frames_ = deferred_frames_ = pool_allocated_ = 0;
    counts_->divisions_by_zero = 0;
    waiting_ = false;
    const Settings s = take_settings(&followed_);
    if (is_set(s)) return load();
    // Both may be set as late as the first frame.
    return s.refused ? Status(*s.refused) : ok();
  }

  bool stop() {
    transformer_.reset();
    early_.clear();
    set_good({});
    return true;
  }

  void property_changed(const char* name) {
    // While frames flow, an option may be set before its mode.
    if (std::strcmp(name, "option") == 0 && GST_STATE(element()) < GST_STATE_PAUSED) {
      Status taken = ok();
      change_settings([&](Settings& s) { taken = refuse_unfit_option(&s); });
      if (!taken) gst::post_warning(element(), taken.error());
    }
    options_.reset();
  }
  Status check_change(const char* name, const Settings& wanted) const {
    return check_option_change(name, wanted);
  }

  // GstBaseTransform passes no filter for the caps of a stream, and compares the result with the
  // peer's caps as text.
  GstCaps* transform_caps(GstPadDirection direction, GstCaps* caps, GstCaps* filter) {
    Ref<GstCaps> peer;
    if (!filter && direction == GST_PAD_SINK && gst_caps_is_fixed(caps))
      peer =
          Ref<GstCaps>::adopt(gst_pad_peer_query_caps(GST_BASE_TRANSFORM_SRC_PAD(self()), nullptr));
    auto result = converted(direction, caps, filter ? filter : peer.get());
    if (!filter) return result.release();
    return gst_caps_intersect_full(result.get(), filter, GST_CAPS_INTERSECT_FIRST);
  }

  gboolean query(GstPadDirection direction, GstQuery* query) {
    if (GST_QUERY_TYPE(query) == GST_QUERY_ACCEPT_CAPS && direction == GST_PAD_SINK) {
      // Accepts invalid caps: sink_event can post why they fail.
      GstCaps* caps = nullptr;
      gst_query_parse_accept_caps(query, &caps);
      const auto ours =
          Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(GST_BASE_TRANSFORM_SINK_PAD(self())));
      gst_query_set_accept_caps_result(query, gst_caps_can_intersect(caps, ours.get()));
      return TRUE;
    }
    if (GST_QUERY_TYPE(query) != GST_QUERY_CAPS)
      return parent_class()->query(self(), direction, query);
    GstCaps* filter = nullptr;
    gst_query_parse_caps(query, &filter);
    const auto described = gst::static_where_described(filter);
    gst_query_set_caps_result(query, transform_template(direction, described.get()).get());
    return TRUE;
  }

  gboolean sink_event(GstEvent* event) {
    if (gst::is_model_event(event)) {  // the output has other tensors
      gst_event_unref(event);
      return TRUE;
    }
    if (hold(event)) return TRUE;
    if (GST_EVENT_TYPE(event) != GST_EVENT_CAPS) return parent_class()->sink_event(self(), event);
    GstCaps* caps = nullptr;
    gst_event_parse_caps(event, &caps);
    const auto held = Ref<GstCaps>::share(caps);
    reported_ = false;
    if (parent_class()->sink_event(self(), event)) return replay(), TRUE;
    if (!reported_) report_refusal(held.get());
    return FALSE;
  }

  GstFlowReturn submit_input_buffer(gboolean discont, GstBuffer* buffer) {
    if (waiting_ && !begin()) {
      ledger_.received();
      gst_buffer_unref(buffer);
      ledger_.dropped(DropReason::Error);
      return GST_FLOW_NOT_NEGOTIATED;
    }
    if (transformer_ && !waiting_ && is_written()) follow_properties();
    if (is_flexible_ && gst::has_empty_tensor(buffer)) return skip(Ref<GstBuffer>::adopt(buffer));
    return gst::CountedTransform<TensorTransform>::submit_input_buffer(discont, buffer);
  }

  // Sends a GAP event in place of a frame without elements.
  GstFlowReturn skip(const Ref<GstBuffer>& buffer) {
    ledger_.received();
    ledger_.dropped(DropReason::Policy);
    if (auto gap = gst::gap_like(buffer.get()))
      gst_pad_push_event(GST_BASE_TRANSFORM_SRC_PAD(self()), gap.release());
    return GST_FLOW_OK;
  }

  Status set_caps(GstCaps* in, GstCaps* out) {
    Status status = configure(in, out);
    reported_ = !status;
    return status;
  }

  Status configure(GstCaps* in, GstCaps* out) {
    if (auto status = load(); !status) return status;
    const auto input = gst::fixed_spec_from_caps(in);
    if (!input) return input.error();
    const auto output = gst::fixed_spec_from_caps(out);
    if (!output) return output.error();
    if (input->format == Format::Static) {
      auto computed = transformed((*loaded_)->operation, (*loaded_)->choice, input->tensors);
      if (!computed) return computed.error();
      if (output->format == Format::Static)
        if (auto status = check_output(*output, *computed); !status) return status;
    }
    is_flexible_ = input->format == Format::Flexible;
    return transformer_->configure(*input, *output);
  }

  // Offers to do the work of the transform before this one: of two chained ones, the first defers
  // its work to the second if that offers it.
  gboolean propose_allocation(GstQuery* decide_query, GstQuery* query) {
    const gboolean done = parent_class()->propose_allocation(self(), decide_query, query);
    if (done && transformer_) gst::offer(query, transformer_->allocation());
    if (done && transformer_ && (transformer_->can_fuse() || transformer_->takes_views()))
      gst::offer_deferral(query, GST_BASE_TRANSFORM_SINK_PAD(self()));
    return done;
  }
  gboolean decide_allocation(GstQuery* query) {
    if (transformer_)
      if (const Status status =
              transformer_->allocate_as(gst::parse_allocation(query, transformer_->allocation()));
          !status)
        return gst::post_error(element(), status.error()), FALSE;
    if (transformer_ && transformer_->can_fuse())
      transformer_->defer(gst::deferral_is_offered(query, GST_BASE_TRANSFORM_SRC_PAD(self())));
    return parent_class()->decide_allocation(self(), query);
  }

  GstFlowReturn prepare_output_buffer(GstBuffer* in, GstBuffer** out) {
    if (!transformer_) {
      ledger_.dropped(DropReason::Error);
      return GST_FLOW_NOT_NEGOTIATED;
    }
    auto buffer = transformer_->output_for(in);
    if (!buffer) return failed(buffer.error());
    if (buffer->get() != in) copy_metadata(in, buffer->get());
    // GstBaseTransform compares only the pointers and takes no second reference to the input.
    *out = buffer->get() == in ? in : buffer->release();
    return GST_FLOW_OK;
  }

  GstFlowReturn transform(GstBuffer* in, GstBuffer* out) {
    const auto work = transformer_->run(in, out, &ledger_);
    if (!work) return failed(work.error());
    pool_allocated_ = transformer_->pool_allocated();
    fused_frames_ += work->fused;
    deferred_frames_ += work->deferred;
    ledger_.consumed_and_pushed();
    return GST_FLOW_OK;
  }

  void add_stats(GstStructure* stats) const {
    const uint64_t late = counts_->divisions_by_zero;
    gst_structure_set(stats, "fused-frames", G_TYPE_UINT64, fused_frames_.load(), "deferred-frames",
                      G_TYPE_UINT64, deferred_frames_.load(), "integer-divisions-by-zero",
                      G_TYPE_UINT64, ledger_.snapshot().integer_divisions_by_zero + late,
                      "pool-allocated", G_TYPE_UINT64, pool_allocated_.load(), nullptr);
  }

  Settings settings_;
  BufferLimit buffer_limit_{kInfo.factory_name};

 private:
  // Converts `caps` on the pad of `direction` to caps of the other pad, with dimensions spelled as
  // in `spelling` (may be null).
  Ref<GstCaps> converted(GstPadDirection direction, GstCaps* caps, const GstCaps* spelling) {
    const auto options = effective();
    return converted(direction, caps, spelling, *options ? &**options : nullptr);
  }
  Ref<GstCaps> converted(GstPadDirection direction, GstCaps* caps, const GstCaps* spelling,
                         const Options* options) {
    GstPad* other = direction == GST_PAD_SINK ? GST_BASE_TRANSFORM_SRC_PAD(self())
                                              : GST_BASE_TRANSFORM_SINK_PAD(self());
    auto result = Ref<GstCaps>::adopt(gst_caps_new_empty());
    for (guint i = 0; i < gst_caps_get_size(caps); ++i) {
      const auto one = Ref<GstCaps>::adopt(gst_caps_copy_nth(caps, i));
      auto spec = gst::spec_from_caps(one.get());
      if (!spec) continue;
      if (options)
        convert(direction, *options, &*spec);
      else
        for (auto& t : spec->tensors) t = TensorSpec{};
      auto candidates = gst::possible_caps(other, *spec, spelling);
      result = Ref<GstCaps>::adopt(gst_caps_merge(result.release(), candidates.release()));
    }
    return result;
  }

  // The caps of a pad. GstBaseTransform would prefer caps that need no change: with a type change
  // these are flexible ones, and a static stream would become flexible.
  Ref<GstCaps> transform_template(GstPadDirection direction, GstCaps* filter) {
    GstPad *pad = GST_BASE_TRANSFORM_SINK_PAD(self()), *other = GST_BASE_TRANSFORM_SRC_PAD(self());
    if (direction == GST_PAD_SRC) std::swap(pad, other);
    const auto get_template = [](GstPad* of) {
      return Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(of));
    };
    const auto meet = [](const Ref<GstCaps>& a, const Ref<GstCaps>& b) {
      return Ref<GstCaps>::adopt(
          gst_caps_intersect_full(a.get(), b.get(), GST_CAPS_INTERSECT_FIRST));
    };
    Ref<GstCaps> wanted;
    if (filter) {
      const auto here = meet(Ref<GstCaps>::share(filter), get_template(pad));
      wanted = gst::without_dimensions(
          meet(converted(direction, here.get(), nullptr), get_template(other)));
    }
    const auto there = meet(Ref<GstCaps>::adopt(gst_pad_peer_query_caps(other, wanted.get())),
                            get_template(other));
    auto caps =
        meet(Ref<GstCaps>::adopt(transform_caps(GST_PAD_DIRECTION(other), there.get(), filter)),
             get_template(pad));
    if (filter) return caps;
    // A capsfilter compares this result as text. Its spelling of the dimensions is known only from
    // its caps event, which is compared by dimensions.
    auto open = gst::without_dimensions(Ref<GstCaps>::adopt(gst_caps_copy(caps.get())));
    return Ref<GstCaps>::adopt(gst_caps_merge(caps.release(), open.release()));
  }

  // Posts the reason when GstBaseTransform rejected caps without an error.
  void report_refusal(GstCaps* caps) {
    const auto input = gst::fixed_spec_from_caps(caps);
    if (!input) return gst::post_error(element(), input.error());
    const auto options = effective();
    if (input->format == Format::Static && *options)
      if (const auto computed =
              transformed((*options)->operation, (*options)->choice, input->tensors);
          !computed)
        return gst::post_error(element(), computed.error());
    const auto ours = Ref<GstCaps>::adopt(transform_caps(GST_PAD_SINK, caps, nullptr));
    const Status status =
        gst::check_downstream(GST_BASE_TRANSFORM_SRC_PAD(self()), ours.get(),
                              "tensor_transform mode=typecast option=TYPE changes the type");
    if (!status) gst::post_error(element(), status.error());
  }

  // Until mode and option are set, holds caps and the events after them.
  bool hold(GstEvent* event) {
    const auto type = GST_EVENT_TYPE(event);
    if (type == GST_EVENT_CAPS) {
      waiting_ = !transformer_ && !is_set(settings());
      if (waiting_) gst_event_unref(event);  // they stay on the sink pad
      return waiting_;
    }
    // A restarted stream precedes its caps.
    if (type == GST_EVENT_FLUSH_STOP || type == GST_EVENT_STREAM_START) {
      early_.clear();
      return false;
    }
    const bool serialized = (gst_event_type_get_flags(type) & GST_EVENT_TYPE_SERIALIZED) != 0;
    if (!serialized || !waiting_) return false;  // others come on any thread
    if (type == GST_EVENT_EOS) {
      replay();
      return false;
    }
    early_.push(Ref<GstEvent>::adopt(event));
    return true;
  }
  void replay() {
    for (auto& event : early_.take()) parent_class()->sink_event(self(), event.release());
  }
  // Called at the first frame.
  bool begin() {
    const auto options = current();
    if (!*options) return gst::post_error(element(), options->error()), false;
    const auto caps =
        Ref<GstCaps>::adopt(gst_pad_get_current_caps(GST_BASE_TRANSFORM_SINK_PAD(self())));
    waiting_ = false;
    return caps && sink_event(gst_event_new_caps(caps.get()));
  }

  // Called between two frames: applies new options if the stream can continue with them.
  void follow_properties() {
    const auto judge = [this](const Settings& wanted) -> Status {
      const auto options = parse_options(wanted);
      return options ? can_follow(*options) : Status(options.error());
    };
    const bool other = follow_settings(&followed_, judge);
    options_.reset();  // the properties now hold the settings in effect
    if (!other) return;
    GstPad *sink = GST_BASE_TRANSFORM_SINK_PAD(self()),
           *source = GST_BASE_TRANSFORM_SRC_PAD(self());
    const auto in = Ref<GstCaps>::adopt(gst_pad_get_current_caps(sink));
    const auto out = Ref<GstCaps>::adopt(gst_pad_get_current_caps(source));
    // GstBaseTransform does not set unchanged caps again; changed ones are set with the frame.
    if (in && out) static_cast<void>(configure(in.get(), out.get()));
    gst_base_transform_reconfigure_src(self());
    gst_base_transform_reconfigure_sink(self());
  }
  Status can_follow(const Options& options) {
    const auto in =
        Ref<GstCaps>::adopt(gst_pad_get_current_caps(GST_BASE_TRANSFORM_SINK_PAD(self())));
    const auto input = gst::fixed_spec_from_caps(in.get());
    if (!input) return input.error();
    FrameSpec output = *input;
    if (input->format == Format::Static) {
      auto computed = transformed(options.operation, options.choice, input->tensors);
      if (!computed) return computed.error();
      output.tensors = *std::move(computed);
    }
    FrameTransformer trial(options.operation, options.choice, options.settings.acceleration,
                           counts_, buffer_limit_);
    if (auto status = trial.configure(*input, output); !status) return status;
    GstPad* pad = GST_BASE_TRANSFORM_SRC_PAD(self());
    const auto theirs = Ref<GstCaps>::adopt(gst_pad_peer_query_caps(pad, nullptr));
    const auto ours = converted(GST_PAD_SINK, in.get(), theirs.get(), &options);
    return gst::check_downstream(pad, ours.get(),
                                 "a mode and an option whose output downstream accepts");
  }
  // Parsed from the properties.
  using SharedOptions = std::shared_ptr<const Result<Options>>;
  // Any thread.
  SharedOptions current() const {
    return options_.get([this] { return parse_options(settings()); });
  }

  // The same, or the last valid ones. Any thread.
  SharedOptions effective() const {
    auto options = current();
    if (*options) return options;
    std::lock_guard lock(good_mutex_);
    return good_ ? good_ : options;
  }
  void set_good(SharedOptions options) {
    std::lock_guard lock(good_mutex_);
    good_ = std::move(options);
  }

  // Makes a transformer for the current options.
  Status load() {
    auto options = effective();
    if (!*options) return options->error();
    if (transformer_ && loaded_ == options) return ok();
    const auto& [settings, operation, choice] = **options;
    transformer_ = std::make_unique<FrameTransformer>(operation, choice, settings.acceleration,
                                                      counts_, buffer_limit_);
    set_good(options);
    followed_.in_force = settings;
    loaded_ = std::move(options);
    return ok();
  }

  static void convert(GstPadDirection direction, const Options& options, FrameSpec* spec) {
    const auto& operation = options.operation;
    for (size_t i = 0; i < spec->tensors.size(); ++i) {
      auto& t = spec->tensors[i];
      if (!chosen(options.choice, i)) continue;
      const transform::TemplateSpec known{t.type, t.shape};
      const std::optional<transform::TemplateSpec> other =
          direction == GST_PAD_SRC ? transform::input_candidates(operation, known)
                                   : transform::output_candidates(operation, known);
      t = other ? TensorSpec{other->type, other->shape, ""} : TensorSpec{};
    }
    if (direction == GST_PAD_SRC && spec->format == Format::Flexible) {
      spec->format = Format::End;  // a static input with added headers is possible too
      spec->tensors.clear();
    }
  }

  Status check_output(const FrameSpec& output, const std::vector<TensorSpec>& computed) const {
    const std::string difference = first_difference(output.tensors, computed);
    if (difference.empty()) return ok();
    FrameSpec needed = output;
    needed.tensors = computed;
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the caps downstream of tensor_transform do not match its output",
                 .offered = output.to_string(),
                 .needed = needed.to_string(),
                 .difference = difference,
                 .fix = gst::caps_to_paste(needed)};
  }

  gst::DerivedSetting<Result<Options>> options_;
  mutable std::mutex good_mutex_;         // guards good_
  SharedOptions good_;                    // loaded_, for queries
  gst::LiveSettings<Settings> followed_;  // the settings of loaded_; streaming thread
  // Streaming thread: caps arrived without a mode; the events after them.
  bool waiting_ = false;
  bool is_flexible_ = false;  // the input; streaming thread
  gst::EarlyEvents early_;
  bool reported_ = false;  // set_caps() posted its error; streaming thread
  SharedOptions loaded_;   // valid options of transformer_; both streaming thread only
  std::unique_ptr<FrameTransformer> transformer_;
  const std::shared_ptr<gst::DeferredCounts> counts_ = std::make_shared<gst::DeferredCounts>();
  std::atomic<uint64_t> fused_frames_{0}, deferred_frames_{0}, pool_allocated_{0};
};

}  // namespace

bool register_tensor_transform(GstPlugin* plugin) {
  return TensorTransform::register_in(plugin);
}

}  // namespace weir
