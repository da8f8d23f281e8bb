// BrokerClient::Impl: the thread of a client, and what it shares with the callers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gio/gio.h>
#include <poll.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

#include "transport/mqtt/broker_client.hpp"
#include "transport/mqtt/checked_socket.hpp"
#include "transport/mqtt/mosquitto_handle.hpp"
#include "transport/mqtt/receive_queue.hpp"
#include "transport/mqtt/sent_messages.hpp"
#include "transport/mqtt/tls_handshake.hpp"
#include "transport/wake_event.hpp"

namespace weir::transport {

class BrokerClient::Impl {
 public:
  explicit Impl(BrokerOptions options);
  ~Impl();
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  // Starts the thread and waits for the first connection.
  Status start();
  Status subscribe(const std::string& filter, int qos);
  Status publish(const Publication& publication, std::chrono::milliseconds timeout);
  Status keep(std::string topic, std::vector<std::byte> payload, int qos,
              std::chrono::milliseconds timeout);
  bool flush(std::chrono::milliseconds timeout);
  std::optional<MqttMessage> receive(std::chrono::milliseconds timeout);
  void interrupt(bool interrupted);
  MqttVersion version() const { return options_.version; }
  bool is_connected() const;
  std::string local_address() const;
  BrokerCounts counts() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Subscription {
    std::string filter;
    int qos;
  };
  struct Kept {
    std::vector<std::byte> payload;
    int qos;
  };

  // Of the thread.
  void run();
  void use_connection();
  // Reports a failure to open() if that still waits; false if it does not.
  bool report_to_open();
  bool connect();
  bool connect_to_one(const std::vector<std::string>& addresses, std::string* reason);
  bool connect_to(const std::string& target, bool blocking, std::string* reason);
  // The connection to the broker; -1 without one.
  int socket() const;
  // Begins to check what the broker of MQTT 5 sends. False while the connection is not there.
  // Errors: those of CheckedSocket::replace_socket_of().
  Result<bool> check_packets();
  bool try_connect(const std::string& target, bool blocking, std::string* reason);
  // One step towards the broker's response; false if the attempt has failed.
  bool await_response(Clock::time_point end, std::string* reason);
  int step(int wait_ms);
  int read(const pollfd& client, const pollfd& broker);
  bool should_read();
  void connected();
  void disconnected();
  void say_goodbye();
  void wait_for_wake(std::chrono::milliseconds time);

  // Subscribes and waits for the broker's response, with the lock.
  Status request_subscription(std::unique_lock<std::mutex>* lock, const std::string& filter,
                              int qos);

  void set_callbacks();
  void on_connect(int code);
  void on_message(const mosquitto_message& message, const mosquitto_property* properties);
  void on_publish(int number, int reason);
  void on_subscribe(int number, int granted);

  const BrokerOptions options_;
  Mosquitto client_;
  ReceiveQueue received_;
  WakeEvent wake_;
  const std::unique_ptr<GCancellable, decltype(&g_object_unref)> lookup_;
  std::atomic<bool> stopping_{false}, reads_paused_{false};
  // Of the thread.
  std::optional<int> response_;  // of the broker to the last connect
  Clock::time_point paused_since_{};
  std::optional<Error> error_;  // of the last attempt to connect, then of the connection
  std::string tls_error_;       // in it, of OpenSSL
  bool has_reported_packet_ = false;
  bool is_open_ = false;                    // has been connected
  std::unique_ptr<CheckedSocket> checked_;  // of MQTT 5; null while there is no connection

  mutable std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  bool connected_ = false, interrupted_ = false;
  std::string local_address_;
  std::optional<Status> first_;
  SentMessages sent_;
  BrokerCounts counts_;
  std::vector<Subscription> subscriptions_;
  size_t subscribing_ = 0;      // calls of subscribe() in progress
  std::map<int, int> granted_;  // meanwhile, by the number of the request
  std::map<std::string, Kept> kept_;

  std::thread thread_;
};

}  // namespace weir::transport
