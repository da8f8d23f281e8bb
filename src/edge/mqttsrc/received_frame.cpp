// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/mqttsrc/received_frame.hpp"

#include <charconv>

#include "core/wire/mqtt_header.hpp"
#include "core/wire/peer_error.hpp"

namespace weir {
namespace {

template <class T>
bool read_number(std::string_view text, T* out) {
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), *out);
  return fault == std::errc{} && end == text.data() + text.size();
}

Error property_error(std::string_view name, std::string_view value) {
  return wire::peer_error("a user property of an MQTT 5 message cannot be used",
                          std::string(name) + "=" + wire::quoted_text(value),
                          "the properties that mqttsink protocol=5 sends");
}

// Leaves `out` alone without the property. False for a text that is not a number.
template <class T>
Status read_property(const transport::MqttProperties& properties, const char* name,
                     std::optional<T>* out) {
  const auto text = properties.find(name);
  if (!text) return ok();
  T value{};
  if (!read_number(*text, &value)) return property_error(name, *text);
  *out = value;
  return ok();
}

Status read_sizes(const transport::MqttMessage& message, MqttFrameHeader* out) {
  const auto text = message.properties.find("sizes");
  if (!text) {
    out->sizes = {message.payload.size()};
    return ok();
  }
  size_t left = message.payload.size();
  for (std::string_view rest = *text; !rest.empty();) {
    const size_t comma = std::min(rest.find(','), rest.size());
    size_t size = 0;
    if (!read_number(rest.substr(0, comma), &size) || size > left || out->sizes.size() == 256)
      return property_error("sizes", *text);
    left -= size;
    out->sizes.push_back(size);
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  return left == 0 ? ok() : Status(property_error("sizes", *text));
}

void set_times(const wire::MqttHeader& header, int64_t own_base_epoch, MqttFrameHeader* out) {
  const auto times = wire::times_of_receiver(header, own_base_epoch);
  out->on_time = times.has_value();
  out->duration = header.duration;
  if (!times) return;
  out->pts = times->pts;
  out->dts = times->dts;
}

}  // namespace

Result<MqttFrameHeader> frame_from_header(const transport::MqttMessage& message,
                                          int64_t own_base_epoch) {
  const auto header = wire::parse_mqtt_header(message.payload);
  if (!header) return header.error();
  const auto memories = wire::mqtt_memories(*header, message.payload);
  if (!memories) return memories.error();
  MqttFrameHeader out{.caps = header->caps,
                      .offset = wire::kMqttHeaderBytes,
                      .base_epoch = header->base_time_epoch,
                      .sent_epoch = header->sent_time_epoch};
  for (const auto& memory : *memories) out.sizes.push_back(memory.size());
  set_times(*header, own_base_epoch, &out);
  return out;
}

Result<MqttFrameHeader> frame_from_properties(const transport::MqttMessage& message,
                                              int64_t own_base_epoch) {
  const auto& properties = message.properties;
  const auto caps = properties.find("caps");
  if (!caps)
    return wire::peer_error("an MQTT 5 message has no caps", "no user property caps",
                            "the properties that mqttsink protocol=5 sends");
  MqttFrameHeader out{.caps = std::string(*caps)};
  std::optional<int64_t> base, sent;
  wire::MqttHeader header;
  for (const Status& status :
       {read_property(properties, "pts", &header.pts),
        read_property(properties, "dur", &header.duration),
        read_property(properties, "seq", &out.sequence),
        read_property(properties, "base-epoch", &base),
        read_property(properties, "sent-epoch", &sent), read_sizes(message, &out)})
    if (!status) return status.error();
  out.base_epoch = header.base_time_epoch = base.value_or(own_base_epoch);
  out.sent_epoch = header.sent_time_epoch = sent.value_or(own_base_epoch);
  set_times(header, own_base_epoch, &out);
  return out;
}

}  // namespace weir
