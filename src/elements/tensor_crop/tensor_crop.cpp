// tensor_crop: cuts the regions that one stream gives out of the tensors of another.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <atomic>
#include <mutex>
#include <optional>
#include <utility>

#include "core/crop/regions.hpp"
#include "core/tensor/geometry.hpp"
#include "core/tensor/packed_tensors.hpp"
#include "core/tensor/tensor_header.hpp"
#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/buffer/deferred_memory.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/buffer/frame_pool.hpp"
#include "gstcpp/buffer/result_boxes.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"
#include "gstcpp/element/base_classes.hpp"
#include "gstcpp/pads/collector_pads.hpp"

namespace weir {
namespace {

using gst::Ref;

// The source map of a part of a tensor along dimensions 1 and 2.
SourceMap map_of_part(const SourceMap& map, const Rect& region) {
  const auto along = [](uint8_t dimension, uint32_t one, uint32_t two, uint32_t other) {
    return dimension == 1 ? one : dimension == 2 ? two : other;
  };
  return map.of_part(1, along(map.x_dimension, region.x, region.y, 0), 1,
                     along(map.y_dimension, region.x, region.y, 0),
                     along(map.x_dimension, region.width, region.height, map.width),
                     along(map.y_dimension, region.width, region.height, map.height));
}

uint32_t side(const TensorSpec& whole, size_t dimension) {
  return std::max<uint32_t>(whole.shape[dimension], 1);
}

Error rows_without_columns(const TensorSpec& spec) {
  const std::string length = std::to_string(spec.shape[0]);
  return {.code = Code::SPEC_MISMATCH,
          .what = "rows of " + length + " numbers are read as groups of 4: x, y, width, height",
          .offered = spec.to_string() + " on info, without weir-columns",
          .needed = "4:N, or results: caps with the field weir-columns",
          .difference = length + " is not a multiple of 4",
          .fix = "tensor_decoder mode=detection"};
}

class TensorCrop : public gst::Element<TensorCrop, gst::PlainElement>, public gst::Combiner {
 public:
  static constexpr gst::ElementInfo kInfo{
      "WeirTensorCrop", "tensor_crop", "TensorCrop", "Converter/Tensor",
      "Crops the tensors of one stream to the regions of another"};
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
    uint64_t max_bytes = 0;
    bool silent = true;
  };
  static constexpr std::tuple kProperties{
      gst::Property{"lateness", &Settings::lateness,
                    "Maximum time difference of paired frames in milliseconds; beyond it the older "
                    "one is dropped; -1 = pair frames in order",
                    gst::Changeable::WhilePlaying, -1, G_MAXINT},
      gst::Property{"max-bytes", &Settings::max_bytes,
                    "Maximum bytes of all held frames; at the limit a frame waits for the current "
                    "output, and it is an error if that frees too little; 0 = no limit",
                    gst::Changeable::WhilePlaying},
      gst::Property{"silent", &Settings::silent, "Accepted for compatibility; has no effect",
                    gst::Changeable::WhilePlaying},
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
      regions_ = regions_empty_ = regions_beyond_limit_ = regions_shared_ = pool_allocated_ = 0;
      counts_->bytes_gathered = 0;
      has_warned_ = false;
      pool_ = {};
      last_specs_.clear();
      allocation_ = {};
      configure_pads();
      if (const Status status = pads_->start(); !status) {
        gst::post_error(element(), status.error());
        return GST_STATE_CHANGE_FAILURE;
      }
    }
    if (transition == GST_STATE_CHANGE_PAUSED_TO_READY) pads_->stop();
    const auto result = parent_class()->change_state(element(), transition);
    if (transition == GST_STATE_CHANGE_PAUSED_TO_READY) pads_->forget_streams();
    return result;
  }
  void property_changed(const char*) { configure_pads(); }

