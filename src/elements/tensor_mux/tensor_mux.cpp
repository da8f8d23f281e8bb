// tensor_mux: combines the tensors of several streams into one frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <optional>

#include "elements/tensor_mux/sync_element.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir {
namespace {

using gst::Ref;

class TensorMux : public SyncElement<TensorMux> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirTensorMux", "tensor_mux", "TensorMux",
                                          "Muxer/Tensor",
                                          "Combines the tensors of several streams into one frame"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE(
          "sink_%u", GST_PAD_SINK, GST_PAD_REQUEST,
          GST_STATIC_CAPS(WEIR_CAPS_TENSOR "; " WEIR_CAPS_TENSORS("{ static, flexible }"))),
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_CAPS_TENSORS("{ static, flexible }"))),
  };
  struct Settings : SyncSettings {
    Settings() { sync_mode = "slowest"; }
  };
  static constexpr sync::Mode kFallback = sync::Mode::Slowest;
  static constexpr auto kProperties = kSyncProperties<Settings>;

  Result<FrameSpec> combine_specs(const std::vector<const FrameSpec*>& inputs) override {
    FrameSpec out;
    out.format = Format::Static;
    out.rate = inputs[0]->rate;
    std::optional<size_t> before = 0;  // tensors of the earlier inputs; nullopt: not known
    for (const FrameSpec* input : inputs) {
      if (input->format != Format::Static) out.format = Format::Flexible;
      out.rate.numerator = std::min(out.rate.numerator, input->rate.numerator);
      out.rate.denominator = std::min(out.rate.denominator, input->rate.denominator);
      const auto tensors = count_tensors(*input);
      if (before && tensors) append_roles(input->roles, *tensors, *before, &out.roles);
      before = before && tensors ? std::optional(*before + *tensors) : std::nullopt;
      out.tensors.insert(out.tensors.end(), input->tensors.begin(), input->tensors.end());
    }
    if (out.tensors.size() > kTensorLimit)
      return Error{.code = Code::LIMIT_EXCEEDED,
                   .what = "the pads together have more tensors than a frame may hold",
                   .offered = std::to_string(out.tensors.size()),
                   .needed = "at most 256"};
    if (out.format != Format::Static) out.tensors.clear();
    return out;
  }

  Status configure(const FrameSpec& output) override {
    format_ = output.format;
    return ok();
  }

  Result<Ref<GstBuffer>> combine(const gst::Inputs& inputs) override {
    std::vector<gst::TensorPiece> pieces;
    std::vector<GstBuffer*> owners;
    std::vector<size_t> counts;  // tensors of each input
    for (const gst::Input& input : inputs.frames) {
      owners.push_back(input.buffer.get());
      const size_t first = pieces.size();
      auto status = layout_.locate(input.buffer.get(), *input.spec);
      if (status) status = gst::append_pieces(input.buffer.get(), layout_, &ledger_, &pieces);
      if (!status) return gst::on_pad(status.error(), "pad " + std::to_string(owners.size() - 1));
      counts.push_back(pieces.size() - first);
      if (format_ == Format::Static || input.spec->format != Format::Static) continue;
      for (size_t i = first; i < pieces.size(); ++i) {
        auto piece = gst::with_header(pieces[i], &ledger_);
        if (!piece) return piece.error();
        pieces[i] = *std::move(piece);
      }
    }
    auto out = gst::sharing_buffer(owners);
    gst_buffer_copy_into(out.get(), inputs.frames[inputs.metadata_pad].buffer.get(),
                         GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
    if (auto status = gst::append_tensors(pieces, out.get(), &ledger_); !status)
      return status.error();
    if (auto maps = join_maps(inputs, counts); !maps.empty())
      gst::set_source_maps(out.get(), std::move(maps));
    return out;
  }

  Settings settings_;
  Ledger ledger_;

 private:
  // The number of tensors in a frame. Flexible streams say it if they are results.
  static std::optional<size_t> count_tensors(const FrameSpec& input) {
    if (input.format == Format::Static) return input.tensors.size();
    return input.roles.empty() ? std::nullopt : std::optional(input.roles.size());
  }

  // One source map per tensor if every input has them; else those of the deciding frame stay.
  static std::vector<SourceMap> join_maps(const gst::Inputs& inputs,
                                          const std::vector<size_t>& counts) {
    std::vector<SourceMap> out;
    for (size_t input = 0; input < inputs.frames.size(); ++input) {
      GstBuffer* const buffer = inputs.frames[input].buffer.get();
      const auto maps = gst::source_maps(buffer);
      const size_t tensors = counts[input];
      const bool of_regions = gst::maps_of(buffer) == gst::MapsOf::Regions && maps.size() != 1;
      if (of_regions || (maps.size() != 1 && maps.size() != tensors)) return {};
      for (size_t i = 0; i < tensors; ++i) out.push_back(maps[maps.size() == 1 ? 0 : i]);
    }
    return out;
  }

  // Used by the thread that makes an output.
  Format format_ = Format::Static;
  gst::FrameLayout layout_;
};

}  // namespace

bool register_tensor_mux(GstPlugin* plugin) {
  return TensorMux::register_in(plugin);
}

}  // namespace weir
