// FrameTransformer: applies one transform operation to the chosen tensors of each frame.
#pragma once
#include <gst/gst.h>

#include <optional>
#include <vector>

#include "core/ledger/ledger.hpp"
#include "core/transform/transform.hpp"
#include "gstcpp/frame_pool.hpp"
#include "gstcpp/frame_reader.hpp"

namespace weir {

// Which tensors of a frame are transformed; empty = all.
using TensorChoice = std::vector<size_t>;
bool chosen(const TensorChoice& choice, size_t index) noexcept;

// The tensors after the operation. Tensors that are not chosen stay as they are; parts that are
// unknown in the input (type or shape) stay unknown.
Result<std::vector<TensorSpec>> transformed(const transform::Operation& operation,
                                            const TensorChoice& choice,
                                            const std::vector<TensorSpec>& tensors);

class FrameTransformer {
 public:
  FrameTransformer(transform::Operation operation, TensorChoice choice, bool accelerate)
      : operation_(std::move(operation)), choice_(std::move(choice)), accelerate_(accelerate) {}

  // Before the first frame and whenever caps change.
  Status configure(const FrameSpec& input, const FrameSpec& output);
  // The buffer that run() will fill: `in` itself where the work can be done in place.
  // Metadata are not copied here.
  Result<gst::Ref<GstBuffer>> output_for(GstBuffer* in);
  Status run(GstBuffer* in, GstBuffer* out, Ledger* ledger);
  // Corrects the ways back to the picture, which came with the input's metadata.
  void move_pictures(GstBuffer* out) const;
  gst::FramePoolStats pool_stats() const { return pool_.stats(); }

 private:
  struct Cached {
    TensorSpec input;
    TensorSpec output;
    transform::Plan plan;
  };
  Result<const Cached*> plan_for(size_t index, const TensorSpec& spec);
  Status run_pooled(GstBuffer* in, GstBuffer* out, Ledger* ledger);
  Status run_by_memory(GstBuffer* in, GstBuffer* out, Ledger* ledger);
  Status append_transformed(size_t index, const gst::TensorView& view, GstBuffer* out,
                            Ledger* ledger);
  void append_untouched(const gst::TensorView& view, GstBuffer* in, GstBuffer* out, Ledger* ledger);
  bool headers_wanted() const noexcept { return output_.format != Format::Static; }

  transform::Operation operation_;
  TensorChoice choice_;
  bool accelerate_;
  FrameSpec input_, output_;
  std::vector<std::optional<Cached>> plans_;  // by tensor index
  bool pooled_ = false;                       // static to static, every tensor transformed
  bool in_place_ = false;                     // and no element changes its size
  gst::FramePool pool_;
  gst::FrameReader reader_;
  gst::FramePool::Writer writer_;
};

}  // namespace weir
