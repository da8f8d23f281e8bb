// ALLOCATION queries that never wait for another thread.
//
// A queue holds this query until its thread reaches it. While frames flow that thread may be
// waiting for frames that the querying thread brings: downstream of a tee, a tensor_mux holds the
// frame of one branch until the others have theirs. The two threads would deadlock.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "core/ledger/ledger.hpp"

namespace weir::gst {

// Whether the element has output a frame since it started; from then on a query may deadlock.
bool frames_flow(const Ledger& ledger);

// Sends the query downstream of `source` on the calling thread, up to elements that push from their
// own thread; those do not answer it. True when it was answered.
bool query_on_own_thread(GstPad* source, GstQuery* query);

// Applies this to the ALLOCATION queries that a base class sends from `source` while frames flow.
// Call it on the streaming thread; repeated calls are harmless. The ledger must outlive streaming.
void keep_queries_on_own_thread(GstPad* source, const Ledger* ledger);

}  // namespace weir::gst
