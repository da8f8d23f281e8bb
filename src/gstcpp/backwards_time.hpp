// The property on-backwards-time: its enum type, one for all elements that have it.
#pragma once
#include "core/sync/backwards_time.hpp"
#include "gstcpp/property.hpp"

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

}  // namespace weir::gst
