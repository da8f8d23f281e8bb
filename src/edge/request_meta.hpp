// RequestMeta: the request that a buffer belongs to. Copied with a buffer's metadata; the request
// ends as dropped when the last buffer with it goes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <memory>

#include "edge/query_server.hpp"

namespace weir {

// `buffer` must be writable and have no request. False when memory ran out.
bool set_request(GstBuffer* buffer, std::shared_ptr<QueryRequest> request);
// Null for a buffer without a request.
std::shared_ptr<QueryRequest> get_request(GstBuffer* buffer);
// Whether the element that the buffer enters may drop it when the client no longer waits
// (gstcpp/buffer/request_expiry.hpp).
void allow_drop(GstBuffer* buffer, bool allowed);

}  // namespace weir
