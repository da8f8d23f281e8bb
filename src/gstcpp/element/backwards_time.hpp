// The property on-backwards-time: the enum type shared by all elements that have it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>

#include "core/sync/backwards_time.hpp"
#include "gstcpp/element/error.hpp"
#include "gstcpp/element/property.hpp"

namespace weir::gst {

template <>
struct EnumType<OnBackwardsTime> {
  static GType type() {
    static const GEnumValue values[] = {
        {static_cast<int>(OnBackwardsTime::Pass), "Count it and pass the frame on", "pass"},
        {static_cast<int>(OnBackwardsTime::Drop), "Count it and drop the frame", "drop"},
        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirOnBackwardsTime", values);
    return t;
  }
};

// The policy of an element with one input: counts, warns once, passes or drops. With several
// clients, each client's stream has its own watch. Any thread may read the count.
class BackwardsTimes {
 public:
  // Applies to the frames that follow.
  void decide(OnBackwardsTime what) noexcept { what_ = what; }
  // Segments with a negative rate are not watched.
  void watch_segment(const GstSegment& segment) noexcept { forwards_ = segment.rate > 0; }
  // False when the frame's time goes backwards and the policy drops such frames.
  bool may_pass(GstElement* element, GstClockTime time, BackwardsTimeWatch* watch) {
    if (!GST_CLOCK_TIME_IS_VALID(time) || !forwards_) return true;
    const auto before = watch->check(time, what_);
    if (!before) return true;
    if (count_++ == 0) post_warning(element, backwards_time(time, *before, what_));
    return what_ == OnBackwardsTime::Pass;
  }
  uint64_t count() const noexcept { return count_; }
  void reset() noexcept { count_ = 0; }

 private:
  OnBackwardsTime what_ = OnBackwardsTime::Pass;
  bool forwards_ = true;
  std::atomic<uint64_t> count_{0};
};

}  // namespace weir::gst
