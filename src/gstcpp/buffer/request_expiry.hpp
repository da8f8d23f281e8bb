// The part of the meta of a client's request that elements of other plug-ins use: to end
// a request whose client no longer waits.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>

namespace weir::gst {

inline constexpr char kRequestMetaApi[] = "WeirRequestMetaAPI";

// The first member of the meta, which the plug-in weiredge registers.
struct RequestMetaHead {
  GstMeta meta;
  // Ends the request if its client no longer waits for the response: true when it has ended.
  bool (*end_if_expired)(RequestMetaHead* self);
  // The element that has the buffer now may drop it: no stream parts or meets between the source
  // and here. Set before the buffer enters an element.
  std::atomic<bool> may_drop;
};

// The type of the meta; 0 while nothing is served. It is kept once it is registered, because GLib
// looks up names under a lock that all threads share.
inline GType request_meta_api() {
  static std::atomic<GType> known{0};
  GType api = known.load(std::memory_order_relaxed);
  if (api == 0) known.store(api = g_type_from_name(kRequestMetaApi), std::memory_order_relaxed);
  return api;
}

// Whether the buffer may be dropped because the client of its request no longer waits; the request
// has then ended. False for a buffer without a request.
inline bool end_if_expired(GstBuffer* buffer) {
  gpointer first = nullptr;
  if (!gst_buffer_iterate_meta(buffer, &first)) return false;
  const GType api = request_meta_api();
  auto* head = api ? reinterpret_cast<RequestMetaHead*>(gst_buffer_get_meta(buffer, api)) : nullptr;
  return head && head->may_drop && head->end_if_expired(head);
}

}  // namespace weir::gst
