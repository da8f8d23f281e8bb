// Unlinks two pads in an idle probe.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "unlink.hpp"

#include <atomic>
#include <future>
#include <memory>

#include "gstcpp/element/ref.hpp"

namespace weir::soak {

bool unlink_between_frames(GstPad* source, GstPad* sink) {
  struct Cut {
    gst::Ref<GstPad> sink;
    std::promise<void> done;
    std::atomic<bool> made{false};
  };
  using Shared = std::shared_ptr<Cut>;
  const auto cut = std::make_shared<Cut>();
  cut->sink = gst::Ref<GstPad>::share(sink);
  auto done = cut->done.get_future();
  gst_pad_add_probe(
      source, GST_PAD_PROBE_TYPE_IDLE,
      [](GstPad* pad, GstPadProbeInfo*, gpointer data) {
        Cut& c = **static_cast<Shared*>(data);
        if (!c.made.exchange(true)) {
          gst_pad_unlink(pad, c.sink.get());
          c.done.set_value();
        }
        return GST_PAD_PROBE_REMOVE;
      },
      new Shared(cut), [](gpointer data) { delete static_cast<Shared*>(data); });
  return done.wait_for(kPatience) == std::future_status::ready;
}

}  // namespace weir::soak
