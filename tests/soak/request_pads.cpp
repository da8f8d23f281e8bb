// Creates and removes paths: tee -> queue -> request pad.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "request_pads.hpp"

#include <atomic>
#include <future>

#include "unlink.hpp"

namespace weir::soak {

using gst::Ref;

namespace {
struct FirstFrame {
  std::atomic<bool> came{false};
  std::promise<void> reported;
};
}  // namespace

RequestPads::RequestPads(GstElement* tee, GstElement* element)
    : pipeline_(Ref<GstElement>::adopt(GST_ELEMENT(gst_object_get_parent(GST_OBJECT(tee))))),
      tee_(Ref<GstElement>::share(tee)),
      element_(Ref<GstElement>::share(element)) {}

// Requests the element's pad only when a frame is waiting. A tensor_mux waits for each of its pads,
// and meanwhile the other queues may fill up and block the tee before that frame.
std::string RequestPads::add() {
  Way way;
  way.queue = Ref<GstElement>::adopt(
      GST_ELEMENT(gst_object_ref_sink(gst_element_factory_make("queue", nullptr))));
  gst_bin_add(GST_BIN(pipeline_.get()), way.queue.get());
  gst_element_sync_state_with_parent(way.queue.get());
  const auto out = Ref<GstPad>::adopt(gst_element_get_static_pad(way.queue.get(), "src"));
  const auto in = Ref<GstPad>::adopt(gst_element_get_static_pad(way.queue.get(), "sink"));
  FirstFrame first;
  const gulong probe = gst_pad_add_probe(
      out.get(), GstPadProbeType(GST_PAD_PROBE_TYPE_BLOCK | GST_PAD_PROBE_TYPE_BUFFER),
      [](GstPad*, GstPadProbeInfo*, gpointer data) {
        auto& f = *static_cast<FirstFrame*>(data);
        if (!f.came.exchange(true)) f.reported.set_value();
        return GST_PAD_PROBE_OK;
      },
      &first, nullptr);
  way.tee_pad = Ref<GstPad>::adopt(gst_element_request_pad_simple(tee_.get(), "src_%u"));
  gst_pad_link(way.tee_pad.get(), in.get());
  const bool came = first.reported.get_future().wait_for(kPatience) == std::future_status::ready;
  way.request_pad = Ref<GstPad>::adopt(gst_element_request_pad_simple(element_.get(), "sink_%u"));
  gst_pad_link(out.get(), way.request_pad.get());
  gst_pad_remove_probe(out.get(), probe);
  ways_.push_back(std::move(way));
  return came ? "" : "no frame arrives from a new pad of the tee\n";
}

std::string RequestPads::remove(size_t index) {
  const Way way = std::move(ways_[index]);
  ways_.erase(ways_.begin() + static_cast<std::ptrdiff_t>(index));
  const auto in = Ref<GstPad>::adopt(gst_element_get_static_pad(way.queue.get(), "sink"));
  if (!unlink_between_frames(way.tee_pad.get(), in.get())) return "the tee never rests\n";
  // The element first: the queue's thread may be waiting there for its frame to be accepted.
  gst_element_release_request_pad(element_.get(), way.request_pad.get());
  gst_element_set_locked_state(way.queue.get(), TRUE);
  gst_element_set_state(way.queue.get(), GST_STATE_NULL);
  gst_bin_remove(GST_BIN(pipeline_.get()), way.queue.get());
  gst_element_release_request_pad(tee_.get(), way.tee_pad.get());
  return "";
}

}  // namespace weir::soak
