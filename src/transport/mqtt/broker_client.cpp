// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/mqtt/broker_client.hpp"

#include <mqtt_protocol.h>
#include <unistd.h>

#include <chrono>
#include <random>

#include "transport/mqtt/broker_connection.hpp"

namespace weir::transport {
namespace {

constexpr int kNotGranted = 128;  // and higher: the broker's reason

std::string unique_client_id() {
  std::random_device random;
  char text[32];
  g_snprintf(text, sizeof text, "weir_%d_%08x%08x", static_cast<int>(getpid()), random(), random());
  return text;
}

// Exceptions must not reach the library.
template <class F>
void guarded(F&& f) noexcept {
  try {
    f();
  } catch (...) {  // out of memory: the message is lost
  }
}

Error publish_error(const BrokerOptions& options, int result, const Publication& publication) {
  if (result == MOSQ_ERR_NO_CONN || result == MOSQ_ERR_CONN_LOST)
    return broker_unreachable(options, mosquitto_strerror(result));
  return {.code = Code::LIMIT_EXCEEDED,
          .what = "a message cannot be published to the topic " + publication.topic,
          .offered = std::to_string(publication.payload.size()) + " bytes with QoS " +
                     std::to_string(publication.qos) + ": " + mosquitto_strerror(result),
          .needed = "at most 268435455 bytes, and what the broker permits",
          .fix =
              "send smaller frames, or raise message_size_limit and max_packet_size of the "
              "broker"};
}

}  // namespace

void BrokerClient::Impl::set_callbacks() {
  mosquitto_connect_callback_set(client_.get(), [](mosquitto*, void* self, int code) {
    static_cast<Impl*>(self)->on_connect(code);
  });
  mosquitto_message_v5_callback_set(
      client_.get(), [](mosquitto*, void* self, const mosquitto_message* message,
                        const mosquitto_property* properties) {
        guarded([&] { static_cast<Impl*>(self)->on_message(*message, properties); });
      });
  mosquitto_publish_v5_callback_set(
      client_.get(), [](mosquitto*, void* self, int number, int reason, const mosquitto_property*) {
        guarded([&] { static_cast<Impl*>(self)->on_publish(number, reason); });
      });
  mosquitto_subscribe_callback_set(
      client_.get(), [](mosquitto*, void* self, int number, int count, const int* granted) {
        guarded([&] {
          static_cast<Impl*>(self)->on_subscribe(number, count > 0 ? granted[0] : kNotGranted);
        });
      });
}

void BrokerClient::Impl::on_connect(int code) {
  response_ = code;
}

void BrokerClient::Impl::on_message(const mosquitto_message& message,
                                    const mosquitto_property* properties) {
  MqttMessage out{.topic = message.topic,
                  .retained = message.retain,
                  .properties = properties_from_list(properties)};
  const auto* bytes = static_cast<const std::byte*>(message.payload);
  if (message.payloadlen > 0) out.payload.assign(bytes, bytes + message.payloadlen);
  if (options_.on_message)
    options_.on_message(std::move(out));
  else
    received_.push(std::move(out));
}

void BrokerClient::Impl::on_publish(int number, int reason) {
  std::lock_guard lock(mutex_);
  if (!sent_.end(number)) return;
  ++(reason >= kNotGranted ? counts_.refused : counts_.published);
  changed_.notify_all();
}

void BrokerClient::Impl::on_subscribe(int number, int granted) {
  std::lock_guard lock(mutex_);
  if (subscribing_ > 0) granted_[number] = granted;
  changed_.notify_all();
}

Status BrokerClient::Impl::subscribe(const std::string& filter, int qos) {
  if (auto status = check_topic_filter("topic", filter); !status) return status;
  std::unique_lock lock(mutex_);
  ++subscribing_;
  auto status = request_subscription(&lock, filter, qos);
  if (--subscribing_ == 0) granted_.clear();
  if (status) subscriptions_.push_back({filter, qos});
  return status;
}

Status BrokerClient::Impl::request_subscription(std::unique_lock<std::mutex>* lock,
                                                const std::string& filter, int qos) {
  lock->unlock();
  int number = 0;
  const int result = mosquitto_subscribe(client_.get(), &number, filter.c_str(), qos);
  wake_.set();
  lock->lock();
  if (result != MOSQ_ERR_SUCCESS) return broker_unreachable(options_, mosquitto_strerror(result));
  const bool answered = changed_.wait_for(*lock, options_.connect_timeout, [&] {
    return interrupted_ || !connected_ || granted_.count(number) > 0;
  });
  const auto granted = granted_.find(number);
  if (granted == granted_.end())
    return broker_unreachable(options_,
                              answered ? "the connection ended" : "no answer to the subscription");
  if (granted->second >= kNotGranted)
    return broker_refused(options_, "does not accept a subscription to " + filter,
                          mosquitto_reason_string(granted->second));
  return ok();
}

Status BrokerClient::Impl::publish(const Publication& publication,
                                   std::chrono::milliseconds timeout) {
  auto list = to_property_list(publication.properties);
  if (!list) return list.error();
  const size_t size = publication.payload.size();
  std::unique_lock lock(mutex_);
  const auto has_room = [&] {
    return connected_ && sent_.has_room(size, options_.max_sent_messages, options_.max_sent_bytes);
  };
  changed_.wait_for(lock, timeout, [&] { return interrupted_ || has_room(); });
  if (interrupted_) return Error{.code = Code::CANCELLED, .what = "publishing was interrupted"};
  if (!has_room())
    return broker_unreachable(options_,
                              std::string(connected_ ? "it accepted no message" : "no connection") +
                                  " within " + std::to_string(timeout.count()) + " ms");
  sent_.begin();
  const uint64_t connection = counts_.connections;
  lock.unlock();
  int number = 0;
  const int result = mosquitto_publish_v5(client_.get(), &number, publication.topic.c_str(),
                                          static_cast<int>(std::min<size_t>(size, INT32_MAX)),
                                          publication.payload.data(), publication.qos,
                                          publication.retain, list->get());
  wake_.set();
  lock.lock();
  if (result != MOSQ_ERR_SUCCESS) {
    sent_.cancel();
    return publish_error(options_, result, publication);
  }
  const bool ended = sent_.add(number, size, publication.qos);
  // disconnected() did not see a message that was not added yet.
  const bool same = connected_ && counts_.connections == connection;
  if (!ended && publication.qos == 0 && !same && sent_.end(number)) ++counts_.lost;
  return ok();
}

Status BrokerClient::Impl::keep(std::string topic, std::vector<std::byte> payload, int qos,
                                std::chrono::milliseconds timeout) {
  auto status = publish({.topic = topic, .payload = payload, .qos = qos, .retain = true}, timeout);
  if (!status) return status;
  std::lock_guard lock(mutex_);
  kept_[std::move(topic)] = {std::move(payload), qos};
  return ok();
}

bool BrokerClient::Impl::flush(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, timeout, [this] { return interrupted_ || sent_.empty(); });
  return sent_.empty();
}

