// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/mqtt/mosquitto_handle.hpp"

#include <mqtt_protocol.h>
#include <unistd.h>

#include <cstdlib>
#include <mutex>

namespace weir::transport {
namespace {

struct FreeMosquitto {
  void operator()(void* memory) const { std::free(memory); }
};
using Text = std::unique_ptr<char, FreeMosquitto>;

std::string read_string(const mosquitto_property* property, int id) {
  char* raw = nullptr;
  mosquitto_property_read_string(property, id, &raw, false);
  const Text text(raw);
  return raw ? raw : "";
}

void read_user_property(const mosquitto_property* property, MqttProperties* out) {
  char *raw_name = nullptr, *raw_value = nullptr;
  mosquitto_property_read_string_pair(property, MQTT_PROP_USER_PROPERTY, &raw_name, &raw_value,
                                      false);
  const Text name(raw_name), value(raw_value);
  if (raw_name && raw_value) out->user.emplace_back(raw_name, raw_value);
}

void read_correlation_data(const mosquitto_property* property, MqttProperties* out) {
  void* raw = nullptr;
  uint16_t length = 0;
  mosquitto_property_read_binary(property, MQTT_PROP_CORRELATION_DATA, &raw, &length, false);
  const std::unique_ptr<void, FreeMosquitto> data(raw);
  const auto* bytes = static_cast<const std::byte*>(raw);
  if (raw) out->correlation_data.assign(bytes, bytes + length);
}

Status check_file(const std::string& path, const char* property) {
  if (path.empty() || access(path.c_str(), R_OK) == 0) return ok();
  return Error{.code = Code::FILE_NOT_FOUND,
               .what = std::string("the file of the property ") + property + " cannot be read",
               .offered = path,
               .needed = "a PEM file",
               .fix = std::string(property) + "=/path/to/file.pem"};
}

Error tls_error(int reason) {
  return {.code = Code::OPTION_VALUE,
          .what = "the properties for TLS cannot be used",
          .offered = mosquitto_strerror(reason),
          .needed =
              "tls-ca with tls-cert and tls-key, or psk (hexadecimal digits) with "
              "psk-identity",
          .fix = "tls-ca=ca.pem"};
}

Status set_tls(mosquitto* client, const BrokerTls& tls) {
  if (!tls.psk.empty() || !tls.psk_identity.empty()) {
    const bool both = !tls.psk.empty() && !tls.psk_identity.empty();
    const int result =
        both && tls.ca.empty()
            ? mosquitto_tls_psk_set(client, tls.psk.c_str(), tls.psk_identity.c_str(), nullptr)
            : MOSQ_ERR_INVAL;
    return result == MOSQ_ERR_SUCCESS ? ok() : Status(tls_error(result));
  }
  if (!tls.is_enabled())
    return tls.cert.empty() && tls.key.empty() ? ok() : Status(tls_error(MOSQ_ERR_INVAL));
  if (tls.cert.empty() != tls.key.empty()) return tls_error(MOSQ_ERR_INVAL);
  for (const auto& [path, property] : {std::pair(tls.ca, "tls-ca"), std::pair(tls.cert, "tls-cert"),
                                       std::pair(tls.key, "tls-key")})
    if (auto status = check_file(path, property); !status) return status;
  const auto or_null = [](const std::string& text) {
    return text.empty() ? nullptr : text.c_str();
  };
  int result = MOSQ_ERR_SUCCESS;
  if (tls.ca.empty()) result = mosquitto_int_option(client, MOSQ_OPT_TLS_USE_OS_CERTS, 1);
  if (result == MOSQ_ERR_SUCCESS)
    result = mosquitto_tls_set(client, or_null(tls.ca), tls.ca.empty() ? "/etc/ssl/certs" : nullptr,
                               or_null(tls.cert), or_null(tls.key), nullptr);
  return result == MOSQ_ERR_SUCCESS ? ok() : Status(tls_error(result));
}

Error option_error(int reason) {
  return {.code = Code::OPTION_VALUE,
          .what = "the properties for the broker cannot be used",
          .offered = mosquitto_strerror(reason),
          .needed = "UTF-8 text, and a last will of at most 256 MiB",
          .fix = "check client-id, user and password"};
}

}  // namespace

Result<PropertyList> to_property_list(const MqttProperties& properties) {
  mosquitto_property* list = nullptr;
  int result = MOSQ_ERR_SUCCESS;
  const auto add = [&](auto&& function, auto... values) {
    if (result == MOSQ_ERR_SUCCESS) result = function(&list, values...);
  };
  if (!properties.content_type.empty())
    add(mosquitto_property_add_string, MQTT_PROP_CONTENT_TYPE, properties.content_type.c_str());
  if (properties.expiry)
    add(mosquitto_property_add_int32, MQTT_PROP_MESSAGE_EXPIRY_INTERVAL, *properties.expiry);
  if (!properties.response_topic.empty())
    add(mosquitto_property_add_string, MQTT_PROP_RESPONSE_TOPIC, properties.response_topic.c_str());
  if (!properties.correlation_data.empty())
    add(mosquitto_property_add_binary, MQTT_PROP_CORRELATION_DATA,
        static_cast<const void*>(properties.correlation_data.data()),
        static_cast<uint16_t>(properties.correlation_data.size()));
  for (const auto& [name, value] : properties.user)
    add(mosquitto_property_add_string_pair, MQTT_PROP_USER_PROPERTY, name.c_str(), value.c_str());
  PropertyList out(list);
  if (result == MOSQ_ERR_SUCCESS) return out;
  return Error{.code = Code::OPTION_VALUE,
               .what = "a property of an MQTT message cannot be sent",
               .offered = mosquitto_strerror(result),
               .needed = "at most 65535 bytes of UTF-8",
               .fix = "shorten the caps"};
}

MqttProperties properties_from_list(const mosquitto_property* list) {
  MqttProperties out;
  for (; list; list = mosquitto_property_next(list)) {
    switch (mosquitto_property_identifier(list)) {
      case MQTT_PROP_CONTENT_TYPE:
        out.content_type = read_string(list, MQTT_PROP_CONTENT_TYPE);
        break;
      case MQTT_PROP_RESPONSE_TOPIC:
        out.response_topic = read_string(list, MQTT_PROP_RESPONSE_TOPIC);
        break;
      case MQTT_PROP_CORRELATION_DATA:
        read_correlation_data(list, &out);
        break;
      case MQTT_PROP_MESSAGE_EXPIRY_INTERVAL:
        out.expiry.emplace();
        mosquitto_property_read_int32(list, MQTT_PROP_MESSAGE_EXPIRY_INTERVAL, &*out.expiry, false);
        break;
      case MQTT_PROP_USER_PROPERTY:
        read_user_property(list, &out);
        break;
      default:
        break;
    }
  }
  return out;
}

Result<Mosquitto> make_mosquitto(const BrokerOptions& options, void* user) {
  static std::once_flag once;
  std::call_once(once, [] { mosquitto_lib_init(); });
  Mosquitto client(mosquitto_new(options.client_id.c_str(), options.clean_session, user));
  if (!client) return option_error(MOSQ_ERR_MALFORMED_UTF8);
  const bool v5 = options.version == MqttVersion::V5;
  int result = mosquitto_threaded_set(client.get(), true);
  const auto set = [&](mosq_opt_t option, int value) {
    if (result == MOSQ_ERR_SUCCESS) result = mosquitto_int_option(client.get(), option, value);
  };
  set(MOSQ_OPT_PROTOCOL_VERSION, v5 ? MQTT_PROTOCOL_V5 : MQTT_PROTOCOL_V311);
  set(MOSQ_OPT_TCP_NODELAY, 1);
  if (v5) set(MOSQ_OPT_RECEIVE_MAXIMUM, options.receive_maximum);
  if (result == MOSQ_ERR_SUCCESS && !options.user.empty())
    result =
        mosquitto_username_pw_set(client.get(), options.user.c_str(),
                                  options.password.empty() ? nullptr : options.password.c_str());
  if (result == MOSQ_ERR_SUCCESS && options.will)
    result = mosquitto_will_set(
        client.get(), options.will->topic.c_str(), static_cast<int>(options.will->payload.size()),
        options.will->payload.data(), options.will->qos, options.will->retain);
  if (result != MOSQ_ERR_SUCCESS) return option_error(result);
  if (auto status = set_tls(client.get(), options.tls); !status) return status.error();
  return client;
}

Error broker_unreachable(const BrokerOptions& options, std::string offered) {
  const bool has_tls = options.tls.is_enabled();
  return {.code = Code::BROKER_UNREACHABLE,
          .what = "the MQTT broker " + options.host + ":" + std::to_string(options.port) +
                  " cannot be reached",
          .offered = std::move(offered),
          .needed = std::string("a broker that answers at this address ") +
                    (has_tls ? "with TLS, usually at port 8883"
                             : "without TLS; for a broker with TLS, set tls-ca"),
          .fix = "start the broker, for example with `mosquitto -p " +
                 std::to_string(options.port) + "`, or set " + options.address_properties};
}

Error broker_refused(const BrokerOptions& options, std::string what, std::string offered) {
  return {.code = Code::BROKER_REFUSED,
          .what = "the MQTT broker " + options.host + ":" + std::to_string(options.port) + " " +
                  std::move(what),
          .offered = std::move(offered),
          .needed = "a user and rights that the broker accepts",
          .fix = "set user and password, or change the broker's access list"};
}

}  // namespace weir::transport
