// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/own_thread_query.hpp"

#include <algorithm>
#include <vector>

#include "gstcpp/element/internal_links.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::gst {
namespace {

struct Borders {
  std::vector<Ref<GstPad>> sinks;  // of elements that push from another thread
  std::vector<Ref<GstPad>> seen;

  void enter(const Ref<GstPad>& sink) {
    const auto same = [&](const Ref<GstPad>& pad) { return pad.get() == sink.get(); };
    if (std::any_of(seen.begin(), seen.end(), same)) return;
    seen.push_back(sink);
    const auto sources = linked_inside(sink.get());
    const auto other_thread = [](const Ref<GstPad>& pad) { return has_task(pad.get()); };
    if (std::any_of(sources.begin(), sources.end(), other_thread)) {
      sinks.push_back(sink);
      return;
    }
    for (const auto& source : sources) leave(source.get());
  }
  void leave(GstPad* source) {
    if (const auto peer = Ref<GstPad>::adopt(gst_pad_get_peer(source))) enter(peer);
  }
};

// Drops this thread's ALLOCATION queries at a pad for the lifetime of the object.
class Barrier {
 public:
  explicit Barrier(Ref<GstPad> pad) : pad_(std::move(pad)) {
    id_ = gst_pad_add_probe(pad_.get(), GST_PAD_PROBE_TYPE_QUERY_DOWNSTREAM, stop, g_thread_self(),
                            nullptr);
  }
  Barrier(Barrier&& other) noexcept
      : pad_(std::move(other.pad_)), id_(std::exchange(other.id_, 0)) {}
  Barrier& operator=(Barrier&&) = delete;
  ~Barrier() {
    if (id_ != 0) gst_pad_remove_probe(pad_.get(), id_);
  }

 private:
  static GstPadProbeReturn stop(GstPad*, GstPadProbeInfo* info, gpointer thread) {
    const bool ours = GST_QUERY_TYPE(GST_PAD_PROBE_INFO_QUERY(info)) == GST_QUERY_ALLOCATION &&
                      thread == g_thread_self();
    return ours ? GST_PAD_PROBE_DROP : GST_PAD_PROBE_OK;
  }

  Ref<GstPad> pad_;
  gulong id_ = 0;
};

GstPadProbeReturn take_over(GstPad* source, GstPadProbeInfo* info, gpointer ledger) {
  GstQuery* query = GST_PAD_PROBE_INFO_QUERY(info);
  const bool sent = (GST_PAD_PROBE_INFO_TYPE(info) & GST_PAD_PROBE_TYPE_PUSH) != 0;
  if (!sent || GST_QUERY_TYPE(query) != GST_QUERY_ALLOCATION ||
      !frames_flow(*static_cast<const Ledger*>(ledger)))
    return GST_PAD_PROBE_OK;
  return query_on_own_thread(source, query) ? GST_PAD_PROBE_HANDLED : GST_PAD_PROBE_DROP;
}

}  // namespace

bool frames_flow(const Ledger& ledger) {
  return ledger.snapshot().pushed > 0;
}

bool query_on_own_thread(GstPad* source, GstQuery* query) {
  const auto peer = Ref<GstPad>::adopt(gst_pad_get_peer(source));
  if (!peer) return false;
  Borders borders;
  borders.enter(peer);
  std::vector<Barrier> barriers;
  barriers.reserve(borders.sinks.size());
  for (const auto& sink : borders.sinks) barriers.emplace_back(sink);
  return gst_pad_query(peer.get(), query);
}

void keep_queries_on_own_thread(GstPad* source, const Ledger* ledger) {
  static const GQuark kept = g_quark_from_static_string("weir-queries-on-own-thread");
  if (g_object_get_qdata(G_OBJECT(source), kept)) return;
  g_object_set_qdata(G_OBJECT(source), kept, source);
  gst_pad_add_probe(source, GST_PAD_PROBE_TYPE_QUERY_DOWNSTREAM, take_over,
                    const_cast<Ledger*>(ledger), nullptr);
}

}  // namespace weir::gst
