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

constexpr char kServerEvent[] = "WeirQueryServer", kOutputQuery[] = "WeirQueryServerOutput",
               kRate[] = "framerate";

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

gst::Ref<GstQuery> make_output_query(const GstCaps* input) {
  // Serialized: a queue must not let it overtake the caps.
  constexpr int kNumber = 200;  // of GST_QUERY_CUSTOM, which is not serialized
  constexpr auto kType = static_cast<GstQueryType>(
      GST_QUERY_MAKE_TYPE(kNumber, GST_QUERY_TYPE_DOWNSTREAM | GST_QUERY_TYPE_SERIALIZED));
  GstStructure* content = gst_structure_new_empty(kOutputQuery);
  const GValue* rate = gst_structure_get_value(gst_caps_get_structure(input, 0), kRate);
  if (rate && GST_VALUE_HOLDS_FRACTION(rate)) gst_structure_set_value(content, kRate, rate);
  return gst::Ref<GstQuery>::adopt(gst_query_new_custom(kType, content));
}

bool is_output_query(GstQuery* query) {
  const GstStructure* content = gst_query_get_structure(query);
  return content && gst_structure_has_name(content, kOutputQuery);
}

Fraction get_input_rate(GstQuery* query) {
  int n = 0, d = 1;
  gst_structure_get_fraction(gst_query_get_structure(query), kRate, &n, &d);
  return {n, d};
}

}  // namespace weir
