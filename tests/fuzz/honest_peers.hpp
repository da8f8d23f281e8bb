// Peers that keep to the rules. Each returns whether it was served, within a time limit.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <cstdint>
#include <string>

namespace weir::fuzz {

// Where the server is.
struct Place {
  uint16_t port = 0;
  std::string path;
  GstElement* pipeline = nullptr;
};

bool receives_stream(const Place& place);        // of edgesink
bool receives_local_stream(const Place& place);  // of edgesink protocol=local
bool queries(const Place& place);                // tensor_query_serversrc, which echoes
bool infers(const Place& place);                 // the same with protocol=oip
bool sends_tensors(const Place& place);          // to tensor_src_grpc in front of a fakesink "end"
bool receives_tensors(const Place& place);       // from tensor_sink_grpc
bool reads_metrics(const Place& place);          // of a page that says kHonestFrame

}  // namespace weir::fuzz
