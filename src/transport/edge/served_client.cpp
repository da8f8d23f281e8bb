// The handshake, the requests and the answers of one client.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/edge/served_client.hpp"

#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <utility>

#include "core/wire/edge_metadata.hpp"
#include "core/wire/edge_texts.hpp"

namespace weir::edge {
namespace {

using Clock = std::chrono::steady_clock;
using wire::HeaderForm;

constexpr auto kHandshakeTime = std::chrono::seconds(2);
constexpr size_t kMostAtOnce = size_t{1} << 20;  // bytes of one client, before others are attended
// A client sends a short text before it sends requests, and nothing on the second connection.
constexpr wire::MessageLimits kHandshakeLimits{
    .message_bytes = 4096, .text_bytes = 1024, .metadata_bytes = 1024};
constexpr char kClientId[] = "client_id", kSequence[] = "weir.seq";

std::string text_of(const Error& error) {
  return error.what + ": " + error.offered;
}

struct Arrival {
  size_t bytes = 0;    // 0: nothing is there
  bool ended = false;  // the other end has closed the connection, or it failed
};
Arrival receive_some(int socket, std::span<std::byte> room) {
  ssize_t got = -1;
  do {
    got = recv(socket, room.data(), room.size(), MSG_DONTWAIT);
  } while (got < 0 && errno == EINTR);
  if (got > 0) return {.bytes = static_cast<size_t>(got)};
  return {.ended = got == 0 || (errno != EAGAIN && errno != EWOULDBLOCK)};
}

}  // namespace

ServedClient::ServedClient(Descriptor a, int64_t id, const ClientOptions& options)
    : id_(id),
      options_(options),
      a_(std::move(a)),
      address_(peer_of(a_.get())),
      form_(options.form.value_or(HeaderForm::Bytes2088)),
      reader_(std::make_unique<wire::MessageReader>(kHandshakeLimits, options.form)) {}

void ServedClient::set_gone() noexcept {
  state_ = State::Gone;
  load_->gone = true;
}

io::Deadline ServedClient::deadline() const {
  if (state_ == State::Greeted || state_ == State::Connecting) return since_ + kHandshakeTime;
  if (options_.patience.count() == 0) return std::nullopt;
  if (state_ == State::Waiting) return io::deadline_in(options_.patience, 1, since_);
  if (const auto& since = answers_.waiting_since())
    return io::deadline_in(options_.patience, 1, *since);
  if (reading_ && !reader_->at_start()) return io::deadline_in(options_.patience, 1, last_bytes_);
  return std::nullopt;
}

std::string ServedClient::reason_of_deadline() const {
  const std::string time = std::to_string(options_.patience.count()) + " ms (property timeout)";
  switch (state_) {
    case State::Waiting:
      return "the caps of the answers are not known within " + time;
    case State::Greeted:
      return "it does not complete the handshake within 2 s";
    case State::Connecting:
      return "its own listener cannot be reached within 2 s";
    default:
      return answers_.empty() ? "it paused within a message for " + time
                              : "it did not read its answers for " + time;
  }
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

void ServedClient::set_reading(bool reading) {
  if (reading && !reading_) last_bytes_ = Clock::now();
  reading_ = reading;
}

ServedClient::Refusal ServedClient::receive(std::optional<Request>* request) {
  for (size_t total = 0; state_ != State::Gone && total < kMostAtOnce;) {
    const auto arrival = receive_some(a_.get(), reader_->space());
    if (arrival.ended) set_gone();
    if (arrival.bytes == 0) return std::nullopt;
    last_bytes_ = Clock::now();
    total += arrival.bytes;
    partial_bytes_ += arrival.bytes;
    if (const auto status = reader_->received(arrival.bytes); !status)
      return text_of(status.error());
    if (!reader_->complete()) continue;
    partial_bytes_ = 0;
    if (auto refusal = take_message(request)) return refusal;
    // Requests wait for the connection that their answers take.
    if (*request || state_ == State::Connecting) return std::nullopt;
  }
  return std::nullopt;
}

ServedClient::Refusal ServedClient::take_message(std::optional<Request>* request) {
  auto message = reader_->take();
  const auto action = conversation_.next(message.command);
  if (!action) return text_of(action.error());
  switch (*action) {
    case wire::Action::Close:
      set_gone();
      return std::nullopt;
    case wire::Action::ReadHostInfo:
      return host_info(message);
    case wire::Action::ReadFrame:
      break;
    default:
      return std::nullopt;
  }
  const auto metadata = wire::EdgeMetadata::parse(message.metadata.bytes());
  if (!metadata) return text_of(metadata.error());
  if (message.memories.empty()) return "a frame without memories";
  request->emplace(
      Request{std::move(message.memories), std::string(metadata->find(kSequence).value_or(""))});
  return std::nullopt;
}

ServedClient::Refusal ServedClient::host_info(const wire::EdgeMessage& message) {
  if (state_ != State::Greeted) return "it sent HOST_INFO before the server sent CAPABILITY";
  form_ = *reader_->form();
  if (!options_.form && form_ == HeaderForm::Bytes160)
    return "it uses headers of 160 bytes (property wire-version=0.2.2)";
  const auto text = wire::text_of_memory(message.memories[0].bytes());
  if (!text) return text_of(text.error());
  auto announced = wire::parse_host_address(*text);
  if (!announced) return text_of(announced.error());
  // A name is not looked up: it means the machine that the connection comes from.
  if (!is_address(announced->host)) announced->host = address_;
  std::vector<std::string> allowed;
  if (options_.allows_callback && options_.allows_callback(announced->host))
    allowed.push_back(announced->host);
  const auto target = wire::callback_address(*announced, address_, allowed);
  if (!target) return text_of(target.error());
  auto connection = start_connection(*target);
  if (!connection) return text_of(connection.error());
  b_ = *std::move(connection);
  state_ = State::Connecting;
  since_ = Clock::now();
  reader_ = std::make_unique<wire::MessageReader>(
      wire::MessageLimits{.message_bytes = options_.most_message_bytes}, form_);
  answers_reader_ = std::make_unique<wire::MessageReader>(kHandshakeLimits, form_);
  return std::nullopt;
}

ServedClient::Refusal ServedClient::attend_answers() {
  if (state_ == State::Connecting) {
    if (!is_connected(b_.get())) {
      const std::string reason = connection_error(b_.get());
      if (reason.empty()) return std::nullopt;
      return "its own listener cannot be reached: " + reason;
    }
    state_ = State::Ready;
    since_ = Clock::now();
  }
  send();
  return read_answers_socket();
}

// A client sends nothing but ERROR on the second connection.
ServedClient::Refusal ServedClient::read_answers_socket() {
  for (size_t total = 0; state_ != State::Gone && total < kMostAtOnce;) {
    const auto arrival = receive_some(b_.get(), answers_reader_->space());
    if (arrival.ended) set_gone();
    if (arrival.bytes == 0) return std::nullopt;
    total += arrival.bytes;
    if (const auto status = answers_reader_->received(arrival.bytes); !status)
      return text_of(status.error());
    if (answers_reader_->complete() && answers_reader_->take().command == wire::Command::Error)
      set_gone();
  }
  return std::nullopt;
}

Result<bool> ServedClient::queue_answer(const std::vector<std::span<const std::byte>>& memories,
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
  return answers_.push(*std::move(bytes), std::move(message), options_.answers);
}

void ServedClient::send() {
  const bool sent = greeting_.send(a_.get()) && (state_ != State::Ready || answers_.send(b_.get()));
  if (!sent) set_gone();
}

void ServedClient::send_errors() noexcept {
  const auto report = [this](int socket) {
    const auto message = wire::error_message(form_);
    ::send(socket, message.data(), message.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  };
  if (state_ == State::Gone || greeting_.is_within_message()) return;
  report(a_.get());
  if (state_ == State::Ready && !answers_.is_within_message()) report(b_.get());
}

}  // namespace weir::edge
