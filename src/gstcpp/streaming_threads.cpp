// Walks upstream over the links inside and between elements.
#include "gstcpp/streaming_threads.hpp"

#include <algorithm>

#include "gstcpp/internal_links.hpp"

namespace weir::gst {
namespace {

std::string name_of(gpointer object) {
  const UniqueText text{gst_object_get_name(GST_OBJECT_CAST(object))};
  return text ? text.get() : "";
}

struct Walk {
  GstElement* element;
  bool through_queues;
  Feed feed;
  std::vector<GstPad*> seen;  // borrowed: links of a playing graph
  bool itself = false, others = false;

  void source(GstPad* pad) {
    const auto parent = Ref<GstElement>::adopt(gst_pad_get_parent_element(pad));
    if (parent) feed.path.push_back(name_of(parent.get()));
    if (parent.get() == element) {
      itself = true;
      if (through_queues) return;
    }
    const bool task = has_task(pad);
    if (task) feed.threads.push_back(Ref<GstPad>::share(pad));
    if (task && !through_queues) return;
    const auto sinks = linked_inside(pad);
    if (sinks.empty()) {
      others = true;
      feed.known = feed.known && task;
    }
    for (const auto& sink : sinks) up(sink.get());
  }
  void up(GstPad* sink) {
    if (std::find(seen.begin(), seen.end(), sink) != seen.end()) return;
    seen.push_back(sink);
    const auto peer = Ref<GstPad>::adopt(gst_pad_get_peer(sink));
    if (peer) return source(peer.get());
    others = true;
    feed.known = false;
  }
};

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

Error loop(const std::string& element, const std::string& pad) {
  return Error{Code::GRAPH_STALLS,
               "an element waits for its own output",
               pad + " of " + element + " is fed by nothing but " + element,
               "a loop is cut, so that its first frame is there",
               pad,
               "... ! tensor_reposink slot-index=0   tensor_reposrc slot-index=0 caps=... ! " +
                   element + "." + pad};
}

}  // namespace

Feed feed_of(GstElement* element, GstPad* sink) {
  Walk walk{element, false, {}, {}};
  walk.up(sink);
  Walk whole{element, true, {}, {}};
  whole.up(sink);
  walk.feed.from_itself = whole.itself && !whole.others;
  return walk.feed;
}

Status can_be_fed(GstElement* element, GstPad* sink) {
  if (!feed_of(element, sink).from_itself) return ok();
  return loop(name_of(element), name_of(sink));
}

Status can_wait(GstElement* element, GstPad* waiting, GstPad* empty) {
  const std::string name = name_of(element), first = name_of(waiting), second = name_of(empty);
  const Feed other = feed_of(element, empty);
  const Feed own = feed_of(element, waiting);
  const bool certain = own.known && other.known && own.threads.size() == 1 &&
                       other.threads.size() == 1 && own.threads[0].get() == other.threads[0].get();
  if (!certain) return ok();
  const std::string tee = meeting(own, other);
  return Error{
      Code::GRAPH_STALLS,
      "one thread feeds two pads that wait for each other",
      first + " and " + second + " of " + name + ", both fed through " + tee +
          " with no queue in between",
      "a queue in each branch",
      second + " can get nothing while " + first + " waits for it",
      branch(own, tee, name + "." + first) + "   " + branch(other, tee, name + "." + second)};
}

}  // namespace weir::gst
