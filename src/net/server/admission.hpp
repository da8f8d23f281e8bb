// Admission: how many connections, calls and bytes of requests each peer, and all together, may
// have at a time.
//
//   if (auto why = admission.enter(peer, CallKind::Request)) refuse(*why);
//   if (auto why = admission.read(peer, call, [=] { call->start_to_read(); })) refuse(*why);
//   admission.received(peer, bytes);  // the message is here, or did not come
//   admission.begin_response(peer, CallKind::Request, bytes);  // the response is sent to the
//   client admission.end_response(peer, bytes);                      // it was sent, or cannot be
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>

namespace weir::net {

// A stream has many messages and no certain end: one that watches health, for example.
enum class CallKind { Request, Stream };

// 0 = no limit. A connection counts while it has calls in progress. A Unix socket has one limit:
// `connections`, as which it counts as one.
struct AdmissionLimits {
  uint32_t requests = 8;                // of one connection
  uint32_t streams = 4;                 // of one connection
  uint32_t connections = 32;            // of all addresses
  uint32_t address_connections = 4;     // of one address
  uint64_t address_bytes = 256u << 20;  // of the requests of one address
  uint64_t message_bytes = 64u << 20;   // of the largest message; not 0
};

// Thread-safe.
//
// How large a request is, is known when it has been received. So a call counts as the largest
// message while its request is received, and calls of an address that has no room for another one
// wait for those before them.
//
// A client that has its response may send its next request, before this server knows that the
// response was sent. So a response takes no place of a request, and requests wait for the room of
// responses.
class Admission {
 public:
  using Start = std::function<void()>;
  explicit Admission(const AdmissionLimits& limits) : limits_(limits) {}

  // nullopt: the call is admitted, until leave(), or begin_response() and end_response(). Otherwise
  // why it is not.
  std::optional<std::string> enter(const std::string& peer, CallKind kind);
  void leave(const std::string& peer, CallKind kind);
  // An admitted call has a response of `bytes`, which count for its address.
  void begin_response(const std::string& peer, CallKind kind, uint64_t bytes);
  // The response needs no memory. `bytes`: as with release(), of the message and the response.
  void end_response(const std::string& peer, uint64_t bytes);

  // Receives a message of an admitted call. nullopt: `start` is called once a message may be
  // received, now, or later on the thread of another call. Otherwise why none may be received.
  std::optional<std::string> read(const std::string& peer, const void* call, Start start);
  // Forgets a call that was cancelled: true when it waited; its `start` will not be called.
  bool forget(const std::string& peer, const void* call);
  // Call once after `start`, with the bytes of the message; 0 when none came. They count until
  // release().
  void received(const std::string& peer, uint64_t bytes);
  void release(const std::string& peer, uint64_t bytes);
  uint64_t refused() const;

 private:
  struct Waiting {
    const void* call;
    Start start;
  };
  struct Address {
    uint32_t connections = 0, reading = 0, responses = 0;
    uint64_t bytes = 0;  // of received requests and of responses
    std::deque<Waiting> waiting;
  };
  struct Connection {
    uint32_t requests = 0, streams = 0, responses = 0;
  };
  std::optional<std::string> refusal(const std::string& peer, CallKind kind) const;
  std::optional<std::string> refused(std::string why);
  bool has_room(const Address& address) const;
  void forget_if_unused(const std::string& address);
  void start_waiting(const std::string& address);

  const AdmissionLimits limits_;
  mutable std::mutex mutex_;  // guards the rest
  std::unordered_map<std::string, Connection> connections_;
  std::unordered_map<std::string, Address> addresses_;  // in use
  uint64_t refused_ = 0;
};

}  // namespace weir::net
