// WeirMqttMeta: what a response to a message of MQTT 5 needs, from mqttsrc to mqttsink.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "transport/mqtt/mqtt_message.hpp"

namespace weir {

// A GstCustomMeta with the strings response-topic, correlation-data (hexadecimal digits) and
// traceparent, as far as `properties` has them. Adds none if it has none of them.
void set_mqtt_meta(GstBuffer* buffer, const transport::MqttProperties& properties);
// Adds what the buffer has to `properties`.
void read_mqtt_meta(GstBuffer* buffer, transport::MqttProperties* properties);

}  // namespace weir
