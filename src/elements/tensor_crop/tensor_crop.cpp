// tensor_crop: the regions that one stream names are cut out of the tensors of another.
#include <algorithm>
#include <atomic>
#include <optional>

#include "core/crop/regions.hpp"
#include "core/tensor/tensor_header.hpp"
#include "elements/tensor_mux/tensor_pieces.hpp"
#include "gstcpp/base_classes.hpp"
#include "gstcpp/collector_pads.hpp"
#include "gstcpp/frame_reader.hpp"
#include "gstcpp/tensor_caps.hpp"
#include "gstcpp/tensor_meta.hpp"

namespace weir {
namespace {

using gst::Ref;

// The map of a tensor, for a part of it along dimensions 1 and 2.
PictureMap map_of_part(const PictureMap& map, const Region& region) {
  const auto along = [](uint8_t dimension, uint32_t one, uint32_t two, uint32_t other) {
    return dimension == 1 ? one : dimension == 2 ? two : other;
  };
  return map.of_part(1, along(map.x_dimension, region.x, region.y, 0), 1,
                     along(map.y_dimension, region.x, region.y, 0),
                     along(map.x_dimension, region.width, region.height, map.width),
                     along(map.y_dimension, region.width, region.height, map.height));
}

class TensorCrop : public gst::Element<TensorCrop, gst::PlainElement>, public gst::Combiner {
 public:
  static constexpr gst::ElementInfo kInfo{
      "WeirTensorCrop", "tensor_crop", "TensorCrop", "Converter/Tensor",
      "Cuts the regions that one stream names out of the tensors of another"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE(
          "raw", GST_PAD_SINK, GST_PAD_ALWAYS,
          GST_STATIC_CAPS(WEIR_CAPS_TENSOR "; " WEIR_CAPS_TENSORS("{ static, flexible }"))),
      GST_STATIC_PAD_TEMPLATE("info", GST_PAD_SINK, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_CAPS_TENSORS("flexible"))),
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_CAPS_TENSORS("flexible"))),
  };
  struct Settings {
    int lateness = -1;
    bool silent = true;
  };
  static constexpr std::tuple kProperties{
      gst::Property{"lateness", &Settings::lateness,
                    "Milliseconds by which frames that go together may differ, the older one is "
                    "dropped beyond; -1 = frames go together in their order",
                    gst::Changeable::WhilePlaying, -1, G_MAXINT},
      gst::Property{"silent", &Settings::silent, "Accepted for compatibility; has no effect"},
  };

  void constructed() {
    GstPad* source = gst_pad_new_from_static_template(&kPads[2], "src");
    gst_element_add_pad(element(), source);
    pads_.emplace(element(), source, &ledger_, this);
    for (size_t i = 0; i < 2; ++i) {
      GstPad* pad = gst_pad_new_from_static_template(&kPads[i], kPads[i].name_template);
      pads_->attach(pad);
      gst_element_add_pad(element(), pad);
    }
  }

  GstStateChangeReturn change_state(GstStateChange transition) {
    if (transition == GST_STATE_CHANGE_READY_TO_PAUSED) {
      ledger_.reset();
      regions_ = regions_empty_ = regions_beyond_limit_ = 0;
      configure_pads();
      if (const Status status = pads_->start(); !status) {
        gst::post_error(element(), status.error());
        return GST_STATE_CHANGE_FAILURE;
      }
    }
    if (transition == GST_STATE_CHANGE_PAUSED_TO_READY) pads_->stop();
    return parent_class()->change_state(element(), transition);
  }
  void property_changed(const char*) { configure_pads(); }

  Result<FrameSpec> combine_specs(const std::vector<const FrameSpec*>& inputs) override {
    FrameSpec out;
    out.format = Format::Flexible;
    out.rate = {std::min(inputs[0]->rate.numerator, inputs[1]->rate.numerator),
                std::min(inputs[0]->rate.denominator, inputs[1]->rate.denominator)};
    return out;
  }
  Status configure(const FrameSpec&) override { return ok(); }
  bool gives_time() const override { return true; }

  Result<Ref<GstBuffer>> combine(const gst::Inputs& inputs) override {
    auto out = cropped(inputs.frames[0], inputs.frames[1]);
    raw_.clear();
    info_.clear();
    return out;
  }

  void add_stats(GstStructure* stats) const {
    pads_->add_stats(stats);
    gst_structure_set(stats, "regions", G_TYPE_UINT64, regions_.load(), "regions-empty",
                      G_TYPE_UINT64, regions_empty_.load(), "regions-beyond-limit", G_TYPE_UINT64,
                      regions_beyond_limit_.load(), nullptr);
  }

  Settings settings_;
  Ledger ledger_;

 private:
  void configure_pads() {
    const int lateness = settings().lateness;
    sync::Options options;
    options.mode = sync::Mode::Lateness;
    if (lateness >= 0) options.lateness = static_cast<uint64_t>(lateness) * GST_MSECOND;
    pads_->configure(options, OnBackwardsTime::Pass, 0);
  }

  Regions regions_of(const gst::TensorView& info, const TensorSpec& whole) {
    const auto side = [&whole](size_t d) { return std::max<uint32_t>(whole.shape[d], 1); };
    Regions out = read_regions(info.spec, info.payload, side(1), side(2));
    regions_ += out.inside.size();
    regions_empty_ += out.empty;
    regions_beyond_limit_ += out.beyond_limit;
    return out;
  }

  Status append_regions(const gst::TensorView& whole, const std::vector<Region>& regions,
                        GstBuffer* out) {
    std::vector<TensorSpec> specs;
    std::vector<uint64_t> sizes;
    for (const Region& region : regions) {
      specs.push_back(part_of(whole.spec, region));
      sizes.push_back(kTensorHeaderBytes + *specs.back().bytes());
      ledger_.copied(*specs.back().bytes());
    }
    return append_filled(specs, sizes, out, [&](size_t n, std::span<std::byte> bytes) {
      TensorHeader header;
      header.spec = specs[n];
      header.format = Format::Flexible;
      write_tensor_header(header, bytes.first<kTensorHeaderBytes>());
      cut(whole.spec, whole.payload, regions[n], bytes.subspan(kTensorHeaderBytes));
      return ok();
    });
  }

  Result<Ref<GstBuffer>> cropped(const gst::Input& raw, const gst::Input& info) {
    if (auto s = raw_.read(raw.buffer.get(), *raw.spec); !s) return s.error();
    if (auto s = info_.read(info.buffer.get(), *info.spec); !s) return s.error();
    const gst::TensorView& whole = raw_.tensors()[0];
    if (whole.format == Format::Sparse || info_.tensors()[0].format == Format::Sparse)
      return Error{
          Code::FORMAT_UNSUPPORTED, "a sparse tensor cannot be cropped", "sparse", "dense", "",
          "tensor_sparse_dec"};
    const Regions regions = regions_of(info_.tensors()[0], whole.spec);
    if (regions.inside.empty()) return Ref<GstBuffer>();
    auto out = Ref<GstBuffer>::adopt(gst_buffer_new());
    gst_buffer_copy_into(out.get(), raw.buffer.get(), GST_BUFFER_COPY_METADATA, 0,
                         static_cast<gsize>(-1));
    if (auto s = append_regions(whole, regions.inside, out.get()); !s) return s.error();
    gst::set_picture_maps(out.get(), maps_of(raw.buffer.get(), regions));
    return out;
  }

  static std::vector<PictureMap> maps_of(GstBuffer* raw, const Regions& regions) {
    const auto maps = gst::picture_maps(raw);
    std::vector<PictureMap> out;
    if (maps.empty()) return out;
    for (const Region& region : regions.inside) out.push_back(map_of_part(maps[0], region));
    return out;
  }

  std::optional<gst::CollectorPads> pads_;
  gst::FrameReader raw_, info_;  // of the thread that makes an output
  std::atomic<uint64_t> regions_{0}, regions_empty_{0}, regions_beyond_limit_{0};
};

}  // namespace

bool register_tensor_crop(GstPlugin* plugin) {
  return TensorCrop::register_in(plugin);
}

}  // namespace weir
