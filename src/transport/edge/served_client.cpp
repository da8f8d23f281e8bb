// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/edge/served_client.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <utility>

#include "core/wire/edge_capability.hpp"
#include "core/wire/edge_metadata.hpp"

namespace weir::edge {
namespace {

using Clock = std::chrono::steady_clock;
using wire::HeaderForm;

constexpr auto kHandshakeTime = std::chrono::seconds(2);
// A client sends a short text before it sends requests, and nothing on the second connection.
constexpr wire::MessageLimits kHandshakeLimits{
    .message_bytes = 4096, .text_bytes = 1024, .metadata_bytes = 1024};
constexpr char kClientId[] = "client_id", kSequence[] = "weir.seq";

std::string to_string(const Error& error) {
  return error.what + ": " + error.offered;
}

}  // namespace

ServedClient::ServedClient(Descriptor a, int64_t id, const ClientOptions& options,
                           std::shared_ptr<RequestCounters> counters,
                           std::shared_ptr<transport::WakeEvent> wake)
    : id_(id),
      options_(options),
      a_(std::move(a), wire::Side::ServerOnA, kHandshakeLimits, options.form, 0),
      address_(get_peer(a_.socket())),
      form_(options.form.value_or(HeaderForm::Bytes2088)),
      counters_(std::move(counters)),
      wake_(std::move(wake)) {}

void ServedClient::set_gone() noexcept {
  state_ = State::Gone;
  load_->gone = true;
}

io::Deadline ServedClient::deadline() const {
  if (state_ == State::Greeted || state_ == State::Connecting) return since_ + kHandshakeTime;
  if (options_.timeout.count() == 0) return std::nullopt;
  if (state_ == State::Waiting) return io::deadline_in(options_.timeout, 1, since_);
  if (const auto& since = responses_.waiting_since())
    return io::deadline_in(options_.timeout, 1, *since);
  if (reading_ && a_.partial_bytes() > 0) return io::deadline_in(options_.timeout, 1, last_bytes_);
  return std::nullopt;
}

std::string ServedClient::reason_of_deadline() const {
  const std::string time = std::to_string(options_.timeout.count()) + " ms (property timeout)";
  switch (state_) {
    case State::Waiting:
      return "the caps of the answers are not known within " + time;
    case State::Greeted:
      return "it does not complete the handshake within 2 s";
    case State::Connecting:
      return "its own listener cannot be reached within 2 s";
    default:
      return responses_.empty() ? "it paused within a message for " + time
                                : "it did not read its answers for " + time;
  }
}

io::Deadline ServedClient::silent_since() const {
  const bool is_silent = state_ == State::Ready && reading_ && load_->requests == 0 &&
                         responses_.empty() && a_.partial_bytes() == 0;
  if (!is_silent) return std::nullopt;
  return std::max({since_, last_bytes_, answered_});
}

Status ServedClient::greet(const std::string& capability) {
  auto message =
      options_.form ? wire::text_message(*options_.form, wire::Command::Capability, id_, capability)
                    : wire::greeting_for_both_forms(id_, capability);
  if (!message) return message.error();
  greeting_.push(*std::move(message));
  state_ = State::Greeted;
  since_ = Clock::now();
  send();
  return ok();
}

void ServedClient::watch(bool reading, std::vector<pollfd>* watched) {
  if (reading && !reading_) last_bytes_ = Clock::now();
  reading_ = reading;
  reads_responses_ = state_ == State::Ready;
  const int in = reading ? POLLIN : 0, out = greeting_.empty() ? 0 : POLLOUT;
  watched->push_back({a_.socket(), static_cast<short>(in | out), 0});
  // The second connection waits to be made, or to take responses.
  const bool writes = state_ == State::Connecting || !responses_.empty();
  const int responses = writes ? POLLIN | POLLOUT : POLLIN;
  watched->push_back({b_ ? b_->socket() : -1, static_cast<short>(responses), 0});
}

ServedClient::Input ServedClient::read(const pollfd* events) {
  Input out;
  size_t turn = MessageConnection::kTurnBytes;
  if (reads_responses_ && events[1].revents) out.responses = b_->read(&turn);
  turn = MessageConnection::kTurnBytes;
  const uint64_t before = a_.bytes_received();
  if (events[0].revents & POLLIN)
    out.requests = a_.read(&turn);
  else if (events[0].revents & (POLLERR | POLLHUP))
    out.requests = Step{MessageConnection::Read::Closed};
  if (a_.bytes_received() != before) last_bytes_ = Clock::now();
  return out;
}

ServedClient::Refusal ServedClient::take(Result<Step> step, std::shared_ptr<Request>* request) {
  if (!step) return to_string(step.error());
  if (step->read == MessageConnection::Read::Closed || step->action == wire::Action::Close)
    set_gone();
  if (step->action == wire::Action::ReadHostInfo) return host_info(step->message);
  if (step->action != wire::Action::ReadFrame) return std::nullopt;
  const auto metadata = wire::EdgeMetadata::parse(step->message.metadata.bytes());
  if (!metadata) return to_string(metadata.error());
  if (step->message.memories.empty()) return "a frame without memories";
  has_sent_a_request_ = true;
  *request = std::make_shared<Request>(id_, std::move(step->message.memories),
                                       std::string(metadata->find(kSequence).value_or("")), load_,
                                       counters_, wake_);
  return std::nullopt;
}

ServedClient::Refusal ServedClient::attend(const pollfd* events, Input input,
                                           std::shared_ptr<Request>* request) {
  send();
  if (state_ == State::Connecting && events[1].revents)
    if (auto refusal = end_connecting()) return refusal;
  if (auto refusal = take(std::move(input.responses), request)) return refusal;
  return state_ == State::Gone ? std::nullopt : take(std::move(input.requests), request);
}

ServedClient::Refusal ServedClient::host_info(const wire::EdgeMessage& message) {
  if (state_ != State::Greeted) return "it sent HOST_INFO before the server sent CAPABILITY";
  form_ = *a_.form();
  if (!options_.form && form_ == HeaderForm::Bytes160)
    return "it uses headers of 160 bytes (property wire-version=0.2.2)";
  const auto text = wire::text_of_memory(message.memories[0].bytes());
  if (!text) return to_string(text.error());
  auto announced = wire::parse_host_address(*text);
  if (!announced) return to_string(announced.error());
  // A name is not looked up: it means the machine that the connection comes from.
  if (!is_address(announced->host)) announced->host = address_;
  std::vector<std::string> allowed;
  if (options_.allows_callback && options_.allows_callback(announced->host))
    allowed.push_back(announced->host);
  const auto target = wire::callback_address(*announced, address_, allowed);
  if (!target) return to_string(target.error());
  auto connection = start_connection(*target);
  if (!connection) return to_string(connection.error());
  b_ = std::make_unique<MessageConnection>(*std::move(connection), wire::Side::ServerOnB,
                                           kHandshakeLimits, form_, 0);
  state_ = State::Connecting;
  since_ = Clock::now();
  a_.set_limits({.message_bytes = options_.max_message_bytes});
  return std::nullopt;
}

ServedClient::Refusal ServedClient::end_connecting() {
  if (!is_connected(b_->socket())) {
    const std::string reason = connection_error(b_->socket());
    if (reason.empty()) return std::nullopt;
    return "its own listener cannot be reached: " + reason;
  }
  state_ = State::Ready;
  since_ = Clock::now();
  send();
  return std::nullopt;
}

Result<bool> ServedClient::queue_response(const std::vector<std::span<const std::byte>>& memories,
                                          std::shared_ptr<const void> owner,
                                          const std::string& sequence) {
  wire::EdgeMetadata metadata;
  if (!sequence.empty())
    if (auto status = metadata.set(kSequence, sequence); !status) return status.error();
  if (auto status = metadata.set(kClientId, std::to_string(id_)); !status) return status.error();
  struct Owner {
    std::shared_ptr<const void> memories;
    std::vector<std::byte> metadata;
  };
  const auto own = std::make_shared<Owner>(Owner{std::move(owner), metadata.encode()});
  wire::EdgeHeader header{.command = wire::Command::TransferData,
                          .client_id = id_,
                          .metadata_bytes = own->metadata.size()};
  auto message = std::make_shared<SharedMessage>();
  for (const auto& memory : memories) {
    header.sizes.push_back(memory.size());
    message->bytes += memory.size();
  }
  auto bytes = wire::write_header(form_, header);
  if (!bytes) return bytes.error();
  message->bytes += bytes->size() + own->metadata.size();
  message->memories = memories;
  message->memories.emplace_back(own->metadata);
  message->owner = own;
  answered_ = Clock::now();
  return responses_.push(*std::move(bytes), std::move(message), options_.responses);
}

void ServedClient::send() {
  const bool sent =
      greeting_.send(a_.socket()) && (state_ != State::Ready || responses_.send(b_->socket()));
  if (!sent) set_gone();
}

void ServedClient::send_errors() noexcept {
  const auto report = [this](int socket) {
    const auto message = wire::error_message(form_);
    ::send(socket, message.data(), message.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  };
  if (state_ == State::Gone || greeting_.is_within_message()) return;
  report(a_.socket());
  if (state_ == State::Ready && !responses_.is_within_message()) report(b_->socket());
}

}  // namespace weir::edge
