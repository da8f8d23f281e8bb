// FrameTransformer: applies one transform operation to the chosen tensors of each frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <memory>
#include <optional>
#include <vector>

#include "core/ledger/ledger.hpp"
#include "core/transform/transform.hpp"
#include "gstcpp/deferred_memory.hpp"
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
  FrameTransformer(transform::Operation operation, TensorChoice choice, bool accelerate,
                   std::shared_ptr<gst::DeferredCounts> counts, const BufferLimit& limit)
      : operation_(std::move(operation)),
        choice_(std::move(choice)),
        accelerate_(accelerate),
        counts_(std::move(counts)),
        limit_(limit) {}

  // Before the first frame and whenever caps change.
  Status configure(const FrameSpec& input, const FrameSpec& output);
  // Whether frames can leave as deferred memory and be taken as such: a static stream of at most 16
  // tensors, all of them transformed element by element.
  bool can_fuse() const noexcept { return element_wise_; }
  // Whether views of tensors of a flexible stream can be taken: all of them are transformed element
  // by element.
  bool takes_views() const noexcept;
  // Whether frames leave as deferred memory from now on, until somebody maps one or configure() is
  // called. Precondition: can_fuse().
  void defer(bool wanted) noexcept;

  // Memory of outputs from now on; after configure(). OUT_OF_MEMORY or INTERNAL as FramePool.
  Status allocate_as(const gst::Allocation& allocation);
  const gst::Allocation& allocation() const noexcept { return allocation_; }

  // The buffer that run() will fill: `in` itself where the work can be done in place.
  // Metadata are not copied here.
  Result<gst::Ref<GstBuffer>> output_for(GstBuffer* in);
  struct Work {
    bool fused = false;     // with the work of the element before
    bool deferred = false;  // to the element behind
  };
  // Fills what output_for() gave for the same `in`, and corrects the ways back to the picture,
  // which came with the input's metadata.
  Result<Work> run(GstBuffer* in, GstBuffer* out, Ledger* ledger);
  uint64_t pool_allocated() const { return pool_.stats().allocated + view_buffers_; }

 private:
  void move_pictures(GstBuffer* out) const;
  using SharedPlan = std::shared_ptr<const transform::Plan>;
  struct Cached {
    TensorSpec input;
    TensorSpec output;
    SharedPlan plan;
    SharedPlan before, both;  // the last plan to fuse with; both: null when that is not possible
  };
  Status make_pool(std::vector<TensorSpec> outputs);
  Result<Cached*> plan_for(size_t index, const TensorSpec& spec);
  // Sources that do the work of the element before and this one's; empty where there are none.
  void find_fused_sources(GstBuffer* in);
  // The same for a flexible stream: each memory is a view.
  void find_views(GstBuffer* in);
  // Puts the plan of both into `source`; false where there is none.
  static bool fuse(Cached& cached, gst::DeferredSource* source);
  Result<gst::Ref<GstBuffer>> buffer_for_views();
  Status run_views(GstBuffer* out, Ledger* ledger);
  struct Appended {
    gst::MappedMemory map;
    size_t head = 0;
    std::span<std::byte> payload() const { return map.bytes().subspan(head); }
  };
  // A memory for a tensor of `bytes` at the end of `out`, its header written where one is wanted.
  Result<Appended> append_output(const TensorSpec& spec, size_t bytes, GstBuffer* out) const;
  bool may_defer(GstBuffer* in) const;
  Result<gst::Ref<GstBuffer>> deferred_output(GstBuffer* in);
  bool has_source_alone(GstBuffer* in) const;
  // What came into the element before, to become the output, or null: it is as large, and nobody
  // else's.
  gst::Ref<GstBuffer> take_source(GstBuffer* in);
  Status run_fused(GstBuffer* out, Ledger* ledger);
  Status run_alone(GstBuffer* in, GstBuffer* out, Ledger* ledger);
  Status run_pooled(GstBuffer* in, GstBuffer* out, Ledger* ledger);
  Status run_by_memory(GstBuffer* in, GstBuffer* out, Ledger* ledger);
  Status run_packed(GstBuffer* out, Ledger* ledger);
  Status append_transformed(size_t index, const gst::TensorView& view, GstBuffer* out,
                            Ledger* ledger);
  Status append_untouched(const gst::TensorView& view, GstBuffer* in, GstBuffer* out,
                          Ledger* ledger) const;
  bool headers_wanted() const noexcept { return output_.format != Format::Static; }

  transform::Operation operation_;
  TensorChoice choice_;
  bool accelerate_;
  std::shared_ptr<gst::DeferredCounts> counts_;
  const BufferLimit& limit_;  // borrowed from the element
  FrameSpec input_, output_;
  std::vector<std::optional<Cached>> plans_;  // by tensor index
  bool pooled_ = false;                       // static to static, every tensor transformed
  bool in_place_ = false;                     // and no element changes its size
  bool element_wise_ = false;                 // see can_fuse()
  bool defer_ = false;
  uint64_t computed_before_ = 0;  // counts_->computed when deferring began
  // Of the frame between output_for() and run(); without a buffer where it is the output itself.
  std::vector<gst::DeferredSource> sources_;
  Work work_;           // on that frame
  size_t tensors_ = 0;  // of that frame
  gst::Allocation allocation_;
  gst::FramePool pool_;
  std::vector<TensorSpec> view_specs_;     // outputs of the last frame of views
  gst::FramePool view_pool_;               // for such outputs
  bool views_pooled_ = false;              // the output in work is of view_pool_
  std::atomic<uint64_t> view_buffers_{0};  // that view_pool_ has made; read by any thread
  gst::FrameReader reader_;
  gst::FramePool::Writer writer_;
};

}  // namespace weir