std::optional<MqttMessage> BrokerClient::Impl::receive(std::chrono::milliseconds timeout) {
  auto out = received_.pop(timeout);
  if (reads_paused_) wake_.set();
  return out;
}

void BrokerClient::Impl::interrupt(bool interrupted) {
  received_.set_interrupted(interrupted);
  std::lock_guard lock(mutex_);
  interrupted_ = interrupted;
  changed_.notify_all();
}

bool BrokerClient::Impl::is_connected() const {
  std::lock_guard lock(mutex_);
  return connected_;
}

std::string BrokerClient::Impl::local_address() const {
  std::lock_guard lock(mutex_);
  return connected_ ? local_address_ : "";
}

BrokerCounts BrokerClient::Impl::counts() const {
  std::lock_guard lock(mutex_);
  BrokerCounts out = counts_;
  out.dropped = received_.dropped();
  return out;
}

bool has_broker_client() {
  return true;
}

Result<std::unique_ptr<BrokerClient>> BrokerClient::open(BrokerOptions options) {
  if (options.client_id.empty()) options.client_id = unique_client_id();
  if (options.will)
    if (auto status = check_topic("topic", options.will->topic); !status) return status.error();
  auto impl = std::make_unique<Impl>(std::move(options));
  if (auto status = impl->start(); !status) return status.error();
  return std::unique_ptr<BrokerClient>(new BrokerClient(std::move(impl)));
}

BrokerClient::BrokerClient(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
BrokerClient::~BrokerClient() = default;

Status BrokerClient::subscribe(const std::string& filter, int qos) {
  // mosquitto 2.0.11 stops after `receive_maximum` messages of QoS 2 to a client of MQTT 5.
  if (impl_->version() == MqttVersion::V5) qos = std::min(qos, 1);
  return impl_->subscribe(filter, qos);
}
std::optional<MqttMessage> BrokerClient::receive(std::chrono::milliseconds timeout) {
  return impl_->receive(timeout);
}
void BrokerClient::interrupt(bool interrupted) {
  impl_->interrupt(interrupted);
}
Status BrokerClient::publish(const Publication& publication, std::chrono::milliseconds timeout) {
  if (auto status = check_topic("topic", publication.topic); !status) return status;
  // A broker may end the connection for it, again with each connection.
  const auto& answers = publication.properties.response_topic;
  if (!answers.empty())
    if (auto status = check_topic("response-topic", answers); !status) return status;
  return impl_->publish(publication, timeout);
}
Status BrokerClient::keep_published(std::string topic, std::vector<std::byte> payload, int qos,
                                    std::chrono::milliseconds timeout) {
  if (auto status = check_topic("topic", topic); !status) return status;
  return impl_->keep(std::move(topic), std::move(payload), qos, timeout);
}
void BrokerClient::remove_retained(const std::string& topic, int qos,
                                   std::chrono::milliseconds timeout) {
  interrupt(false);
  if (!is_connected()) return;
  const auto end = std::chrono::steady_clock::now() + timeout;
  if (publish({.topic = topic, .payload = {}, .qos = qos, .retain = true, .properties = {}},
              timeout))
    flush(std::chrono::ceil<std::chrono::milliseconds>(end - std::chrono::steady_clock::now()));
}
bool BrokerClient::flush(std::chrono::milliseconds timeout) {
  return impl_->flush(timeout);
}
bool BrokerClient::is_connected() const {
  return impl_->is_connected();
}
std::string BrokerClient::local_address() const {
  return impl_->local_address();
}
BrokerCounts BrokerClient::counts() const {
  return impl_->counts();
}

}  // namespace weir::transport
