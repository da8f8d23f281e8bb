// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/request_watch.hpp"

#include <algorithm>
#include <deque>

#include "edge/request_meta.hpp"

namespace weir {
namespace {

using gst::Ref;

constexpr size_t kMaxPads = 256;

struct Entry {
  Ref<GstPad> pad;  // a sink pad
  Ref<GstElement> element;
  bool straight;  // no streams part or meet between the source and here
};

std::vector<Ref<GstPad>> source_pads(GstElement* element) {
  std::vector<Ref<GstPad>> out;
  gst_element_foreach_src_pad(
      element,
      [](GstElement*, GstPad* pad, gpointer list) -> gboolean {
        static_cast<std::vector<Ref<GstPad>>*>(list)->push_back(Ref<GstPad>::share(pad));
        return TRUE;
      },
      &out);
  return out;
}

size_t number_of_sink_pads(GstElement* element) {
  GST_OBJECT_LOCK(element);
  const auto out = element->numsinkpads;
  GST_OBJECT_UNLOCK(element);
  return out;
}

// "" if the element has no such property, or it is not a text.
std::string text_property(GstElement* element, const char* name) {
  const auto* spec = g_object_class_find_property(G_OBJECT_GET_CLASS(element), name);
  if (!spec || spec->value_type != G_TYPE_STRING) return "";
  char* raw = nullptr;
  g_object_get(G_OBJECT(element), name, &raw, nullptr);
  const gst::UniqueText text{raw};
  return raw ? raw : "";
}

struct Step {
  Ref<GstPad> from;
  bool straight;
};

// The pad that buffers of `from` arrive at, in a bin or out of it; null for an unlinked one.
Ref<GstPad> find_sink_pad(GstPad* from) {
  auto peer = Ref<GstPad>::adopt(gst_pad_get_peer(from));
  while (peer) {
    if (GST_IS_GHOST_PAD(peer.get())) {  // into a bin
      peer = Ref<GstPad>::adopt(gst_ghost_pad_get_target(GST_GHOST_PAD(peer.get())));
    } else if (GST_IS_PROXY_PAD(peer.get())) {  // out of a bin
      const auto ghost = Ref<GstObject>::adopt(gst_pad_get_parent(peer.get()));
      if (!ghost || !GST_IS_PAD(ghost.get())) return {};
      peer = Ref<GstPad>::adopt(gst_pad_get_peer(GST_PAD(ghost.get())));
    } else {
      return peer;
    }
  }
  return peer;
}

// The sink pads downstream of `source`. Loops end where they began.
std::vector<Entry> sink_pads_downstream(GstPad* source) {
  std::vector<Entry> out;
  std::deque<Step> todo{{Ref<GstPad>::share(source), true}};
  while (!todo.empty() && out.size() < kMaxPads) {
    auto [from, straight] = std::move(todo.front());
    todo.pop_front();
    auto pad = find_sink_pad(from.get());
    const auto element =
        Ref<GstElement>::adopt(pad ? gst_pad_get_parent_element(pad.get()) : nullptr);
    const auto known = [&](const auto& entry) { return entry.pad.get() == pad.get(); };
    if (!element || std::any_of(out.begin(), out.end(), known)) continue;
    auto next = source_pads(element.get());
    straight = straight && number_of_sink_pads(element.get()) == 1;
    out.push_back({std::move(pad), element, straight});
    straight = straight && next.size() <= 1;
    for (auto& source_pad : next) todo.push_back({std::move(source_pad), straight});
  }
  return out;
}

struct Watched {
  const char* element;
  bool drops;
};

GstPadProbeReturn on_buffer(GstPad*, GstPadProbeInfo* info, gpointer user) {
  const auto* watched = static_cast<const Watched*>(user);
  const auto request = get_request(GST_PAD_PROBE_INFO_BUFFER(info));
  if (!request) return GST_PAD_PROBE_OK;
  if (watched->drops && request->end_if_expired()) return GST_PAD_PROBE_DROP;
  allow_drop(GST_PAD_PROBE_INFO_BUFFER(info), watched->drops);
  request->entered(watched->element);
  return GST_PAD_PROBE_OK;
}

}  // namespace

void RequestWatch::start(GstPad* source) {
  stop();
  for (auto& entry : sink_pads_downstream(source)) {
    const gst::UniqueText name{gst_element_get_name(entry.element.get())};
    auto* watched = new Watched{g_intern_string(name.get()), entry.straight};
    const gulong id =
        gst_pad_add_probe(entry.pad.get(), GST_PAD_PROBE_TYPE_BUFFER, on_buffer, watched,
                          [](gpointer user) { delete static_cast<Watched*>(user); });
    probes_.push_back({std::move(entry.pad), id});
  }
}

void RequestWatch::stop() {
  for (const auto& probe : probes_) gst_pad_remove_probe(probe.pad.get(), probe.id);
  probes_.clear();
}

std::string property_downstream(GstPad* source, const char* name) {
  for (const auto& entry : sink_pads_downstream(source)) {
    if (!entry.straight) break;
    if (std::string text = text_property(entry.element.get(), name); !text.empty()) return text;
  }
  return "";
}

std::string property_upstream(GstPad* sink, const char* name) {
  auto pad = Ref<GstPad>::share(sink);
  for (size_t i = 0; i < kMaxPads; ++i) {
    const auto peer = Ref<GstPad>::adopt(gst_pad_get_peer(pad.get()));
    const auto element =
        Ref<GstElement>::adopt(peer ? gst_pad_get_parent_element(peer.get()) : nullptr);
    if (!element) return "";
    if (std::string text = text_property(element.get(), name); !text.empty()) return text;
    if (number_of_sink_pads(element.get()) != 1 || source_pads(element.get()).size() != 1)
      return "";
    pad = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "sink"));
    if (!pad) return "";
  }
  return "";
}

}  // namespace weir
