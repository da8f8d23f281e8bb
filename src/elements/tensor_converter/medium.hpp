// Medium: one kind of input stream, as tensors. Each has a class of its own; tensor_converter picks
// it by the name of the caps and does what all share: time, chunks, headers, caps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/ledger/ledger.hpp"
#include "core/limit/buffer_limit.hpp"
#include "core/tensor/frame_spec.hpp"
#include "gstcpp/allocation.hpp"
#include "gstcpp/deferred_memory.hpp"
#include "gstcpp/ref.hpp"
#include "weir/picture_map.hpp"

namespace weir {

// What the user and the next element say about the tensors.
struct Wishes {
  std::vector<TensorSpec> tensors;  // input-dim and input-type; empty unless both are given
  std::vector<Shape> shapes;        // input-dim alone
  uint32_t frames_per_tensor = 1;
  std::vector<TensorSpec> peer;  // what the next element fixes; empty when it does not
  bool peer_is_flexible = false;
  const BufferLimit* limit = nullptr;  // of each output; the element's, which outlives the medium
};

// What a stream becomes, once its caps are known.
struct StreamPlan {
  FrameSpec spec;  // of each output, its rate that of the input; flexible: each frame says its own
  uint64_t frame_bytes = 0;  // of one frame of input; 0: each buffer is one frame of any size
  uint64_t frames_out = 1;   // frames in each output
  std::optional<PictureMap> picture;  // the way back from each output, where there is a picture
  // Neither the user nor downstream says what the tensors are: frames do, and `spec` may be a
  // placeholder.
  bool first_frame_decides = false;
};

struct MediumFrames {
  gst::Ref<GstBuffer> buffer;         // whole frames, dense; null: the medium drops them
  std::vector<TensorSpec> tensors{};  // of outputs of such frames when it says its own; else empty
  std::optional<Fraction> rate{};     // of the stream, where a frame says it
  std::optional<Error> warning{};     // to be told, for example that something was cut off
};

class Medium {
 public:
  virtual ~Medium() = default;
  // `caps` are fixed and have a name that the medium takes.
  virtual Result<StreamPlan> configure(const GstCaps* caps, const Wishes& wishes) = 0;
  // A buffer that is not empty; after configure. What must be copied is counted in `ledger`.
  virtual Result<MediumFrames> frames(gst::Ref<GstBuffer> buffer, Ledger* ledger) = 0;
  virtual MediaType type() const noexcept = 0;  // as headers of flexible tensors say it
  virtual void reset() noexcept {}              // after a flush
  // How memory that it allocates should be: what the next element asks for.
  virtual void allocate_as(const gst::Allocation&) {}
  // From now on frames may have deferred memory, that counts so; null: they may not.
  virtual void defer_with(std::shared_ptr<gst::DeferredCounts>) {}
  // Adds to the answer of an ALLOCATION query what only this medium can say.
  virtual void offer(GstQuery*) const {}
};

// The frame rate in the caps; 0/1 when they have none.
Fraction rate_of(const GstCaps* caps);
// What caps say until a first frame tells its tensors: what the user said, else what the next
// element fixes, else one uint8 of one element as a placeholder.
void plan_before_the_first(const Wishes& wishes, StreamPlan* plan);
// OPTION_VALUE when frames-per-tensor is more than 1; `what` cannot be gathered.
Status one_frame_each(const Wishes& wishes, const char* what);
// The tensors of one frame -> those of an output of `frames_per_tensor`. OPTION_VALUE where there
// are several.
Status gather(uint32_t frames_per_tensor, std::vector<TensorSpec>* tensors);
// SPEC_MISMATCH when the user said other tensors than the caps give.
Status agree(const FrameSpec& given, const std::vector<TensorSpec>& user, const char* medium);
// The same for one frame that says its own tensors.
Status agree(const std::vector<TensorSpec>& frame, const std::vector<TensorSpec>& user);
// FRAME_SIZE unless the buffer holds whole frames; `fix` may be "".
Status whole_frames(const GstBuffer* buffer, const StreamPlan& plan, const std::string& fix);

}  // namespace weir