  Result<FrameSpec> combine_specs(const std::vector<const FrameSpec*>& inputs) override {
    FrameSpec out;
    out.format = Format::Flexible;
    out.rate = {std::min(inputs[0]->rate.numerator, inputs[1]->rate.numerator),
                std::min(inputs[0]->rate.denominator, inputs[1]->rate.denominator)};
    out.roles = pick_roles(inputs[0]->roles, std::vector<size_t>{0});  // of raw
    results_.reset();
    if (inputs[1]->roles.empty()) return out;
    auto results = gst::ResultBoxes::parse(*inputs[1]);
    if (!results) return gst::on_pad(results.error(), "info");
    results_ = *std::move(results);
    return out;
  }
  Status configure(const FrameSpec&) override {
    GstPad* const source = pads_->source();
    const auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(source));
    const auto query = caps ? gst::ask_peer(source, caps.get(), ledger_) : Ref<GstQuery>();
    const auto allocation = query ? gst::parse_allocation(query.get(), allocation_) : allocation_;
    if (!(allocation == allocation_)) pool_ = {};
    allocation_ = allocation;
    views_wanted_ = query && gst::deferral_is_offered(query.get(), source);
    computed_before_ = counts_->computed;
    return ok();
  }
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
                      regions_beyond_limit_.load(), "regions-shared", G_TYPE_UINT64,
                      regions_shared_.load(), "pool-allocated", G_TYPE_UINT64,
                      pool_allocated_.load(), "bytes-copied", G_TYPE_UINT64,
                      ledger_.snapshot().bytes_copied + counts_->bytes_gathered.load(), nullptr);
  }

  Settings settings_;
  Ledger ledger_;
  BufferLimit buffer_limit_{kInfo.factory_name};

 private:
  void configure_pads() {
    std::lock_guard lock(configure_mutex_);
    const auto [lateness, max_bytes, silent] = settings();
    sync::Options options;
    options.mode = sync::Mode::Lateness;
    if (lateness >= 0) options.lateness = static_cast<uint64_t>(lateness) * GST_MSECOND;
    pads_->configure(options, OnBackwardsTime::Pass, 0, max_bytes);
  }

  Result<Regions> get_regions(GstBuffer* raw, const gst::Input& info, const TensorSpec& whole) {
    auto out = results_ ? read_results(raw, info, whole) : read_numbers(whole);
    if (!out) return out;
    regions_ += out->inside.size();
    regions_empty_ += out->empty;
    regions_beyond_limit_ += out->beyond_limit;
    return out;
  }

  Regions read_numbers(const TensorSpec& whole) {
    const gst::TensorPlace& numbers = info_.tensors()[0];
    const uint32_t length = numbers.spec.shape[0];
    if (length > 4 && length % 4 != 0 && !std::exchange(has_warned_, true))
      gst::post_warning(element(), rows_without_columns(numbers.spec));
    return read_regions(numbers.spec, numbers.payload, side(whole, 1), side(whole, 2));
  }

  // The boxes are in pixels of the picture that the results come from; the tensor may be another
  // size or another part of it.
  Result<Regions> read_results(GstBuffer* raw, const gst::Input& info, const TensorSpec& whole) {
    std::vector<preprocess::PictureBox> boxes;
    if (auto s = results_->read(info_.tensors(), &boxes); !s) return gst::on_pad(s.error(), "info");
    const auto raw_maps = gst::source_maps(raw), info_maps = gst::source_maps(info.buffer.get());
    SourceMap map =
        raw_maps.empty() ? picture_as_it_is(side(whole, 1), side(whole, 2), false) : raw_maps[0];
    if (auto s = check_picture_dimensions(map); !s) return gst::on_pad(s.error(), "raw");
    if (!info_maps.empty()) scale_to(info_maps[0], &map);
    return read_regions(boxes, map, side(whole, 1), side(whole, 2));
  }

  // Makes `map` one to the picture of `other`, unless it may show only a part of that.
  void scale_to(const SourceMap& other, SourceMap* map) {
    const Size from{other.source_width, other.source_height};
    const Size to{map->source_width, map->source_height};
    const auto scale = preprocess::find_scale(from, to, 1);
    if (!scale) {
      if (!std::exchange(has_warned_, true))
        gst::post_warning(element(), preprocess::boxes_of_another_view(from, to));
      return;
    }
    map->xx /= scale->x, map->xy /= scale->x, map->x0 /= scale->x;
    map->yx /= scale->y, map->yy /= scale->y, map->y0 /= scale->y;
  }

  // The size of a buffer with the regions and their headers. Regions may overlap, so the sum may be
  // any multiple of the input tensor.
  static uint64_t output_bytes(const TensorSpec& whole, const std::vector<Rect>& regions) {
    uint64_t bytes = 0;
    for (const Rect& region : regions)
      bytes += kTensorHeaderBytes + *make_part_spec(whole, region).bytes();
    return bytes;
  }

  static void write_header(const TensorSpec& spec, std::span<std::byte> out) {
    TensorHeader header;
    header.spec = spec;
    header.format = Format::Flexible;
    write_tensor_header(header, out.first<kTensorHeaderBytes>());
  }

  // Deferred memory for a downstream element that accepts it; null when the frame must be copied.
  // If deferred memory is being mapped, copying into pooled buffers is faster.
  Ref<GstBuffer> make_views(GstBuffer* raw, const gst::TensorPlace& whole,
                            const std::vector<Rect>& regions) {
    if (!views_wanted_ || counts_->computed != computed_before_ || whole.memory < 0) return {};
    const auto memory = static_cast<guint>(whole.memory);
    if (!gst_memory_is_type(gst_buffer_peek_memory(raw, memory), GST_ALLOCATOR_SYSMEM)) return {};
    std::vector<gst::DeferredSource> views;
    for (const Rect& region : regions) {
      auto layout = make_layout(whole.spec, region);
      layout.offset += whole.header_bytes;
      auto plan = transform::gather_plan(make_part_spec(whole.spec, region), layout);
      if (!plan) return {};  // out of the range of a plan
      std::vector<std::byte> header(kTensorHeaderBytes);
      write_header(plan->output(), header);
      views.push_back({Ref<GstBuffer>::share(raw), memory,
                       std::make_shared<const transform::TransformPlan>(*std::move(plan)),
                       std::move(header)});
    }
    auto out = make_buffer(std::move(views));
    if (out) regions_shared_ += regions.size();
    return out;
  }

  // One memory per region; of more than 16 regions, the 16th and all later ones share one.
  Ref<GstBuffer> make_buffer(std::vector<gst::DeferredSource> views) const {
    auto out = Ref<GstBuffer>::adopt(gst_buffer_new());
    const size_t alone = views.size() > kMemoryLimit ? kMemoryLimit - 1 : views.size();
    for (size_t i = 0; i < alone; ++i) {
      GstMemory* const view = gst::make_deferred_memory(std::move(views[i]), counts_);
      if (!view) return {};
      gst_buffer_append_memory(out.get(), view);
    }
    views.erase(views.begin(), views.begin() + static_cast<std::ptrdiff_t>(alone));
    if (views.empty()) return out;
    std::vector<TensorSpec> specs;
    std::vector<uint64_t> sizes;
    for (const auto& view : views) {
      specs.push_back(view.plan->output());
      sizes.push_back(view.header.size() + *specs.back().bytes());
    }
    std::vector<std::byte> prefix(kPackedHeaderBytes);
    write_packed_header(specs, sizes, std::span(prefix).first<kPackedHeaderBytes>());
    GstMemory* const packed =
        gst::make_deferred_memory(std::move(views), std::move(prefix), counts_);
    if (!packed) return {};
    gst_buffer_append_memory(out.get(), packed);
    return out;
  }

  // Uses a pool if the regions have the same sizes as in the previous frame.
  Result<Ref<GstBuffer>> make_copies(const gst::TensorPlace& whole,
                                     const std::vector<Rect>& regions) {
    std::vector<TensorSpec> specs;
    for (const Rect& region : regions) {
      specs.push_back(make_part_spec(whole.spec, region));
      ledger_.copied(*specs.back().bytes());
    }
    const auto alike = [](const TensorSpec& a, const TensorSpec& b) { return a.same_layout(b); };
    if (std::equal(specs.begin(), specs.end(), last_specs_.begin(), last_specs_.end(), alike))
      return pooled(whole, regions);
    last_specs_ = std::move(specs);
    pool_ = {};
    return allocated(whole, regions);
  }

  Result<Ref<GstBuffer>> allocated(const gst::TensorPlace& whole,
                                   const std::vector<Rect>& regions) {
    std::vector<uint64_t> sizes;
    for (const TensorSpec& spec : last_specs_) sizes.push_back(kTensorHeaderBytes + *spec.bytes());
    auto out = Ref<GstBuffer>::adopt(gst_buffer_new());
    auto status = gst::append_filled(
        last_specs_, sizes, out.get(), [&](size_t n, std::span<std::byte> bytes) -> Status {
          write_header(last_specs_[n], bytes);
          cut(whole.spec, whole.payload, regions[n], bytes.subspan(kTensorHeaderBytes));
          return ok();
        });
    if (!status) return status.error();
    return out;
  }

  Result<Ref<GstBuffer>> pooled(const gst::TensorPlace& whole, const std::vector<Rect>& regions) {
    if (!pool_) {
      auto pool =
          gst::FramePool::make(last_specs_, Format::Flexible, MediaType::Tensor, allocation_);
      if (!pool) return pool.error();
      pool_ = *std::move(pool);
    }
    auto out = pool_.acquire();
    if (!out) return out;
    gst::FramePool::Writer writer;
    if (auto status = writer.map(pool_, out->get(), Format::Flexible); !status)
      return status.error();
    for (size_t i = 0; i < regions.size(); ++i)
      cut(whole.spec, whole.payload, regions[i], writer.payloads()[i]);
    pool_allocated_ = pool_.stats().allocated;
    return out;
  }

  Result<Ref<GstBuffer>> cropped(const gst::Input& raw, const gst::Input& info) {
    if (auto s = raw_.read(raw.buffer.get(), *raw.spec); !s) return gst::on_pad(s.error(), "raw");
    if (auto s = info_.read(info.buffer.get(), *info.spec); !s)
      return gst::on_pad(s.error(), "info");
    if (raw_.has_empty_tensor()) return Ref<GstBuffer>();
    const gst::TensorPlace& whole = raw_.tensors()[0];
    const auto found = get_regions(raw.buffer.get(), info, whole.spec);
    if (!found) return found.error();
    const Regions& regions = *found;
    if (regions.inside.empty()) return Ref<GstBuffer>();
    if (auto status = buffer_limit_.check(output_bytes(whole.spec, regions.inside)); !status)
      return status.error();
    auto out = make_views(raw.buffer.get(), whole, regions.inside);
    if (!out) {
      auto copies = make_copies(whole, regions.inside);
      if (!copies) return copies.error();
      out = *std::move(copies);
    }
    gst_buffer_copy_into(out.get(), raw.buffer.get(), GST_BUFFER_COPY_METADATA, 0,
                         static_cast<gsize>(-1));
    gst::set_source_maps(out.get(), make_maps(raw.buffer.get(), regions));
    return out;
  }

  static std::vector<SourceMap> make_maps(GstBuffer* raw, const Regions& regions) {
    const auto maps = gst::source_maps(raw);
    std::vector<SourceMap> out;
    if (maps.empty()) return out;
    for (size_t i = 0; i < regions.inside.size(); ++i) {
      out.push_back(map_of_part(maps[0], regions.inside[i]));
      if (i < regions.rows.size()) out.back().row = regions.rows[i];
    }
    return out;
  }

  std::mutex configure_mutex_;  // orders concurrent settings; taken before the settings lock
  std::optional<gst::CollectorPads> pads_;
  gst::FrameLayout raw_, info_;              // used by the thread that makes an output
  std::optional<gst::ResultBoxes> results_;  // likewise; none: info has plain numbers
  bool has_warned_ = false;                  // likewise
  std::vector<TensorSpec> last_specs_;       // likewise: of the last copied frame
  gst::FramePool pool_;                      // likewise: for those specs
  gst::Allocation allocation_;               // likewise
  bool views_wanted_ = false;                // likewise
  uint64_t computed_before_ = 0;             // likewise: counts_->computed when deferral began
  const std::shared_ptr<gst::DeferredCounts> counts_ = std::make_shared<gst::DeferredCounts>();
  std::atomic<uint64_t> regions_{0}, regions_empty_{0}, regions_beyond_limit_{0},
      regions_shared_{0}, pool_allocated_{0};
};

}  // namespace

bool register_tensor_crop(GstPlugin* plugin) {
  return TensorCrop::register_in(plugin);
}

}  // namespace weir
