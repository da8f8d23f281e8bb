// Which threads feed a pad, as the links of the pipeline say; and pads that can never be fed.
#pragma once
#include <gst/gst.h>

#include <string>
#include <vector>

#include "gstcpp/ref.hpp"
#include "weir/result.hpp"

namespace weir::gst {

struct Feed {
  std::vector<Ref<GstPad>> threads;  // source pads with a task, each the start of a thread
  std::vector<std::string> path;     // elements that the thread passes, from the pad upstream
  bool known = true;                 // false: a source without a task is among them
};
// Up to the pads whose tasks push, queues among them.
Feed feed_of(GstPad* sink);

// Says of an element that it sends nothing before each of its sink pads got something.
void mark_waits_for_all(GstElement* element);
// GRAPH_STALLS when nothing can come to `sink` before `element` has sent something itself.
Status can_be_fed(GstElement* element, GstPad* sink);
// GRAPH_STALLS when `empty` can get nothing while `waiting` holds the thread that feeds both, or a
// pad through which all has to come that feeds both.
Status can_wait(GstElement* element, GstPad* waiting, GstPad* empty);

}  // namespace weir::gst
