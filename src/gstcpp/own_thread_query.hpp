// ALLOCATION queries that wait for no other thread.
//
// GStreamer's queues hold this query until their thread has come to it. While frames flow that
// thread may be waiting for frames which the asking thread brings: behind a tee, a tensor_mux holds
// the frame of one branch until the others have theirs. Both would wait for ever.
#pragma once
#include <gst/gst.h>

#include "core/ledger/ledger.hpp"

namespace weir::gst {

// Whether a frame has left the element since it started: from then on a query may wait for ever.
bool frames_flow(const Ledger& ledger);

// Asks whoever is behind `source` on the calling thread, up to the elements that go on in a thread
// of their own. Those leave the query unanswered. True when it was answered.
bool query_on_own_thread(GstPad* source, GstQuery* query);

// From now on the ALLOCATION queries that a base class sends from `source` go that way while frames
// flow. Call it on the streaming thread; again is harmless. The ledger outlives the pad's
// streaming.
void keep_queries_on_own_thread(GstPad* source, const Ledger* ledger);

}  // namespace weir::gst
