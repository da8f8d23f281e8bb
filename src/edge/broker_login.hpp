// BrokerLogin: how an element proves to an MQTT broker who it is, and who the broker is.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <tuple>

#include "gstcpp/element/property.hpp"
#include "transport/mqtt/mqtt_message.hpp"

namespace weir {

// The Settings of an element derive from it; kBrokerLoginProperties is a part of its kProperties.
struct BrokerLogin {
  std::string user, password, tls_ca, tls_cert, tls_key, psk, psk_identity;

  void set(transport::BrokerOptions* options) const {
    options->user = user;
    options->password = password;
    options->tls = {
        .ca = tls_ca, .cert = tls_cert, .key = tls_key, .psk = psk, .psk_identity = psk_identity};
  }
};

inline constexpr std::tuple kBrokerLoginProperties{
    gst::Property{"user", &BrokerLogin::user, "User name for the broker"},
    gst::Property{"password", &BrokerLogin::password, "Password for the broker"},
    gst::Property{"tls-ca", &BrokerLogin::tls_ca,
                  "File with the authority of the broker's certificate (PEM); enables TLS"},
    gst::Property{"tls-cert", &BrokerLogin::tls_cert,
                  "File with the certificate of this client (PEM)"},
    gst::Property{"tls-key", &BrokerLogin::tls_key, "File with the key of tls-cert (PEM)"},
    gst::Property{"psk", &BrokerLogin::psk,
                  "Pre-shared key in hexadecimal digits; enables TLS without certificates"},
    gst::Property{"psk-identity", &BrokerLogin::psk_identity, "Name of the key for the broker"},
};

}  // namespace weir
