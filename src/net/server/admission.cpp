// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/server/admission.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "net/server/peer_name.hpp"

namespace weir::net {
namespace {

// Connections to a Unix socket all have the same name.
bool is_one_connection(const std::string& peer) {
  return peer.rfind("unix:", 0) != 0;
}

std::string in_mib(uint64_t bytes) {
  return std::to_string(bytes >> 20) + " MiB";
}

}  // namespace

std::optional<std::string> Admission::refusal(const std::string& peer, CallKind kind) const {
  const auto known = connections_.find(peer);
  if (known == connections_.end()) {
    const auto address = addresses_.find(peer_network(peer));
    if (limits_.connections != 0 && connections_.size() >= limits_.connections)
      return "the server serves " + std::to_string(limits_.connections) +
             " connections at a time (max-connections)";
    if (address != addresses_.end() && limits_.address_connections != 0 &&
        address->second.connections >= limits_.address_connections)
      return "this address has " + std::to_string(limits_.address_connections) +
             " connections with requests in progress (max-connections-per-address)";
    return std::nullopt;
  }
  if (!is_one_connection(peer)) return std::nullopt;
  if (kind == CallKind::Request && limits_.requests != 0 &&
      known->second.requests >= limits_.requests)
    return "this connection has " + std::to_string(limits_.requests) +
           " requests in progress (max-requests)";
  if (kind == CallKind::Stream && limits_.streams != 0 && known->second.streams >= limits_.streams)
    return "this connection has " + std::to_string(limits_.streams) +
           " streams, such as those that watch health";
  return std::nullopt;
}

std::optional<std::string> Admission::refused(std::string why) {
  ++refused_;
  return why;
}

bool Admission::has_room(const Address& address) const {
  if (limits_.address_bytes == 0) return true;
  const uint64_t taken = address.bytes + address.reading * limits_.message_bytes;
  return taken == 0 || taken + limits_.message_bytes <= limits_.address_bytes;
}

std::optional<std::string> Admission::enter(const std::string& peer, CallKind kind) {
  std::lock_guard lock(mutex_);
  if (auto why = refusal(peer, kind)) return refused(*std::move(why));
  const auto [connection, added] = connections_.try_emplace(peer);
  if (added) ++addresses_[peer_network(peer)].connections;
  ++(kind == CallKind::Stream ? connection->second.streams : connection->second.requests);
  return std::nullopt;
}

void Admission::leave(const std::string& peer, CallKind kind) {
  begin_response(peer, kind, 0);
  end_response(peer, 0);
}

void Admission::begin_response(const std::string& peer, CallKind kind, uint64_t bytes) {
  std::lock_guard lock(mutex_);
  Connection& connection = connections_.find(peer)->second;
  --(kind == CallKind::Stream ? connection.streams : connection.requests);
  ++connection.responses;
  Address& address = addresses_[peer_network(peer)];
  ++address.responses;
  if (is_one_connection(peer)) address.bytes += bytes;
}

void Admission::end_response(const std::string& peer, uint64_t bytes) {
  const std::string name = peer_network(peer);
  {
    std::lock_guard lock(mutex_);
    Address& address = addresses_[name];
    --address.responses;
    if (is_one_connection(peer)) address.bytes -= bytes;
    const auto known = connections_.find(peer);
    Connection& connection = known->second;
    --connection.responses;
    if (connection.streams == 0 && connection.requests == 0 && connection.responses == 0) {
      connections_.erase(known);
      --address.connections;
    }
    forget_if_unused(name);
  }
  start_waiting(name);
}

void Admission::forget_if_unused(const std::string& name) {
  const Address& address = addresses_[name];
  if (address.connections == 0 && address.reading == 0 && address.bytes == 0 &&
      address.waiting.empty())
    addresses_.erase(name);
}

std::optional<std::string> Admission::read(const std::string& peer, const void* call, Start start) {
  if (is_one_connection(peer)) {
    std::lock_guard lock(mutex_);
    Address& address = addresses_[peer_network(peer)];
    if (!address.waiting.empty() || !has_room(address)) {
      if (address.reading == 0 && address.responses == 0 && address.waiting.empty())
        return refused("the requests in progress of this address have " + in_mib(address.bytes) +
                       ", so the server cannot accept another one of up to " +
                       in_mib(limits_.message_bytes) + " (max-bytes-in-flight)");
      address.waiting.push_back({call, std::move(start)});
      return std::nullopt;
    }
    ++address.reading;
  }
  start();
  return std::nullopt;
}

bool Admission::forget(const std::string& peer, const void* call) {
  std::lock_guard lock(mutex_);
  const auto address = addresses_.find(peer_network(peer));
  if (address == addresses_.end()) return false;
  return std::erase_if(address->second.waiting,
                       [call](const auto& one) { return one.call == call; }) != 0;
}

void Admission::received(const std::string& peer, uint64_t bytes) {
  if (!is_one_connection(peer)) return;
  const std::string name = peer_network(peer);
  {
    std::lock_guard lock(mutex_);
    Address& address = addresses_[name];
    --address.reading;
    address.bytes += bytes;
    forget_if_unused(name);
  }
  start_waiting(name);
}

void Admission::release(const std::string& peer, uint64_t bytes) {
  if (bytes == 0 || !is_one_connection(peer)) return;
  const std::string name = peer_network(peer);
  {
    std::lock_guard lock(mutex_);
    addresses_[name].bytes -= bytes;
    forget_if_unused(name);
  }
  start_waiting(name);
}

void Admission::start_waiting(const std::string& name) {
  std::vector<Start> starts;
  {
    std::lock_guard lock(mutex_);
    const auto known = addresses_.find(name);
    if (known == addresses_.end()) return;
    Address& address = known->second;
    while (!address.waiting.empty() && has_room(address)) {
      starts.push_back(std::move(address.waiting.front().start));
      address.waiting.pop_front();
      ++address.reading;
    }
  }
  for (const auto& start : starts) start();
}

uint64_t Admission::refused() const {
  std::lock_guard lock(mutex_);
  return refused_;
}

}  // namespace weir::net
