// The properties that mqttsink and mqttsrc share, and what they mean for the broker client.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <tuple>

#include "edge/broker_login.hpp"

namespace weir {

struct BrokerSettings : BrokerLogin {
  bool debug = false;
  std::string client_id, host = "127.0.0.1", port = "1883";
  bool cleansession = true;
  int keep_alive_interval = 60, protocol = 4;
  uint32_t max_age = 0;
  std::string allow;
  bool insecure = false;

  bool is_v5() const { return protocol == 5; }
};

// Programs write the properties that NNStreamer has in any state; those of the connection count
// when it is opened again.
inline constexpr auto kAtTheNextStart = gst::Changeable::WhilePlaying;
inline constexpr auto kBrokerProperties = std::tuple_cat(
    kBrokerLoginProperties,
    std::tuple{
        gst::Property{"debug", &BrokerSettings::debug, "Accepted for compatibility; has no effect",
                      kAtTheNextStart},
        gst::Property{"client-id", &BrokerSettings::client_id,
                      "Client identifier; default: HOST_PID_sinkN or HOST_PID_srcN",
                      kAtTheNextStart},
        gst::Property{"host", &BrokerSettings::host, "Host name or address of the broker",
                      kAtTheNextStart},
        gst::Property{"port", &BrokerSettings::port, "Port of the broker", kAtTheNextStart},
        gst::Property{"cleansession", &BrokerSettings::cleansession,
                      "Whether the broker deletes the client's state when the connection ends",
                      kAtTheNextStart},
        gst::Property{"keep-alive-interval", &BrokerSettings::keep_alive_interval,
                      "Seconds without a message after which the connection is checked",
                      kAtTheNextStart, 1, 65535},
        gst::Property{
            "protocol", &BrokerSettings::protocol,
            "4 = MQTT 3.1.1 with NNStreamer's header of 1024 bytes, 5 = MQTT 5 with caps and "
            "times as user properties",
            gst::Changeable::InReady, 4, 5},
        gst::Property{"max-age", &BrokerSettings::max_age,
                      "Milliseconds after which a message is dropped (protocol=5); 0 = never"},
        gst::Property{"insecure", &BrokerSettings::insecure,
                      "Allow connections to other machines without TLS; use it only on a network "
                      "that you trust"},
        gst::Property{"allow", &BrokerSettings::allow,
                      "Host names, addresses and networks of brokers that may be used without TLS "
                      "although weir.ini requires it"},
    });

// The options of the client. OPTION_VALUE for a port that is not 1 to 65535.
Result<transport::BrokerOptions> broker_options(const BrokerSettings& settings);
// Whether the connection may go without TLS (transport/network_policy.hpp); posts the warning.
Status check_connection(GstElement* element, const transport::BrokerOptions& options,
                        const BrokerSettings& settings);
// "HOST_PID_KINDn", with a new n for each call.
std::string default_client_id(const char* kind);

}  // namespace weir
