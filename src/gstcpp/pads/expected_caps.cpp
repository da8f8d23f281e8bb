// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/pads/expected_caps.hpp"

#include <utility>

namespace weir::gst {
namespace {

Ref<GstCaps> no_caps() {
  return Ref<GstCaps>::adopt(gst_caps_new_empty());
}

Ref<GstCaps> make_all(const GstCaps* offered, const ExpectedCaps::Make& make) {
  auto out = no_caps();
  for (guint i = 0; i < gst_caps_get_size(offered); ++i) {
    const auto input = Ref<GstCaps>::adopt(gst_caps_copy_nth(offered, i));
    if (gst_structure_has_field(gst_caps_get_structure(input.get(), 0), "framerate"))
      gst_caps_set_simple(input.get(), "framerate", GST_TYPE_FRACTION, 0, 1, nullptr);
    auto made = make(input.get());
    if (!made) return no_caps();
    out = Ref<GstCaps>::adopt(gst_caps_merge(out.release(), made.release()));
  }
  return out;
}

}  // namespace

Ref<GstCaps> ExpectedCaps::query(GstPad* sink, const GstCaps* filter, const Make& make) {
  const auto offered = Ref<GstCaps>::adopt(gst_pad_peer_query_caps(sink, nullptr));
  if (!offered) return no_caps();
  auto out = find(offered.get(), make);
  return filter ? Ref<GstCaps>::adopt(gst_caps_intersect_full(const_cast<GstCaps*>(filter),
                                                              out.get(), GST_CAPS_INTERSECT_FIRST))
                : out;
}

Ref<GstCaps> ExpectedCaps::find(const GstCaps* offered, const Make& make) {
  uint64_t forgotten = 0;
  {
    std::lock_guard lock(mutex_);
    forgotten = forgotten_;
    if (offered_ && gst_caps_is_strictly_equal(offered_.get(), offered))
      return Ref<GstCaps>::share(expected_.get());
  }
  auto out = make_all(offered, make);
  std::lock_guard lock(mutex_);
  if (forgotten != forgotten_) return out;
  offered_ = Ref<GstCaps>::share(const_cast<GstCaps*>(offered));
  expected_ = Ref<GstCaps>::share(out.get());
  return out;
}

void ExpectedCaps::forget() {
  std::lock_guard lock(mutex_);
  offered_ = {};
  expected_ = {};
  ++forgotten_;
}

}  // namespace weir::gst
