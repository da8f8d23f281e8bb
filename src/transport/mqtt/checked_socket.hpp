// CheckedSocket: stands between a broker of MQTT 5 and libmosquitto, which aborts the process at a
// property that it does not know.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <mosquitto.h>

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "core/wire/mqtt_packets.hpp"
#include "machine/descriptor.hpp"
#include "weir/result.hpp"

namespace weir::transport {

// The client reads and writes one end of a pair of sockets. What the broker sends goes through a
// wire::MqttPacketFilter before it is passed on. With TLS, the client gets one record at a time,
// which is checked after it has decrypted it and before it reads it. Used by the client's thread.
class CheckedSocket {
 public:
  // Takes the place of the client's socket, which is connected. Errors: OUT_OF_MEMORY without free
  // descriptors, BROKER_UNREACHABLE in the middle of a record of TLS.
  static Result<std::unique_ptr<CheckedSocket>> replace_socket_of(mosquitto* client);

  // The connection to the broker, and what poll() watches on it.
  int socket() const noexcept { return broker_.get(); }
  short events(bool reads) const;
  // Whether receive() can go on without an event.
  bool has_more() const { return passable() > 0 || !status_; }
  // Receives and passes on; whether the client may have something to read. PEER_MESSAGE_INVALID,
  // when the client has read what came before; LIMIT_EXCEEDED: a record of TLS does not fit.
  Result<bool> receive(int revents);
  // Sends what the client has written. False: the connection has failed.
  bool send();
  // Whether the broker's socket had no room for all of it.
  bool has_unsent() const { return sent_ < unsent_.size(); }

 private:
  CheckedSocket(mosquitto* client, io::Descriptor broker, io::Descriptor inner);
  void fill();
  // Bytes that may be passed on now.
  size_t passable() const;
  size_t record_size() const;
  bool is_client_busy() const;
  // Checks what the client will decrypt of the record that it was given.
  Status check_record();

  mosquitto* const client_;
  const io::Descriptor broker_, inner_;  // inner_: the other end of the client's socket
  wire::MqttPacketFilter filter_;
  std::vector<std::byte> buffer_;
  std::vector<std::byte> received_;  // what may be passed on; with TLS, of records
  std::vector<std::byte> unsent_;    // of the client
  size_t passed_ = 0, sent_ = 0;     // of both
  Status status_ = ok();             // of what came after received_
  bool is_closed_ = false, is_established_ = false;
};

}  // namespace weir::transport
