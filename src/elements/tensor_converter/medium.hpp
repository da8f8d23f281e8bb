// Medium: converts one kind of input stream to tensors. tensor_converter selects the subclass by
// caps name and handles what all share: time, chunks, headers, caps.
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
#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/buffer/deferred_memory.hpp"
#include "gstcpp/element/ref.hpp"
#include "weir/source_map.hpp"

namespace weir {

// The tensors that properties and the peer specify.
struct Preferences {
  std::vector<TensorSpec> tensors;  // input-dim and input-type; empty unless both are given
  std::vector<Shape> shapes;        // input-dim alone
  uint32_t frames_per_tensor = 1;
  std::vector<TensorSpec> peer;  // fixed by the peer; empty if not fixed
  bool peer_is_flexible = false;
  const BufferLimit* limit = nullptr;  // of each output; the element owns it
};

// The output of a stream, derived from its caps.
struct StreamPlan {
  FrameSpec spec;            // of each output, at the input's rate; flexible: given by each frame
  uint64_t frame_bytes = 0;  // of one frame of input; 0: each buffer is one frame of any size
  uint64_t frames_out = 1;   // frames in each output
  std::optional<SourceMap> picture;  // maps each output to its picture, if any
  // Neither properties nor downstream fix the tensors: frames do, and `spec` may be a placeholder.
  bool first_frame_decides = false;
  std::optional<Error> warning = {};  // to be posted when these caps arrive
  // Frames may carry the stream's rate: that of `spec` may not be the final one.
  bool frames_have_rates = false;
};

struct MediumFrames {
  gst::Ref<GstBuffer> buffer;         // whole frames, dense; null: the medium drops them
  std::vector<TensorSpec> tensors{};  // of outputs, if frames carry their own; else empty
  std::optional<Fraction> rate{};     // if a frame carries the stream's rate
  std::optional<Error> warning{};     // to be posted, for example that data was cut off
  bool is_flexible = false;           // this frame makes the stream flexible
  bool has_headers = false;           // flexible: each memory begins with the header of its tensor
  gst::Ref<GstEvent> gap{};           // in the place of a frame that has a tensor without elements
};

class Medium {
 public:
  virtual ~Medium() = default;
  // `caps` are fixed and have a name that the medium supports.
  virtual Result<StreamPlan> configure(const GstCaps* caps, const Preferences& preferences) = 0;
  // Whether frames() can convert this buffer, as far as its size decides; call configure() first.
  virtual Status accepts(const GstBuffer*) const { return ok(); }
  // Converts a non-empty buffer; call configure() first. Copies are counted in `ledger`.
  virtual Result<MediumFrames> frames(gst::Ref<GstBuffer> buffer, Ledger* ledger) = 0;
  virtual MediaType type() const noexcept = 0;  // in the headers of flexible tensors
  virtual void reset() noexcept {}              // after a flush
  // Sets the allocation that the peer requested.
  virtual void allocate_as(const gst::Allocation&) {}
  // Allows deferred memory, counted in the argument; null: not allowed.
  virtual void defer_with(const std::shared_ptr<gst::DeferredCounts>&) {}
  // Adds this medium's proposals to the result of an ALLOCATION query.
  virtual void offer(GstQuery*) const {}
};

// The frame rate in the caps; 0/1 when they have none.
Fraction get_rate(const GstCaps* caps);
// Plans caps before the first frame defines the tensors: as the properties give them, else as the
// peer fixes them, else a placeholder of one uint8.
void plan_before_the_first(const Preferences& preferences, StreamPlan* plan);
// OPTION_VALUE when frames-per-tensor is above 1; `what` cannot be collected.
Status one_frame_each(const Preferences& preferences, const char* what);
// Changes the tensors of one frame to those of an output of `frames_per_tensor` frames.
// OPTION_VALUE if there are several.
Status gather(uint32_t frames_per_tensor, std::vector<TensorSpec>* tensors);
// SPEC_MISMATCH when the user's tensors differ from those of the caps.
Status agree(const FrameSpec& given, const std::vector<TensorSpec>& user, const char* medium);
// The same for a frame that carries its own specs.
Status agree(const std::vector<TensorSpec>& frame, const std::vector<TensorSpec>& user);
// FRAME_SIZE unless the buffer holds whole frames; `fix` may be "".
Status whole_frames(const GstBuffer* buffer, const StreamPlan& plan, const std::string& fix);

}  // namespace weir
