// EarlyEvents: serialized events that arrive before the stream can start downstream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "gstcpp/element/ref.hpp"

namespace weir::gst {

// Not thread-safe.
class EarlyEvents {
 public:
  // Keeps only the newest events of each type: downstream has not seen the older ones, and each
  // newer one repeats or replaces them (GAP, TAG, SEGMENT).
  static constexpr std::ptrdiff_t kMaxOfAType = 32;

  void push(Ref<GstEvent> event) {
    const auto same_type = [type = GST_EVENT_TYPE(event.get())](const Ref<GstEvent>& other) {
      return GST_EVENT_TYPE(other.get()) == type;
    };
    if (std::ranges::count_if(events_, same_type) == kMaxOfAType)
      events_.erase(std::ranges::find_if(events_, same_type));
    events_.push_back(std::move(event));
  }
  // Returns all events in order and empties the list.
  std::vector<Ref<GstEvent>> take() { return std::exchange(events_, {}); }
  void send(GstPad* source) {
    for (auto& event : take()) gst_pad_push_event(source, event.release());
  }
  void clear() { events_.clear(); }

 private:
  std::vector<Ref<GstEvent>> events_;
};

}  // namespace weir::gst
