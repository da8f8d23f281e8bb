// FrameTransformer: applies one transform operation to the chosen tensors of each frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/ledger/ledger.hpp"
#include "core/transform/transform.hpp"
#include "gstcpp/buffer/deferred_memory.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/buffer/frame_pool.hpp"

namespace weir {

// Which tensors of a frame are transformed; empty = all.
using TensorChoice = std::vector<size_t>;
bool chosen(const TensorChoice& choice, size_t index) noexcept;

// The tensors after the operation. Tensors that are not chosen stay unchanged; an unknown type or
// shape stays unknown.
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

  // Call before the first frame and when caps change.
  Status configure(const FrameSpec& input, const FrameSpec& output);
  // Whether frames can be output and accepted as deferred memory: a static stream of at most 16
  // tensors, all transformed element by element.
  bool can_fuse() const noexcept { return element_wise_; }
  // Whether deferred tensors of a flexible stream can be accepted: all are transformed element by
  // element.
  bool takes_views() const noexcept;
  // Whether frames are output as deferred memory, until one is mapped or configure() is called.
  // Precondition: can_fuse().
  void defer(bool wanted) noexcept;

  // Sets the allocation of outputs; call after configure(). OUT_OF_MEMORY or INTERNAL as FramePool.
  Status allocate_as(const gst::Allocation& allocation);
  const gst::Allocation& allocation() const noexcept { return allocation_; }

  // The buffer that run() will fill: `in` itself if the operation works in place. Does not copy
  // metadata.
  Result<gst::Ref<GstBuffer>> output_for(GstBuffer* in);
  struct Work {
    bool fused = false;     // with the upstream element's work
    bool deferred = false;  // to the downstream element
  };
  // Fills the buffer of output_for() for the same `in`, and corrects the source maps that came with
  // the input's metadata.
  Result<Work> run(GstBuffer* in, GstBuffer* out, Ledger* ledger);
  uint64_t pool_allocated() const { return pool_.stats().allocated + view_buffers_; }

 private:
  void move_pictures(GstBuffer* out) const;
  using SharedPlan = std::shared_ptr<const transform::TransformPlan>;
  struct Cached {
    TensorSpec input;
    TensorSpec output;
    SharedPlan plan;
    SharedPlan before, both;  // the last plan to fuse with; both: null if impossible
  };
  Status make_pool(std::vector<TensorSpec> outputs);
  // Whether `of`, which has that many tensors, has those that the user chose.
  Status check_choice(size_t tensors, const char* of) const;
  static void apply(const transform::TransformPlan& plan, std::span<const std::byte> in,
                    std::span<std::byte> out, Ledger* ledger);
  Result<Cached*> plan_for(size_t index, const TensorSpec& spec);
  // Finds sources with the combined work of the upstream element and this one; empty if there are
  // none.
  void find_fused_sources(GstBuffer* in);
  // The same for a flexible stream: each memory must be deferred.
  void find_views(GstBuffer* in);
  // Sets the fused plan of `source`; false if there is none.
  static bool fuse(Cached& cached, gst::DeferredSource* source);
  Result<gst::Ref<GstBuffer>> buffer_for_views();
  Status run_views(GstBuffer* out, Ledger* ledger);
  struct Appended {
    gst::MappedMemory map;
    size_t head = 0;
    std::span<std::byte> payload() const { return map.bytes().subspan(head); }
  };
  // Appends a memory for a tensor of `bytes` to `out`, with a header if the output needs one.
  Result<Appended> append_output(const TensorSpec& spec, size_t bytes, GstBuffer* out) const;
  bool may_defer(GstBuffer* in) const;
  Result<gst::Ref<GstBuffer>> deferred_output(GstBuffer* in);
  bool has_source_alone(GstBuffer* in) const;
  // The upstream element's input, reused as output, or null: it must have the same size and no
  // other owner.
  gst::Ref<GstBuffer> take_source(GstBuffer* in);
  Status run_fused(GstBuffer* out, Ledger* ledger);
  Status run_alone(GstBuffer* in, GstBuffer* out, Ledger* ledger);
  Status run_pooled(GstBuffer* in, GstBuffer* out, Ledger* ledger);
  Status run_by_memory(GstBuffer* in, GstBuffer* out, Ledger* ledger);
  Status run_packed(GstBuffer* out, Ledger* ledger);
  Status append_transformed(size_t index, const gst::TensorPlace& view, GstBuffer* out,
                            Ledger* ledger);
  Status append_untouched(const gst::TensorPlace& view, GstBuffer* in, GstBuffer* out,
                          Ledger* ledger) const;
  bool headers_wanted() const noexcept { return output_.format != Format::Static; }

  transform::Operation operation_;
  TensorChoice choice_;
  bool accelerate_;
  std::shared_ptr<gst::DeferredCounts> counts_;
  const BufferLimit& limit_;  // borrowed from the element
  FrameSpec input_, output_;
  std::vector<std::optional<Cached>> plans_;  // by tensor index
  bool pooled_ = false;                       // static to static, all tensors transformed
  bool in_place_ = false;                     // and all element sizes stay the same
  bool element_wise_ = false;                 // see can_fuse()
  bool defer_ = false;
  uint64_t computed_before_ = 0;  // counts_->computed when deferral began
  // For the frame between output_for() and run(); the buffer is null if it is the output itself.
  std::vector<gst::DeferredSource> sources_;
  Work work_;           // on the current frame
  size_t tensors_ = 0;  // of the current frame
  gst::Allocation allocation_;
  gst::FramePool pool_;
  std::vector<TensorSpec> view_specs_;     // outputs of the last frame of deferred tensors
  gst::FramePool view_pool_;               // for these outputs
  bool views_pooled_ = false;              // the current output is from view_pool_
  std::atomic<uint64_t> view_buffers_{0};  // allocated by view_pool_; read by any thread
  gst::FrameLayout reader_;
  gst::FramePool::Writer writer_;
};

}  // namespace weir
