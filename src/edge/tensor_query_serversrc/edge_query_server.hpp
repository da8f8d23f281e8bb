// The server of a pair of tensor_query_serversrc and tensor_query_serversink that speaks
// NNStreamer's protocol of query elements.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <memory>

#include "edge/query_server.hpp"

namespace weir {

// Listens. `report`: called for each client that is refused; any thread. Errors: those of
// edge::QueryListener::open().
Result<std::shared_ptr<QueryServer>> open_edge_query_server(
    const ServersrcSettings& settings, std::function<void(const Error&)> report);

}  // namespace weir
