// tensor_split: sends each segment of a tensor on its own source pad.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/split/pick_list.hpp"
#include "core/split/segments.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/memory_part.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"
#include "gstcpp/pads/one_to_many.hpp"

namespace weir {
namespace {

using gst::Ref;

#define WEIR_ONE_TENSOR_CAPS \
  WEIR_CAPS_TENSOR "; other/tensors, format=(string)static, num_tensors=(int)1, " WEIR_CAPS_RATE

class TensorSplit : public gst::OneToMany<TensorSplit> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirTensorSplit", "tensor_split", "TensorSplit",
                                          "Demuxer/Tensor",
                                          "Sends each segment of a tensor to its own pad"};
  static constexpr const char* kSourceTemplate = "src_%u";
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_ONE_TENSOR_CAPS)),
      GST_STATIC_PAD_TEMPLATE("src_%u", GST_PAD_SRC, GST_PAD_SOMETIMES,
                              GST_STATIC_CAPS(WEIR_ONE_TENSOR_CAPS)),
  };

  struct Settings {
    bool silent = true;
    std::string tensorpick, tensorseg;
    int split_dim = -1;
    uint32_t split_parts = 0;
  };
  static constexpr std::tuple kProperties{
      gst::Property{"silent", &Settings::silent, "Accepted for compatibility; has no effect",
                    gst::Changeable::WhilePlaying},
      gst::Property{
          "tensorpick", &Settings::tensorpick,
          "Indices of the segments to output, always in the order of the segments; empty = all",
          gst::Changeable::WhilePlaying},
      gst::Property{"tensorseg", &Settings::tensorseg,
                    "Dimensions of each segment, as in 3:4:1,3:4:2; with split-dim also the sizes "
                    "along it, as in 1,2",
                    gst::Changeable::WhilePlaying},
      gst::Property{
          "split-dim", &Settings::split_dim,
          "Dimension to split along, 0 = the innermost; -1 = segments follow each other in memory",
          gst::Changeable::InReady, -1, 15},
      gst::Property{"split-parts", &Settings::split_parts,
                    "With split-dim: number of equal segments; 0 = as given by tensorseg",
                    gst::Changeable::InReady, 0u, G_MAXUINT},
  };

  Status prepare(const Settings& settings) {
    auto request = make_request(settings);
    if (!request) return request.error();
    request_ = *std::move(request);
    return ok();
  }
  Status check_change(const char*, const Settings& wanted) const {
    const auto request = make_request(wanted);
    return request ? ok() : Status(request.error());
  }
  // Pads without a segment stay, but get no more buffers.
  Status follow(const Settings& settings) {
    auto request = make_request(settings);
    if (!request) return request.error();
    const auto plan = plan_split(*request, input_);
    if (!plan) return plan.error();
    for (size_t i = 0; i < plan->segments.size(); ++i)
      if (auto status =
              outputs_.takes(i, FrameSpec{Format::Static, {plan->segments[i].spec}, spec_.rate});
          !status)
        return status;
    request_ = *std::move(request);
    outputs_.unsettle();
    return configure(FrameSpec(spec_));
  }
  static Result<SplitRequest> make_request(const Settings& settings) {
    auto segments = parse_segments(settings.tensorseg);
    if (!segments) return segments.error();
    auto picks = parse_index_list("tensorpick", settings.tensorpick, kPickSeparators);
    if (!picks) return picks.error();
    SplitRequest request{*std::move(segments), *std::move(picks), std::nullopt,
                         settings.split_parts};
    if (settings.split_dim >= 0) request.dimension = static_cast<size_t>(settings.split_dim);
    return request;
  }

  Status configure(const FrameSpec& spec) {
    spec_ = spec;
    branches_.clear();
    input_ = spec.tensors[0];
    auto plan = plan_split(request_, input_);
    if (!plan) return ok();  // the first frame gets the error: caps may be a placeholder's
    if (plan->left_over) gst::post_warning(element(), *plan->left_over);
    for (const auto& segment : plan->segments)
      branches_.push_back({segment, FrameSpec{Format::Static, {segment.spec}, spec.rate}, {}});
    outputs_.expect(branches_.size());
    return ok();
  }

  Result<gst::Routed> route(const Ref<GstBuffer>& buffer) {
    if (branches_.empty()) return plan_split(request_, input_).error();
    if (auto status = layout_.locate(buffer.get(), spec_); !status) return status.error();
    for (size_t i = 0; i < branches_.size(); ++i) outputs_.output(i);
    gst::Routed routed;
    for (size_t i = 0; i < branches_.size(); ++i) {
      auto& output = outputs_.output(i);
      if (!branches_[i].segment.dense() && !gst::SometimesPads::is_linked(output)) {
        routed.flow = outputs_.pass_over(&output);
        continue;
      }
      auto frame = make_frame(buffer.get(), &branches_[i], &output);
      if (!frame) return frame.error();
      routed.flow = push(&output, *std::move(frame));
      if (gst::SometimesPads::stops(routed.flow)) break;
    }
    return routed;
  }

  Settings settings_;
  gst::LiveSettings<Settings> followed_;  // streaming thread

 private:
  struct Branch {
    Segment segment;
    FrameSpec spec;       // of the pad
    gst::FramePool pool;  // for a segment that is not contiguous
  };

  Result<Ref<GstBuffer>> make_frame(GstBuffer* in, Branch* branch,
                                    gst::SometimesPads::Output* output) {
    if (const auto settled = outputs_.settle(output, branch->spec); !settled)
      return settled.error();
    auto frame = branch->segment.dense() ? shared(in, *branch) : gathered(in, branch);
    if (!frame) return frame;
    const auto maps = gst::source_maps(in);
    const auto of = gst::maps_of(in);
    if (!maps.empty())
      gst::set_source_maps(
          frame->get(), make_source_maps(branch->segment, input_, maps, of == gst::MapsOf::Regions),
          of);
    return frame;
  }

  Result<Ref<GstBuffer>> shared(GstBuffer* in, const Branch& branch) {
    uint64_t copied = 0;
    auto memory = gst::share_bytes(in, branch.segment.offset, branch.segment.block_bytes, &copied);
    if (!memory) return memory.error();
    if (copied > 0) ledger_.copied(copied);
    auto out = gst::buffer_like(in);
    gst_buffer_append_memory(out.get(), memory->release());
    return out;
  }

  Result<Ref<GstBuffer>> gathered(GstBuffer* in, Branch* branch) {
    if (!branch->pool) {
      auto pool = gst::FramePool::make(branch->spec.tensors, Format::Static);
      if (!pool) return pool.error();
      branch->pool = *std::move(pool);
    }
    auto acquired = branch->pool.acquire();
    if (!acquired) return acquired;
    auto out = *std::move(acquired);
    gst_buffer_copy_into(out.get(), in, GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
    const bool merged = gst_buffer_n_memory(in) > 1;
    const auto whole = gst::one_memory(in);
    if (!whole) return whole.error();
    const gst::MappedMemory from(whole->get(), GST_MAP_READ);
    if (!from) return gst::memory_not_mapped();
    gst::FramePool::Writer writer;
    if (auto status = writer.map(branch->pool, out.get()); !status) return status.error();
    copy_segment(branch->segment, from.bytes(), writer.payloads()[0]);
    ledger_.copied(writer.payloads()[0].size() + (merged ? from.bytes().size() : 0));
    return out;
  }

  // Streaming thread:
  SplitRequest request_;
  TensorSpec input_;
  std::vector<Branch> branches_;
  FrameSpec spec_;  // of the input
  gst::FrameLayout layout_;
};

}  // namespace

bool register_tensor_split(GstPlugin* plugin) {
  return TensorSplit::register_in(plugin);
}

}  // namespace weir
