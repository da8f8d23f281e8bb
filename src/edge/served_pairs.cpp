// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/served_pairs.hpp"

#include <map>
#include <mutex>

namespace weir {
namespace {

struct Pairs {
  std::mutex mutex;  // guards servers
  std::map<uint32_t, std::shared_ptr<QueryServer>> servers;
};

Pairs& pairs() {
  static auto& all = *new Pairs;  // threads may outlive static objects
  return all;
}

constexpr char kServerEvent[] = "WeirQueryServer";

}  // namespace

Status add_pair(uint32_t id, const std::shared_ptr<QueryServer>& server) {
  std::lock_guard lock(pairs().mutex);
  if (pairs().servers.emplace(id, server).second) return ok();
  return Error{
      .code = Code::OPTION_VALUE,
      .what = "another tensor_query_serversrc of this process has the same id",
      .offered = "id=" + std::to_string(id),
      .needed = "an id for each pair of tensor_query_serversrc and tensor_query_serversink",
      .fix = "id=" + std::to_string(id + 1) + " for both elements of a pair"};
}

void remove_pair(uint32_t id, const QueryServer& server) {
  std::lock_guard lock(pairs().mutex);
  const auto found = pairs().servers.find(id);
  if (found != pairs().servers.end() && found->second.get() == &server)
    pairs().servers.erase(found);
}

std::shared_ptr<QueryServer> server_of_pair(uint32_t id) {
  std::lock_guard lock(pairs().mutex);
  const auto found = pairs().servers.find(id);
  return found == pairs().servers.end() ? nullptr : found->second;
}

GstEvent* make_server_event() {
  return gst_event_new_custom(GST_EVENT_CUSTOM_DOWNSTREAM, gst_structure_new_empty(kServerEvent));
}

bool is_server_event(GstEvent* event) {
  return GST_EVENT_TYPE(event) == GST_EVENT_CUSTOM_DOWNSTREAM &&
         gst_event_has_name(event, kServerEvent);
}

}  // namespace weir
