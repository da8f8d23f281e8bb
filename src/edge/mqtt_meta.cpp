// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/mqtt_meta.hpp"

namespace weir {
namespace {

constexpr char kName[] = "WeirMqttMeta";
constexpr char kDigits[] = "0123456789abcdef";

void register_once() {
  static const auto* const info = [] {
    static const gchar* tags[] = {nullptr};
    return gst_meta_register_custom(kName, tags, nullptr, nullptr, nullptr);
  }();
  (void)info;
}

std::string hexadecimal(const std::vector<std::byte>& bytes) {
  std::string out;
  for (const auto byte : bytes) {
    out += kDigits[std::to_integer<unsigned>(byte) >> 4];
    out += kDigits[std::to_integer<unsigned>(byte) & 15];
  }
  return out;
}

std::vector<std::byte> bytes_from(const char* text) {
  std::vector<std::byte> out;
  for (; text[0] && text[1]; text += 2)
    out.push_back(
        static_cast<std::byte>(g_ascii_xdigit_value(text[0]) << 4 | g_ascii_xdigit_value(text[1])));
  return out;
}

}  // namespace

void set_mqtt_meta(GstBuffer* buffer, const transport::MqttProperties& properties) {
  const auto trace = properties.find("traceparent");
  if (properties.response_topic.empty() && properties.correlation_data.empty() && !trace) return;
  register_once();
  GstCustomMeta* meta = gst_buffer_add_custom_meta(buffer, kName);
  if (!meta) return;
  GstStructure* fields = gst_custom_meta_get_structure(meta);
  const auto set = [&](const char* name, const std::string& value) {
    if (!value.empty()) gst_structure_set(fields, name, G_TYPE_STRING, value.c_str(), nullptr);
  };
  set("response-topic", properties.response_topic);
  set("correlation-data", hexadecimal(properties.correlation_data));
  if (trace) set("traceparent", std::string(*trace));
}

void read_mqtt_meta(GstBuffer* buffer, transport::MqttProperties* properties) {
  register_once();
  GstCustomMeta* meta = gst_buffer_get_custom_meta(buffer, kName);
  if (!meta) return;
  const GstStructure* fields = gst_custom_meta_get_structure(meta);
  if (const char* topic = gst_structure_get_string(fields, "response-topic"))
    properties->response_topic = topic;
  if (const char* data = gst_structure_get_string(fields, "correlation-data"))
    properties->correlation_data = bytes_from(data);
  if (const char* trace = gst_structure_get_string(fields, "traceparent"))
    properties->user.emplace_back("traceparent", trace);
}

}  // namespace weir
