// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/pads/streaming_threads.hpp"

#include <algorithm>
#include <string_view>

#include "gstcpp/element/internal_links.hpp"

namespace weir::gst {
namespace {

std::string get_name(gpointer object) {
  const UniqueText text{gst_object_get_name(GST_OBJECT_CAST(object))};
  return text ? text.get() : "";
}

struct Walk {
  Feed feed;
  std::vector<GstPad*> seen;  // borrowed: links of a playing graph

  void source(GstPad* pad) {
    const auto parent = Ref<GstElement>::adopt(gst_pad_get_parent_element(pad));
    if (parent) feed.path.push_back(get_name(parent.get()));
    const bool task = has_task(pad);
    if (task) return feed.threads.push_back(Ref<GstPad>::share(pad));
    const auto sinks = linked_inside(pad);
    if (sinks.empty()) feed.known = false;
    for (const auto& sink : sinks) up(sink.get());
  }
  void up(GstPad* sink) {
    if (std::find(seen.begin(), seen.end(), sink) != seen.end()) return;
    seen.push_back(sink);
    const auto peer = Ref<GstPad>::adopt(gst_pad_get_peer(sink));
    if (peer) return source(peer.get());
    feed.known = false;
  }
};

GQuark waits_for_all_quark() {
  static const GQuark quark = g_quark_from_static_string("weir-waits-for-all-pads");
  return quark;
}

// Whether data can reach a pad before `element` has sent any. A stream whose origin is not visible
// counts as fed: a source, or a pad that may be linked later.
struct Start {
  GstElement* element;
  std::vector<GstPad*> visited, known;  // visited on this path; known to be fed; borrowed

  bool is_fed(GstPad* sink) {
    if (std::find(known.begin(), known.end(), sink) != known.end()) return true;
    const bool fed = has_start(sink);
    if (fed) known.push_back(sink);
    return fed;
  }
  bool has_start(GstPad* sink) {
    const auto peer = Ref<GstPad>::adopt(gst_pad_get_peer(sink));
    if (!peer) return true;
    const auto parent = Ref<GstElement>::adopt(gst_pad_get_parent_element(peer.get()));
    if (parent.get() == element || std::find(visited.begin(), visited.end(), sink) != visited.end())
      return false;
    const auto sinks = linked_inside(peer.get());
    if (sinks.empty()) return true;
    visited.push_back(sink);
    const auto fed = [this](const auto& one) { return is_fed(one.get()); };
    const bool all =
        parent && g_object_get_qdata(G_OBJECT(parent.get()), waits_for_all_quark()) != nullptr;
    const bool out = all ? std::all_of(sinks.begin(), sinks.end(), fed)
                         : std::any_of(sinks.begin(), sinks.end(), fed);
    visited.pop_back();
    return out;
  }
};

// The sink pads that all data to `sink` passes through, up to the start of a thread or a junction:
// a thread that pushes into `sink` holds the stream lock of each of them.
std::vector<Ref<GstPad>> only_way(GstPad* sink) {
  std::vector<Ref<GstPad>> out;
  for (auto at = Ref<GstPad>::share(sink);;) {
    const auto peer = Ref<GstPad>::adopt(gst_pad_get_peer(at.get()));
    if (!peer || has_task(peer.get())) return out;
    const auto before = linked_inside(peer.get());
    if (before.size() != 1 || std::find(out.begin(), out.end(), before[0]) != out.end()) return out;
    out.push_back(at = before[0]);
  }
}

bool meet(const std::vector<Ref<GstPad>>& a, const std::vector<Ref<GstPad>>& b) {
  return std::any_of(a.begin(), a.end(), [&b](const auto& pad) {
    return std::find(b.begin(), b.end(), pad) != b.end();
  });
}

std::string branch(const Feed& feed, const std::string& tee, const std::string& pad) {
  std::string text;
  for (const std::string& name : feed.path) {
    if (name == tee) break;
    text = name + " ! " + text;
  }
  return tee + ". ! queue ! " + text + pad;
}

std::string meeting(const Feed& a, const Feed& b) {
  for (const std::string& name : a.path)
    if (std::find(b.path.begin(), b.path.end(), name) != b.path.end()) return name;
  return "";
}

bool is_queue(GstElement* element) {
  GstElementFactory* const factory = gst_element_get_factory(element);
  return factory && std::string_view(GST_OBJECT_NAME(factory)) == "queue";
}

// Whether the queue is full before it holds the window.
bool is_too_short(GstElement* queue, const Window& window) {
  int leaky = 0;
  guint buffers = 0, bytes = 0;
  guint64 time = 0;
  g_object_get(queue, "leaky", &leaky, "max-size-buffers", &buffers, "max-size-bytes", &bytes,
               "max-size-time", &time, nullptr);
  // A queue takes one more buffer as long as it has less than max-size-bytes.
  const bool few_bytes =
      bytes > 0 && window.buffers > 0 && (window.buffers - 1) * window.buffer_bytes >= bytes;
  return leaky == 0 && ((time > 0 && time < window.duration) ||
                        (buffers > 0 && buffers < window.buffers) || few_bytes);
}

// Whether a sink downstream keeps its first buffer until all sinks have one.
struct Preroll {
  std::vector<GstPad*> seen;  // borrowed: links of a graph that starts

