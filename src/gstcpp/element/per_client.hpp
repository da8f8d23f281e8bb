// PerClient: one T, an adapter for example, per client of a query server (query_meta.hpp).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <utility>

namespace weir::gst {

// The most clients for which an element keeps frames. A further one replaces the client that has
// been silent for the longest time.
inline constexpr size_t kClientLimit = 64;

// Not thread-safe. References are valid until the client is replaced.
template <class T>
class PerClient {
 public:
  // `make` creates the T of a new client; `gone` gets a replaced T, so that the frames waiting in
  // it are counted and not lost silently.
  PerClient(std::function<T()> make, std::function<void(T&)> gone, size_t limit = kClientLimit)
      : make_(std::move(make)), gone_(std::move(gone)), limit_(limit) {}

  T& of(int64_t client) {
    for (auto it = clients_.begin(); it != clients_.end(); ++it)
      if (it->first == client) {
        clients_.splice(clients_.begin(), clients_, it);
        return clients_.front().second;
      }
    if (clients_.size() >= limit_) {
      gone_(clients_.back().second);
      clients_.pop_back();
    }
    clients_.emplace_front(client, make_());
    return clients_.front().second;
  }

  template <class F>
  void for_each(F&& f) {
    for (auto& [client, value] : clients_) f(value);
  }
  size_t size() const noexcept { return clients_.size(); }
  void clear() noexcept { clients_.clear(); }  // does not call `gone`

 private:
  std::function<T()> make_;
  std::function<void(T&)> gone_;
  size_t limit_;
  std::list<std::pair<int64_t, T>> clients_;  // most recent sender first
};

}  // namespace weir::gst
