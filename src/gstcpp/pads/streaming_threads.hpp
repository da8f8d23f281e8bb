// Finds the threads that feed a pad, and pads that can never be fed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <optional>
#include <string>
#include <vector>

#include "gstcpp/element/ref.hpp"
#include "weir/result.hpp"

namespace weir::gst {

struct Feed {
  std::vector<Ref<GstPad>> threads;  // source pads with a task, each the start of a thread
  std::vector<std::string> path;     // elements on the way, from the pad upstream
  bool known = true;                 // false when a source without a task is among them
};
// Walks upstream to the pads whose tasks push, including queues.
Feed find_feed(GstPad* sink);
// The sink pad of the queue through which `thread` alone feeds `sink`, the first one where there
// are several in a row; null if there is none. nullopt if other threads feed `sink` too.
std::optional<Ref<GstPad>> queue_filled_by(const Ref<GstPad>& thread, GstPad* sink);

// Marks an element that pushes nothing until each of its sink pads has data.
void mark_waits_for_all(GstElement* element);
// GRAPH_STALLS when no data can reach `sink` before `element` itself has pushed.
Status can_be_fed(GstElement* element, GstPad* sink);
// GRAPH_STALLS when `empty` can get no data while `waiting` blocks the one thread that feeds both,
// or a pad that all data for both passes through.
Status can_wait(GstElement* element, GstPad* waiting, GstPad* empty);

// What `sink` needs before its element pushes.
struct Window {
  uint64_t duration = 0, buffers = 0;  // nanoseconds; 0 = not known
  uint64_t buffer_bytes = 0;           // of each buffer at `sink`; those at the tee may differ
};
// GRAPH_STALLS when a queue in another branch of a tee may be full before `sink` has the window:
// while the pipeline prerolls, nothing empties that queue, and the tee waits for it.
Status can_collect(GstElement* element, GstPad* sink, const Window& window);

}  // namespace weir::gst
