// RAII and conversions for libmosquitto.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <mosquitto.h>

#include <memory>
#include <string>

#include "transport/mqtt/mqtt_message.hpp"

namespace weir::transport {

struct DestroyMosquitto {
  void operator()(mosquitto* client) const { mosquitto_destroy(client); }
};
using Mosquitto = std::unique_ptr<mosquitto, DestroyMosquitto>;

struct FreeProperties {
  void operator()(mosquitto_property* list) const { mosquitto_property_free_all(&list); }
};
using PropertyList = std::unique_ptr<mosquitto_property, FreeProperties>;

// OPTION_VALUE for texts that are not UTF-8 or longer than 65535 bytes.
Result<PropertyList> to_property_list(const MqttProperties& properties);
MqttProperties properties_from_list(const mosquitto_property* list);

// A client with these options that has not connected. `user` is passed to its callbacks.
// FILE_NOT_FOUND and OPTION_VALUE for options that cannot be used.
Result<Mosquitto> make_mosquitto(const BrokerOptions& options, void* user);

Error broker_unreachable(const BrokerOptions& options, std::string offered);
Error broker_refused(const BrokerOptions& options, std::string what, std::string offered);

}  // namespace weir::transport
