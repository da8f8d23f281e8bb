// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/query_server_registry.hpp"

#include <map>
#include <mutex>

namespace weir {
namespace {

struct Registry {
  std::mutex mutex;  // guards servers
  std::map<uint32_t, std::shared_ptr<QueryServer>> servers;
};

Registry& registry() {
  static auto& all = *new Registry;  // threads may outlive static objects
  return all;
}

constexpr char kServerEvent[] = "WeirQueryServer", kOutputQuery[] = "WeirQueryServerOutput";

}  // namespace

Status register_server(uint32_t id, const std::shared_ptr<QueryServer>& server) {
  std::lock_guard lock(registry().mutex);
  if (registry().servers.emplace(id, server).second) return ok();
  return Error{
      .code = Code::OPTION_VALUE,
      .what = "another tensor_query_serversrc of this process has the same id",
      .offered = "id=" + std::to_string(id),
      .needed = "an id for each pair of tensor_query_serversrc and tensor_query_serversink",
      .fix = "id=" + std::to_string(id + 1) + " for both elements of a pair"};
}

void unregister_server(uint32_t id, const QueryServer& server) {
  std::lock_guard lock(registry().mutex);
  const auto found = registry().servers.find(id);
  if (found != registry().servers.end() && found->second.get() == &server)
    registry().servers.erase(found);
}

std::shared_ptr<QueryServer> find_server(uint32_t id) {
  std::lock_guard lock(registry().mutex);
  const auto found = registry().servers.find(id);
  return found == registry().servers.end() ? nullptr : found->second;
}

GstEvent* make_server_event() {
  return gst_event_new_custom(GST_EVENT_CUSTOM_DOWNSTREAM, gst_structure_new_empty(kServerEvent));
}

bool is_server_event(GstEvent* event) {
  return GST_EVENT_TYPE(event) == GST_EVENT_CUSTOM_DOWNSTREAM &&
         gst_event_has_name(event, kServerEvent);
}

gst::Ref<GstQuery> make_output_query() {
  return gst::Ref<GstQuery>::adopt(
      gst_query_new_custom(GST_QUERY_CUSTOM, gst_structure_new_empty(kOutputQuery)));
}

bool is_output_query(GstQuery* query) {
  return GST_QUERY_TYPE(query) == GST_QUERY_CUSTOM &&
         gst_structure_has_name(gst_query_get_structure(query), kOutputQuery);
}

}  // namespace weir
