// PlaceholderWait: handles caps that do not fit an element but may be a placeholder's.
//
// tensor_converter sends placeholder caps if the first frame defines the tensors of its stream. An
// element that checks caps passes the result to judged(): such caps are then rejected with the
// first frame, and events that must follow caps are kept until valid caps arrive.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <optional>
#include <utility>

#include "core/tensor/placeholder.hpp"
#include "gstcpp/element/ref.hpp"
#include "weir/result.hpp"

namespace weir::gst {

// Used on the streaming thread, or while not streaming.
class PlaceholderWait {
 public:
  // `status`: the result of negotiating caps of `spec`. Returns ok() if the error is kept for the
  // first frame.
  Status judged(const FrameSpec& spec, Status status) {
    refusal_.reset();
    if (status || !may_be_placeholder(spec)) return status;
    refusal_ = status.error();
    return ok();
  }
  // The error of each frame with the current caps; null if they were accepted.
  const Error* refusal() const noexcept { return refusal_ ? &*refusal_ : nullptr; }
  // Call with serialized events. True if it kept or dropped the event, because no caps were sent
  // yet.
  bool keeps(GstEvent* event) {
    const auto type = GST_EVENT_TYPE(event);
    if (type != GST_EVENT_SEGMENT && type != GST_EVENT_GAP) return false;
    if (!refusal_) return false;  // read only with serialized events
    auto taken = Ref<GstEvent>::adopt(event);
    if (type == GST_EVENT_SEGMENT) segment_ = std::move(taken);
    return true;
  }
  // Call after sending caps: returns the segment kept for them, or null.
  Ref<GstEvent> take_segment() { return std::exchange(segment_, {}); }
  void flush() { segment_ = {}; }
  void reset() {
    refusal_.reset();
    segment_ = {};
  }

 private:
  std::optional<Error> refusal_;
  Ref<GstEvent> segment_;
};

}  // namespace weir::gst
