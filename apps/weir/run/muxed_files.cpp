// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/muxed_files.hpp"

#include <algorithm>
#include <string_view>

#include "gstcpp/element/elements.hpp"
#include "run/element_properties.hpp"

namespace weir::app {
namespace {

std::vector<gst::Ref<GstPad>> to_pads(GstIterator* owned) {
  const gst::Unique<GstIterator, gst_iterator_free> all(owned);
  std::vector<gst::Ref<GstPad>> out;
  const auto add = +[](const GValue* item, gpointer list) {
    static_cast<std::vector<gst::Ref<GstPad>>*>(list)->push_back(
        gst::Ref<GstPad>::share(GST_PAD(g_value_get_object(item))));
  };
  while (all && gst_iterator_foreach(all.get(), add, &out) == GST_ITERATOR_RESYNC) {
    gst_iterator_resync(all.get());
    out.clear();
  }
  return out;
}

// splitmuxsink starts another file when its muxer alone gets EOS.
GstElement* find_outermost_muxer(GstElement* muxer) {
  GstElement* out = muxer;
  for (GstObject* bin = GST_OBJECT_PARENT(muxer); bin; bin = GST_OBJECT_PARENT(bin))
    if (get_class(GST_ELEMENT(bin)).find("Muxer") != std::string_view::npos) out = GST_ELEMENT(bin);
  return out;
}

bool has_finished(GstElement* sink) {
  const auto pads = to_pads(gst_element_iterate_sink_pads(sink));
  return std::all_of(pads.begin(), pads.end(),
                     [](const auto& pad) { return GST_PAD_IS_EOS(pad.get()); });
}

}  // namespace

bool is_muxer(GstElement* element) {
  return get_class(element).find("Codec/Muxer") != std::string_view::npos;
}

bool is_sink(GstElement* element) {
  return GST_OBJECT_FLAG_IS_SET(element, GST_ELEMENT_FLAG_SINK) && !GST_IS_BIN(element);
}

MuxedFiles::MuxedFiles(GstElement* pipeline) {
  std::set<GstPad*> visited;
  for (const auto& element : gst::elements_in(pipeline)) {
    if (!is_muxer(element.get())) continue;
    std::vector<std::string> elements{get_path(GST_OBJECT(element.get()))};
    for (const auto& pad : to_pads(gst_element_iterate_src_pads(element.get())))
      add(pad.get(), &elements, &visited);
    auto muxer = gst::Ref<GstElement>::share(find_outermost_muxer(element.get()));
    if (std::find(muxers_.begin(), muxers_.end(), muxer) == muxers_.end())
      muxers_.push_back(std::move(muxer));
  }
}

// Follows the stream of the source pad `source`, through bins too.
void MuxedFiles::add(GstPad* source, std::vector<std::string>* elements,
                     std::set<GstPad*>* visited) {
  const auto peer = gst::Ref<GstPad>::adopt(gst_pad_get_peer(source));
  if (!peer || !visited->insert(peer.get()).second) return;
  const auto element = gst::Ref<GstElement>::adopt(gst_pad_get_parent_element(peer.get()));
  if (element) elements->push_back(get_path(GST_OBJECT(element.get())));
  if (element && is_sink(element.get())) {
    if (GST_STATE(element.get()) == GST_STATE_PLAYING) files_.push_back({element, *elements});
  } else {
    for (const auto& next : to_pads(gst_pad_iterate_internal_links(peer.get())))
      add(next.get(), elements, visited);
  }
  if (element) elements->pop_back();
}

std::vector<std::string> MuxedFiles::unfinished(const std::set<std::string>& failed) const {
  std::vector<std::string> out;
  for (const auto& file : files_) {
    const bool is_cut = std::any_of(file.elements.begin(), file.elements.end(),
                                    [&](const auto& path) { return failed.contains(path); });
    if (!is_cut && !has_finished(file.sink.get())) out.push_back(file.elements.back());
  }
  return out;
}

bool MuxedFiles::contain(const std::string& path) const {
  return std::any_of(files_.begin(), files_.end(), [&path](const File& file) {
    return std::find(file.elements.begin(), file.elements.end(), path) != file.elements.end();
  });
}

// A pad takes EOS when its streaming thread has left it, and some wait for data at another pad.
void MuxedFiles::send_eos() const {
  for (const auto& muxer : muxers_)
    for (auto& pad : to_pads(gst_element_iterate_sink_pads(muxer.get())))
      gst_element_call_async(
          muxer.get(),
          [](GstElement*, gpointer pad) {
            gst_pad_send_event(static_cast<GstPad*>(pad), gst_event_new_eos());
          },
          pad.release(), gst_object_unref);
}

}  // namespace weir::app
