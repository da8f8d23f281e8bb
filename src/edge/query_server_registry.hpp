// The servers of this process, by the property `id` with which a
// tensor_query_serversink finds its tensor_query_serversrc.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <memory>

#include "edge/query_server.hpp"

namespace weir {

// OPTION_VALUE when another tensor_query_serversrc has the id.
Status register_server(uint32_t id, const std::shared_ptr<QueryServer>& server);
void unregister_server(uint32_t id, const QueryServer& server);
// Null when no tensor_query_serversrc has the id.
std::shared_ptr<QueryServer> find_server(uint32_t id);

// A tensor_query_serversrc sends it downstream after its caps, so that tensor_query_serversink
// looks for its server.
GstEvent* make_server_event();
bool is_server_event(GstEvent* event);
// A tensor_query_serversrc sends it downstream after its caps, `input`, so that
// tensor_query_serversink reports to its server what is known of the responses before the first
// request.
gst::Ref<GstQuery> make_output_query(const GstCaps* input);
bool is_output_query(GstQuery* query);
Fraction get_input_rate(GstQuery* query);  // 0/1 if the caps had none

}  // namespace weir
