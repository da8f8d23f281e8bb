// The models that pipelines of this process serve, by the property `id` with which a
// tensor_query_serversink finds its tensor_query_serversrc.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <memory>

#include "net/served_model.hpp"

namespace weir {

// OPTION_VALUE when another tensor_query_serversrc has the id.
Status add_pair(uint32_t id, const std::shared_ptr<net::ServedModel>& model);
void remove_pair(uint32_t id, const net::ServedModel& model);
// Null when no tensor_query_serversrc has the id.
std::shared_ptr<net::ServedModel> model_of_pair(uint32_t id);

}  // namespace weir
