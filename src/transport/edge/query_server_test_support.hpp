// ScriptedServer: a query server that does what a test says, step by step, in a thread of its own.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/wire/edge_capability.hpp"
#include "core/wire/edge_message_reader.hpp"
#include "core/wire/edge_metadata.hpp"
#include "core/wire/wire_test_support.hpp"
#include "transport/edge/stream_socket.hpp"
#include "transport/wake_event.hpp"

namespace weir::edge::test {

using wire::HeaderForm;
using wire::test::Bytes;

class ScriptedServer {
 public:
  using Pairs = std::vector<std::pair<std::string, std::string>>;
  using Script = std::function<void(ScriptedServer&)>;
  static constexpr int64_t kClient = 77;

  explicit ScriptedServer(Script script, uint32_t port = 0) {
    auto listener = listen_on("127.0.0.1", port);
    EXPECT_TRUE(listener) << (listener ? "" : listener.error().message());
    listener_ = *std::move(listener);
    thread_ = std::thread([this, script = std::move(script)] {
      try {
        script(*this);
      } catch (const Ended&) {
      } catch (const Stopped&) {
      }
      has_ended_ = true;
    });
  }
  ~ScriptedServer() {
    stop_.set();
    thread_.join();
  }
  ScriptedServer(const ScriptedServer&) = delete;
  ScriptedServer& operator=(const ScriptedServer&) = delete;

  uint16_t port() const { return get_port(listener_.get()); }
  bool has_ended() const { return has_ended_; }
  // The address that the client gave; for scripts, or after has_ended().
  std::string announced() const { return announced_; }

  // For scripts. A step that waits ends the script when the peer closes or the test ends.
  void accept() {
    wait(listener_.get(), POLLIN);
    requests = accept_from(listener_.get());
    reader_.emplace(wire::MessageLimits{});
  }
  void greet(const std::string& takes, const std::string& responses,
             HeaderForm form = HeaderForm::Bytes2088) {
    this->form = form;
    const auto text = *wire::query_capability_text({takes, responses});
    send(requests, *wire::text_message(form, wire::Command::Capability, kClient, text));
  }
  // The address in the client's HOST_INFO.
  std::string read_address() {
    announced_ = *wire::text_of_memory(read().memories.at(0).bytes());
    return announced_;
  }
  void connect_back() {
    const auto address = wire::parse_host_address(read_address());
    auto connected = connect_to("127.0.0.1", address->port, std::nullopt, stop_.descriptor());
    if (!connected) throw Ended();  // the test may have ended
    responses = *std::move(connected);
  }
  // A connection to the client's listener from another address of this machine; it blocks.
  static Descriptor connect_from(const char* own, const std::string& address) {
    Descriptor out(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in at{};
    at.sin_family = AF_INET;
    inet_pton(AF_INET, own, &at.sin_addr);
    EXPECT_EQ(bind(out.get(), reinterpret_cast<sockaddr*>(&at), sizeof at), 0);
    inet_pton(AF_INET, "127.0.0.1", &at.sin_addr);
    at.sin_port = htons(wire::parse_host_address(address)->port);
    EXPECT_EQ(connect(out.get(), reinterpret_cast<sockaddr*>(&at), sizeof at), 0);
    return out;
  }
  // All that a server does before the first frame.
  void handshake(const std::string& takes, const std::string& responses,
                 HeaderForm form = HeaderForm::Bytes2088) {
    accept();
    greet(takes, responses, form);
    connect_back();
  }
  wire::EdgeMessage read() {
    while (!reader_->complete()) {
      wait(requests.get(), POLLIN);
      const auto room = reader_->space();
      const ssize_t got = recv(requests.get(), room.data(), room.size(), 0);
      if (got <= 0 || !reader_->received(static_cast<size_t>(got))) throw Ended();
    }
    return reader_->take();
  }
  void respond(const std::vector<Bytes>& memories, const Pairs& pairs = {{"client_id", "77"}}) {
    send(responses, frame(memories, pairs));
  }
  // Answers with what it was sent, and with its number if `repeats_number`.
  void echo(const wire::EdgeMessage& message, bool repeats_number = false) {
    std::vector<Bytes> memories;
    for (const auto& memory : message.memories)
      memories.push_back(wire::test::copy_of(memory.bytes()));
    Pairs pairs;
    if (repeats_number)
      pairs.emplace_back("weir.seq",
                         *wire::EdgeMetadata::parse(message.metadata.bytes())->find("weir.seq"));
    respond(memories, pairs);
  }
  Bytes frame(const std::vector<Bytes>& memories, const Pairs& pairs) const {
    wire::EdgeMetadata metadata;
    for (const auto& [key, value] : pairs) EXPECT_TRUE(metadata.set(key, value));
    const auto blob = metadata.encode();
    wire::EdgeHeader header{.command = wire::Command::TransferData,
                            .client_id = kClient,
                            .metadata_bytes = blob.size()};
    for (const auto& memory : memories) header.sizes.push_back(memory.size());
    Bytes out = *wire::write_header(form, header);
    for (const auto& memory : memories) out.insert(out.end(), memory.begin(), memory.end());
    out.insert(out.end(), blob.begin(), blob.end());
    return out;
  }
  void send(const Descriptor& socket, const Bytes& bytes) {
    for (size_t sent = 0; sent < bytes.size();) {
      wait(socket.get(), POLLOUT);
      const ssize_t step =
          ::send(socket.get(), bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
      if (step <= 0) throw Ended();
      sent += static_cast<size_t>(step);
    }
  }
  // Reads until the client closes its connection, and answers nothing.
  void ignore_all() {
    try {
      for (;;) read();
    } catch (const Ended&) {
    }
  }
  // Takes the steps until the client closes its connections, even while a response is sent.
  template <class Steps>
  void until_closed(const Steps& steps) {
    try {
      steps();
    } catch (const Ended&) {
    }
  }
  // Until poll() has something for a descriptor.
  void wait(int socket, short events) {
    pollfd watched[] = {{socket, events, 0}, {stop_.descriptor(), POLLIN, 0}};
    while (poll(watched, 2, -1) < 0) {
    }
    if (watched[1].revents) throw Stopped();
  }
  void wait_for_the_end_of_the_test() { wait(-1, 0); }
  // Without ERROR, as a process that is killed.
  void close() {
    requests = Descriptor();
    responses = Descriptor();
  }

  Descriptor requests, responses;
  HeaderForm form = HeaderForm::Bytes2088;

 private:
  struct Ended {};
  struct Stopped {};  // by the end of the test
  transport::WakeEvent stop_;
  Descriptor listener_;
  std::optional<wire::EdgeMessageReader> reader_;
  std::string announced_;
  std::atomic<bool> has_ended_{false};
  std::thread thread_;
};

}  // namespace weir::edge::test
