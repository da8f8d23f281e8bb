// tensor_merge: concatenates the tensors of several streams along a dimension.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>

#include "core/merge/concatenation.hpp"
#include "core/text/text.hpp"
#include "elements/tensor_mux/sync_element.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/buffer/frame_pool.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir {
namespace {

using gst::Ref;

#define WEIR_ONE_STATIC \
  WEIR_CAPS_TENSOR "; other/tensors, format=(string)static, num_tensors=(int)1, " WEIR_CAPS_RATE

class TensorMerge : public SyncElement<TensorMerge> {
 public:
  static constexpr gst::ElementInfo kInfo{
      "WeirTensorMerge", "tensor_merge", "TensorMerge", "Muxer/Tensor",
      "Concatenates the tensors of several streams along a dimension"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("sink_%u", GST_PAD_SINK, GST_PAD_REQUEST,
                              GST_STATIC_CAPS(WEIR_ONE_STATIC)),
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS(WEIR_ONE_STATIC)),
  };
  struct Settings : SyncSettings {
    Settings() { sync_mode = "nosync"; }
    std::string mode = "linear", option = "0";
  };
  static constexpr sync::Mode kFallback = sync::Mode::NoSync;
  static constexpr auto kProperties = std::tuple_cat(
      std::tuple{
          gst::Property{"mode", &Settings::mode, "How tensors are merged: linear",
                        gst::Changeable::WhilePlaying},
          gst::Property{"option", &Settings::option,
                        "Dimension along which tensors are merged, 0 to 15; 0 is the innermost",
                        gst::Changeable::WhilePlaying}},
      kSyncProperties<Settings>);

  Status prepare(const Settings& settings) {
    const auto dimension = parse_dimension(settings);
    if (!dimension) return dimension.error();
    if (GST_STATE(element()) <= GST_STATE_READY) take_settings(&followed_);
    return ok();
  }
  static bool is_followed(std::string_view name) { return name == "mode" || name == "option"; }
  Status check_change(const char*, const Settings& wanted) const {
    const auto dimension = parse_dimension(wanted);
    return dimension ? ok() : Status(dimension.error());
  }

  Result<FrameSpec> combine_specs(const std::vector<const FrameSpec*>& inputs) override {
    std::vector<TensorSpec> tensors;
    FrameSpec out;
    out.format = Format::Static;
    out.rate = inputs[0]->rate;
    for (const FrameSpec* input : inputs) {
      out.rate.numerator = std::min(out.rate.numerator, input->rate.numerator);
      out.rate.denominator = std::min(out.rate.denominator, input->rate.denominator);
      tensors.push_back(input->tensors[0]);
    }
    const auto judge = [&](const Settings& wanted) -> Status {
      if (auto status = plan(wanted, tensors, &out); !status) return status;
      const auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(element(), "src"));
      return gst::check_downstream(pad.get(), out,
                                   "tensor_merge option=" + followed_.in_force.option);
    };
    if (follow_settings(&followed_, judge)) return out;
    if (auto status = plan(followed_.in_force, tensors, &out); !status) return status.error();
    return out;
  }

  Status configure(const FrameSpec&) override {
    if (auto status = buffer_limit_.check({Format::Static, {plan_.output()}, {}}); !status)
      return status;
    auto pool = gst::FramePool::make({plan_.output()}, Format::Static);
    if (!pool) return pool.error();
    pool_ = *std::move(pool);
    return ok();
  }

  Result<Ref<GstBuffer>> combine(const gst::Inputs& inputs) override {
    auto out = merged(inputs);
    writer_.unmap();
    for (auto& reader : readers_) reader.clear();
    if (!out) return out;
    GstBuffer* deciding = inputs.frames[inputs.metadata_pad].buffer.get();
    gst_buffer_copy_into(out->get(), deciding, GST_BUFFER_COPY_TIMESTAMPS, 0,
                         static_cast<gsize>(-1));
    gst::set_source_maps(out->get(), keep_maps(deciding));
    return out;
  }

  Settings settings_;
  Ledger ledger_;
  BufferLimit buffer_limit_{kInfo.factory_name};

 private:
  static Result<size_t> parse_dimension(const Settings& settings) {
    if (!equal_ignoring_case(strip(settings.mode), "linear"))
      return Error{.code = Code::MODE_UNKNOWN,
                   .what = "mode is not known",
                   .offered = settings.mode,
                   .needed = "linear",
                   .fix = "mode=linear"};
    const auto dimension = parse_unsigned(strip(settings.option));
    if (!dimension || *dimension >= kRankLimit)
      return Error{.code = Code::OPTION_VALUE,
                   .what = "option is not a dimension",
                   .offered = settings.option,
                   .needed = "a number from 0 to 15; 0 is the innermost dimension",
                   .fix = "tensor_merge mode=linear option=2"};
    return static_cast<size_t>(*dimension);
  }

  Status plan(const Settings& settings, const std::vector<TensorSpec>& tensors, FrameSpec* out) {
    const auto dimension = parse_dimension(settings);
    if (!dimension) return dimension.error();
    auto plan = Concatenation::plan(tensors, *dimension);
    if (!plan) return plan.error();
    dimension_ = *dimension;
    plan_ = *std::move(plan);
    out->tensors = {plan_.output()};
    return ok();
  }

  // Inputs and output stay mapped.
  Result<Ref<GstBuffer>> merged(const gst::Inputs& inputs) {
    readers_.resize(inputs.frames.size());
    views_.clear();
    for (size_t i = 0; i < inputs.frames.size(); ++i) {
      const gst::Input& input = inputs.frames[i];
      if (auto s = readers_[i].read(input.buffer.get(), *input.spec); !s)
        return gst::on_pad(s.error(), "pad " + std::to_string(i));
      ledger_.copied(readers_[i].bytes_copied());
      views_.push_back(readers_[i].tensors()[0].payload);
    }
    auto out = pool_.acquire(buffer_limit_);
    if (!out) return out;
    if (auto status = writer_.map(pool_, out->get()); !status) {
      writer_.unmap();
      return status.error();
    }
    plan_.run(views_, writer_.payloads()[0]);
    return out;
  }

  // Pixels stay in place unless the merge is along a dimension of the picture.
  std::vector<SourceMap> keep_maps(GstBuffer* deciding) const {
    const auto maps = gst::source_maps(deciding);
    const bool moved = std::any_of(maps.begin(), maps.end(), [this](const SourceMap& map) {
      return map.x_dimension == dimension_ || map.y_dimension == dimension_;
    });
    if (moved || maps.size() != 1) return {};
    return {maps.begin(), maps.end()};
  }

  // Used by the thread that makes an output.
  gst::LiveSettings<Settings> followed_;  // the settings of plan_
  Concatenation plan_;
  size_t dimension_ = 0;  // used by plan_
  gst::FramePool pool_;
  gst::FramePool::Writer writer_;
  std::vector<gst::FrameLayout> readers_;
  std::vector<std::span<const std::byte>> views_;
};

}  // namespace

bool register_tensor_merge(GstPlugin* plugin) {
  return TensorMerge::register_in(plugin);
}

}  // namespace weir