  bool is_awaited(GstPad* source) {
    if (std::find(seen.begin(), seen.end(), source) != seen.end()) return false;
    seen.push_back(source);
    const auto peer = Ref<GstPad>::adopt(gst_pad_get_peer(source));
    const auto element =
        Ref<GstElement>::adopt(peer ? gst_pad_get_parent_element(peer.get()) : nullptr);
    if (!element) return false;
    if (GST_OBJECT_FLAG_IS_SET(element.get(), GST_ELEMENT_FLAG_SINK)) {
      gboolean async = TRUE;
      if (g_object_class_find_property(G_OBJECT_GET_CLASS(element.get()), "async"))
        g_object_get(element.get(), "async", &async, nullptr);
      return async;
    }
    const auto next = linked_inside(peer.get());
    return std::any_of(next.begin(), next.end(),
                       [this](const auto& pad) { return is_awaited(pad.get()); });
  }
};

bool prerolls(GstPad* source) {
  return Preroll{}.is_awaited(source);
}

// A queue in another branch of the element of `source` that cannot hold the window; null: none.
Ref<GstElement> short_queue_beside(GstPad* source, const Window& window) {
  for (const auto& input : linked_inside(source))
    for (const auto& other : linked_inside(input.get())) {
      const auto peer = Ref<GstPad>::adopt(gst_pad_get_peer(other.get()));
      auto element =
          Ref<GstElement>::adopt(peer ? gst_pad_get_parent_element(peer.get()) : nullptr);
      if (other.get() != source && element && is_queue(element.get()) &&
          is_too_short(element.get(), window) && prerolls(other.get()))
        return element;
    }
  return {};
}

bool is_live(GstPad* sink) {
  const auto query = Ref<GstQuery>::adopt(gst_query_new_latency());
  gboolean live = FALSE;
  if (gst_pad_peer_query(sink, query.get()))
    gst_query_parse_latency(query.get(), &live, nullptr, nullptr);
  return live;
}

Error loop(const std::string& element, const std::string& pad) {
  return Error{
      .code = Code::GRAPH_STALLS,
      .what = "an element waits for its own output",
      .offered =
          pad + " of " + element + " receives nothing before " + element + " has sent something",
      .needed = "a tensor_reposrc in the loop, which produces the first frame",
      .difference = pad,
      .fix = "... ! tensor_reposink slot-index=0   tensor_reposrc slot-index=0 caps=... ! " +
             element + "." + pad};
}

}  // namespace

void mark_waits_for_all(GstElement* element) {
  g_object_set_qdata(G_OBJECT(element), waits_for_all_quark(), element);
}

Feed find_feed(GstPad* sink) {
  Walk walk;
  walk.up(sink);
  return walk.feed;
}

std::optional<Ref<GstPad>> queue_filled_by(const Ref<GstPad>& thread, GstPad* sink) {
  constexpr size_t kMaxQueues = 16;
  Ref<GstPad> queue;
  for (size_t i = 0; i <= kMaxQueues; ++i) {
    const auto feed = find_feed(queue ? queue.get() : sink);
    if (!feed.known || feed.threads.size() != 1) return std::nullopt;
    if (feed.threads[0] == thread) return queue;
    const auto inputs = linked_inside(feed.threads[0].get());
    if (inputs.size() != 1) return std::nullopt;
    queue = inputs[0];
  }
  return std::nullopt;
}

Status can_be_fed(GstElement* element, GstPad* sink) {
  Start start{element, {}, {}};
  return start.is_fed(sink) ? ok() : Status(loop(get_name(element), get_name(sink)));
}

Status can_collect(GstElement* element, GstPad* sink, const Window& window) {
  if (GST_STATE(element) == GST_STATE_PLAYING || is_live(sink)) return ok();
  const auto sources = linked_inside(sink);
  if (std::none_of(sources.begin(), sources.end(), [](const auto& p) { return prerolls(p.get()); }))
    return ok();
  std::vector<Ref<GstPad>> seen;
  for (auto at = Ref<GstPad>::share(sink);;) {
    const auto peer = Ref<GstPad>::adopt(gst_pad_get_peer(at.get()));
    if (!peer) return ok();
    if (const auto queue = short_queue_beside(peer.get(), window)) {
      const std::string time = std::to_string(2 * window.duration);
      return Error{
          .code = Code::GRAPH_STALLS,
          .what =
              "the pipeline may stall at its start: a window is longer than a queue "
              "in another branch of its tee",
          .offered = get_name(queue.get()) + " beside " + get_name(element) + ", which collects " +
                     std::to_string(window.buffers) + " buffers of " +
                     std::to_string(window.duration / GST_MSECOND) + " ms and " +
                     std::to_string(window.buffers * window.buffer_bytes) + " bytes",
          .needed = "a queue that holds the window until the pipeline has prerolled",
          .difference = "the tee may wait for " + get_name(queue.get()) + ", which is full",
          .fix = "queue name=" + get_name(queue.get()) +
                 " max-size-buffers=0 max-size-bytes=0 max-size-time=" + time};
    }
    const auto before = linked_inside(peer.get());
    if (before.size() != 1 || std::find(seen.begin(), seen.end(), before[0]) != seen.end())
      return ok();
    seen.push_back(at = before[0]);
  }
}

Status can_wait(GstElement* element, GstPad* waiting, GstPad* empty) {
  const std::string name = get_name(element), first = get_name(waiting), second = get_name(empty);
  const Feed other = find_feed(empty);
  const Feed own = find_feed(waiting);
  const bool one_thread = own.known && other.known && own.threads.size() == 1 &&
                          other.threads.size() == 1 &&
                          own.threads[0].get() == other.threads[0].get();
  // Also stalls where several threads push one at a time: downstream of another muxer.
  if (!one_thread && !meet(only_way(waiting), only_way(empty))) return ok();
  const std::string tee = meeting(own, other);
  return Error{.code = Code::GRAPH_STALLS,
               .what = "one thread feeds two pads that wait for each other",
               .offered = first + " and " + second + " of " + name + ", both fed through " + tee +
                          " with no queue in between",
               .needed = "a queue in each branch",
               .difference = second + " cannot receive data while " + first + " waits for it",
               .fix = branch(own, tee, name + "." + first) + "   " +
                      branch(other, tee, name + "." + second)};
}

}  // namespace weir::gst
