// tensor_if: sends each frame to one of two source pads, depending on its values.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstring>

#include "core/split/pick_list.hpp"
#include "core/tensor/tensor_header.hpp"
#include "elements/tensor_if/if_settings.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/memory_part.hpp"
#include "gstcpp/buffer/module_values.hpp"
#include "gstcpp/pads/one_to_many.hpp"

namespace weir {
namespace {

using condition::Behaviour;
using gst::Ref;

#define WEIR_IF_CAPS                                                                     \
  WEIR_CAPS_TENSOR                                                                       \
  "; other/tensors, format=(string)static, num_tensors=(int)[ 1, 256 ], " WEIR_CAPS_RATE \
  "; " WEIR_CAPS_TENSORS("flexible")

class TensorIf : public gst::OneToMany<TensorIf> {
 public:
  static constexpr gst::ElementInfo kInfo{
      "WeirTensorIf", "tensor_if", "TensorIf", "Filter/Tensor",
      "Sends each frame to one of two pads, depending on its values"};
  static constexpr const char* kSourceTemplate = "src";
  static constexpr bool kPassesTensors = true;
  static constexpr bool kKeepsPads = true;  // a pipeline from gst_parse_launch() can be restarted
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS, GST_STATIC_CAPS(WEIR_IF_CAPS)),
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_SOMETIMES, GST_STATIC_CAPS(WEIR_IF_CAPS)),
  };

  using Settings = IfSettings;
  static constexpr auto kPlaying = gst::Changeable::WhilePlaying;
  static constexpr std::tuple kProperties{
      gst::Property{"silent", &Settings::silent, "Accepted for compatibility; has no effect",
                    gst::Changeable::WhilePlaying},
      gst::Property{"compared-value", &Settings::compared_value,
                    "What is compared: an element, the average of a tensor, or the result of a "
                    "registered function",
                    kPlaying},
      gst::Property{"compared-value-option", &Settings::compared_value_option,
                    "A_VALUE: coordinate and tensor, as in 0:1:0:0,0; TENSOR_AVERAGE_VALUE: the "
                    "tensor; CUSTOM: the function's name",
                    kPlaying},
      gst::Property{"operator", &Settings::op, "Comparison with supplied-value", kPlaying},
      gst::Property{"supplied-value", &Settings::supplied_value,
                    "A number, or two separated by ',' for a range", kPlaying},
      gst::Property{"then", &Settings::then_behaviour,
                    "What src_0 outputs when the condition is true", kPlaying},
      gst::Property{"then-option", &Settings::then_option,
                    "TENSORPICK: comma list of tensor indices", kPlaying},
      gst::Property{"else", &Settings::else_behaviour,
                    "What src_1 outputs when the condition is false", kPlaying},
      gst::Property{"else-option", &Settings::else_option,
                    "TENSORPICK: comma list of tensor indices", kPlaying},
  };

  void property_changed(const char* name) {
    if (std::strncmp(name, "compared-value", std::strlen("compared-value")) != 0) return;
    const Settings s = settings();
    if (s.compared_value == condition::ComparedValue::Custom && !s.compared_value_option.empty() &&
        !condition::is_custom_condition(s.compared_value_option))
      gst::post_warning(element(), condition::unknown_condition(s.compared_value_option));
  }

  Status prepare(const Settings& settings) { return check_texts(settings); }

  Status configure(const FrameSpec& spec) {
    spec_ = spec;
    const Settings s = take_settings(&followed_);
    plan_.reset();
    // The first frame gets the error and not the caps, which may be those of a placeholder.
    missing_ = missing_setting(s);
    if (missing_) return ok();
    auto plan = plan_if(s, spec);
    if (plan)
      use(*std::move(plan));
    else
      missing_ = plan.error();
    return ok();
  }

  Result<gst::Routed> route(Ref<GstBuffer> buffer) {
    if (is_written()) follow_properties();
    if (!plan_) return *missing_;
    if (auto status = layout_.locate(buffer.get(), spec_); !status) return status.error();
    const auto holds = decide(buffer.get());
    if (!holds) return holds.error();
    const size_t way = holds->value_or(false) ? 0 : 1;
    const IfBranch& branch = plan_->branches[way];
    if (auto status = check_picked(way); !status) return status.error();
    if (!*holds || branch.behaviour == Behaviour::Skip) return gst::Routed{GST_FLOW_OK, true};
    auto& output = outputs_.output(way);
    if (const auto settled = outputs_.settle(&output, branch.spec); !settled)
      return settled.error();
    if (branch.behaviour == Behaviour::TensorPick) {
      auto picked = pick(buffer.get(), branch);
      if (!picked) return picked.error();
      buffer = *std::move(picked);
    }
    return gst::Routed{push(&output, std::move(buffer)), false};
  }

  // A branch without any frame needs EOS as well, or its sink would wait forever.
  void before_eos() {
    for (size_t way = 0; plan_ && way < 2; ++way)
      if (plan_->branches[way].behaviour != Behaviour::Skip)
        (void)outputs_.settle(&outputs_.output(way), plan_->branches[way].spec);
  }

  Settings settings_;
  gst::LiveSettings<Settings> followed_;  // streaming thread

 private:
  void use(IfPlan plan) {
    plan_ = std::move(plan);
    outputs_.expect(static_cast<size_t>(
        std::count_if(std::begin(plan_->branches), std::end(plan_->branches),
                      [](const auto& branch) { return branch.behaviour != Behaviour::Skip; })));
    outputs_.unsettle();
  }

  // Called between two frames.
  void follow_properties() {
    if (plan_) {
      follow_settings(&followed_, [this](const Settings& wanted) { return judge(wanted); });
      return;
    }
    if (const Status status = judge(take_settings(&followed_)); !status) missing_ = status.error();
  }
  Status judge(const Settings& s) {
    if (auto status = check_texts(s); !status) return status;
    if (auto error = missing_setting(s)) return *std::move(error);
    auto plan = plan_if(s, spec_);
    if (!plan) return plan.error();
    for (size_t way = 0; way < 2; ++way)
      if (const IfBranch& branch = plan->branches[way]; branch.behaviour != Behaviour::Skip)
        if (auto status = outputs_.takes(way, branch.spec); !status) return status;
    use(*std::move(plan));
    return ok();
  }

  // In a flexible stream the number of tensors varies by frame.
  Status check_picked(size_t way) const {
    for (const size_t index : plan_->branches[way].tensors)
      if (index >= layout_.tensors().size())
        return index_beyond(way == 0 ? "then-option" : "else-option", "tensor", index,
                            layout_.tensors().size());
    return ok();
  }

  // Resolves the condition for the tensors of a frame of a flexible stream.
  Status compare_frame() {
    specs_.clear();
    for (const auto& part : layout_.tensors()) specs_.push_back(part.spec);
    auto comparison = condition::Comparison::make(*plan_->of_each_frame, specs_);
    if (!comparison) return comparison.error();
    const auto& part = layout_.tensors()[comparison->tensor()];
    if (part.size != kTensorHeaderBytes + part.spec.bytes().value_or(0))
      return Error{.code = Code::FORMAT_UNSUPPORTED,
                   .what = "the tensor to compare is not dense",
                   .offered = part.spec.to_string() + " in " +
                              std::to_string(part.size - kTensorHeaderBytes) + " bytes",
                   .needed = "a dense tensor",
                   .difference = "tensor " + std::to_string(comparison->tensor()),
                   .fix = "other/tensors,format=sparse ! tensor_sparse_dec ! tensor_if"};
    plan_->comparison = *std::move(comparison);
    return ok();
  }

  Result<std::optional<bool>> decide(GstBuffer* buffer) {
    if (plan_->custom) {
      if (layout_.has_empty_tensor()) return std::optional(false);
      if (auto status = reader_.read(buffer, spec_); !status) return status.error();
      if (reader_.bytes_copied() > 0) ledger_.copied(reader_.bytes_copied());
      auto decision = plan_->custom->decide(arguments_.fill(reader_, buffer));
      reader_.clear();
      return decision;
    }
    size_t header = 0;
    if (plan_->of_each_frame) {
      if (auto status = compare_frame(); !status) return status.error();
      header = kTensorHeaderBytes;
    }
    const auto& comparison = *plan_->comparison;
    if (layout_.tensors()[comparison.tensor()].spec.shape.is_empty()) return std::optional(false);
    const size_t offset =
        layout_.tensors()[comparison.tensor()].offset + header + comparison.offset();
    std::byte element[8];
    if (comparison.bytes() <= sizeof element) {
      gst_buffer_extract(buffer, offset, element, comparison.bytes());
      return std::optional(comparison.holds(std::span(element).first(comparison.bytes())));
    }
    uint64_t copied = 0;
    const auto memory = gst::share_bytes(buffer, offset, comparison.bytes(), &copied);
    if (!memory) return memory.error();
    if (copied > 0) ledger_.copied(copied);
    const gst::MappedMemory map(memory->get(), GST_MAP_READ);
    if (!map) return gst::memory_not_mapped();
    return std::optional(comparison.holds(map.bytes()));
  }

  Result<Ref<GstBuffer>> pick(GstBuffer* buffer, const IfBranch& branch) {
    uint64_t copied = 0;
    auto picked = gst::pick_tensors(buffer, layout_, branch.tensors, &copied);
    if (copied > 0) ledger_.copied(copied);
    return picked;
  }

  // Streaming thread:
  std::optional<IfPlan> plan_;
  std::optional<Error> missing_;  // set if there is no plan
  FrameSpec spec_;                // of the input
  gst::FrameLayout layout_;
  std::vector<TensorSpec> specs_;  // of a frame of a flexible stream
  gst::FrameLayout reader_;
  gst::FrameArguments arguments_;
};

}  // namespace

bool register_tensor_if(GstPlugin* plugin) {
  return TensorIf::register_in(plugin);
}

}  // namespace weir
