// A query client of raw sockets, and a listener for it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "becomes.hpp"
#include "core/wire/edge_metadata.hpp"
#include "core/wire/wire_test_support.hpp"
#include "says.hpp"
#include "transport/edge/query_listener.hpp"

namespace weir::edge::test {

using wire::HeaderForm;
using wire::test::Bytes;
using wire::test::from_hex;
using wire::test::from_text;
using wire::test::operator+;

constexpr auto kTestTime = std::chrono::seconds(60);

// Whether there is something to read.
inline bool is_readable(int socket) {
  pollfd watched{socket, POLLIN, 0};
  return poll(&watched, 1, static_cast<int>(std::chrono::milliseconds(kTestTime).count())) == 1;
}

// The end of one connection.
class RawEnd {
 public:
  RawEnd() = default;
  explicit RawEnd(Descriptor socket) : socket_(std::move(socket)) {}
  int get() const { return socket_.get(); }
  void close() { socket_ = Descriptor(); }

  void send(const Bytes& bytes) const {
    size_t sent = 0;
    while (sent < bytes.size()) {
      pollfd watched{socket_.get(), POLLOUT, 0};
      if (poll(&watched, 1, 60'000) != 1) break;
      const ssize_t got =
          ::send(socket_.get(), bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
      if (got <= 0) break;
      sent += static_cast<size_t>(got);
    }
    EXPECT_EQ(sent, bytes.size());
  }
  // For connections that the other end may close meanwhile.
  void try_to_send(const Bytes& bytes) const {
    [[maybe_unused]] const ssize_t sent =
        ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  }
  // The next `size` bytes, fewer if the connection ends.
  Bytes receive(size_t size) const {
    Bytes out(size);
    size_t got = 0;
    while (got < size && is_readable(socket_.get())) {
      const ssize_t more = recv(socket_.get(), out.data() + got, size - got, 0);
      if (more <= 0) break;
      got += static_cast<size_t>(more);
    }
    out.resize(got);
    return out;
  }
  wire::EdgeMessage message(HeaderForm form) const {
    wire::EdgeMessageReader reader({}, form);
    while (!reader.complete()) {
      if (!is_readable(socket_.get())) break;
      const auto room = reader.space();
      const ssize_t got = recv(socket_.get(), room.data(), room.size(), 0);
      if (got <= 0) break;
      EXPECT_TRUE(reader.received(static_cast<size_t>(got)));
    }
    EXPECT_TRUE(reader.complete()) << "the connection ended";
    return reader.complete() ? reader.take() : wire::EdgeMessage{};
  }
  // Reads until the other end closes; the last bytes.
  Bytes rest() const {
    Bytes out;
    std::byte buffer[65536];
    while (is_readable(socket_.get())) {
      const ssize_t got = recv(socket_.get(), buffer, sizeof buffer, 0);
      if (got <= 0) return out;
      out.insert(out.end(), buffer, buffer + got);
    }
    ADD_FAILURE() << "the connection did not end";
    return out;
  }

 private:
  Descriptor socket_;
};

class RawClient {
 public:
  // Connects to an address of this machine, and from it.
  explicit RawClient(uint16_t port, HeaderForm form = HeaderForm::Bytes2088,
                     const std::string& host = "localhost")
      : form_(form) {
    auto made = connect_to(host, port, io::deadline_in(kTestTime), -1);
    EXPECT_TRUE(made);
    if (made) a = RawEnd(*std::move(made));
    auto listening = listen_on(host, 0);
    EXPECT_TRUE(listening);
    if (listening) listener_ = *std::move(listening);
  }

  uint16_t port() const { return get_port(listener_.get()); }
  // Reads the greeting; its text.
  std::string greeting() {
    const auto message = a.message(form_);
    EXPECT_EQ(message.command, wire::Command::Capability);
    id = message.client_id;
    if (message.memories.size() != 1) return "";
    const auto text = wire::text_of_memory(message.memories[0].bytes());
    return text ? std::string(*text) : "";
  }
  void host_info(const std::string& text) const {
    a.send(*wire::text_message(form_, wire::Command::HostInfo, id, text));
  }
  void host_info() const { host_info("localhost:" + std::to_string(port())); }
  // The connection that the server opens.
  void accept() {
    EXPECT_TRUE(is_readable(listener_.get()));
    b = RawEnd(accept_from(listener_.get()));
  }
  // Whether the server has opened a connection that is not accepted.
  bool is_called() const {
    pollfd watched{listener_.get(), POLLIN, 0};
    return poll(&watched, 1, 0) == 1;
  }
  void stop_listening() { listener_ = Descriptor(); }
  void connect() {
    greeting();
    host_info();
    accept();
  }

  Bytes request_bytes(const std::vector<Bytes>& memories, const std::string& sequence = "",
                      Bytes metadata_bytes = {}) const {
    wire::EdgeMetadata metadata;
    EXPECT_TRUE(metadata.set("client_id", std::to_string(id)));
    if (!sequence.empty()) {
      EXPECT_TRUE(metadata.set("weir.seq", sequence));
    }
    if (metadata_bytes.empty()) metadata_bytes = metadata.encode();
    wire::EdgeHeader header{.command = wire::Command::TransferData,
                            .client_id = id,
                            .metadata_bytes = metadata_bytes.size()};
    for (const auto& memory : memories) header.sizes.push_back(memory.size());
    Bytes out = *wire::write_header(form_, header);
    for (const auto& memory : memories) out = std::move(out) + memory;
    return std::move(out) + metadata_bytes;
  }
  void request(const std::vector<Bytes>& memories, const std::string& sequence = "") const {
    a.send(request_bytes(memories, sequence));
  }
  // The memories of the next response.
  std::vector<Bytes> response() {
    last_response = b.message(form_);
    EXPECT_EQ(last_response.command, wire::Command::TransferData);
    std::vector<Bytes> out;
    for (const auto& memory : last_response.memories)
      out.push_back(wire::test::copy_of(memory.bytes()));
    return out;
  }
  void close() {
    a.close();
    b.close();
    stop_listening();
  }

  RawEnd a, b;
  int64_t id = 0;
  wire::EdgeMessage last_response;  // the last response

 private:
  HeaderForm form_;
  Descriptor listener_;
};

class EdgeQuery : public ::testing::Test {
 protected:
  void open(ListenerOptions options = {}) {
    if (options.host.empty()) options.host = "localhost";
    options.refused = [this](const Error& error) {
      const std::lock_guard lock(mutex_);
      reasons_ += error.message() + "\n";
    };
    auto made = QueryListener::open(std::move(options));
    ASSERT_TRUE(made) << made.error().message();
    listener_ = *std::move(made);
    ASSERT_TRUE(listener_->set_request_caps("A"));
    ASSERT_TRUE(listener_->set_response_caps("B"));
    listener_->set_accepting(true);
  }
  RawClient client(HeaderForm form = HeaderForm::Bytes2088) {
    return RawClient(listener_->port(), form);
  }
  RawClient connected(HeaderForm form = HeaderForm::Bytes2088) {
    auto out = client(form);
    out.connect();
    return out;
  }
  // Answers the next request with its memories in the other order.
  void respond_once() {
    const auto request = listener_->take();
    ASSERT_TRUE(request);
    respond(request);
  }
  QueryListener::Sent respond(const std::shared_ptr<Request>& request) {
    const auto owner =
        std::make_shared<std::vector<wire::ByteBlock>>(std::move(request->memories()));
    std::vector<std::span<const std::byte>> parts;
    for (auto at = owner->rbegin(); at != owner->rend(); ++at) parts.push_back(at->bytes());
    const auto sent = listener_->respond(request->client(), parts, owner, request->sequence());
    if (sent == QueryListener::Sent::Queued) request->end(Request::Outcome::Answered);
    return sent;
  }
  bool clients_become(uint32_t count) {
    return becomes_true([&] { return listener_->counts().clients == count; },
                        std::to_string(count) + " clients");
  }
  std::string reasons() {
    const std::lock_guard lock(mutex_);
    return reasons_;
  }
  bool is_refused(const std::string& words) {
    return becomes_true([&] { return reasons().find(words) != std::string::npos; },
                        [&] { return "\"" + words + "\" in \"" + reasons() + "\""; });
  }
  // A client that is well-behaved gets its response.
  void expect_service() {
    auto good = connected();
    good.request({from_text("good")});
    respond_once();
    EXPECT_EQ(good.response(), (std::vector<Bytes>{from_text("good")}));
  }

  std::mutex mutex_;
  std::string reasons_;
  std::unique_ptr<QueryListener> listener_;
};

}  // namespace weir::edge::test
