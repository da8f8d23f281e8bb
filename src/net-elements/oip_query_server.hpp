// Registers the Open Inference Protocol for tensor_query_serversrc protocol=oip.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

namespace weir {

// Called when the plug-in weirnet is loaded.
void register_oip_query_server();

}  // namespace weir
