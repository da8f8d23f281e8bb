// The messages that were given to libmosquitto and are not sent or acknowledged yet.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>

namespace weir::transport {

// Not thread-safe. A message is known by the number that the library gives it, and the library may
// report its end before it returns that number.
class SentMessages {
 public:
  // Between begin() and add(), ends of unknown numbers are remembered.
  void begin() { ++publishing_; }
  // A message that the library accepted. True if it has ended already.
  bool add(int number, size_t bytes, int qos) {
    const bool ended = early_.erase(number) > 0;
    if (!ended) {
      messages_[number] = {bytes, qos};
      bytes_ += bytes;
    }
    end_publishing();
    return ended;
  }
  // In place of add(), for a message that the library rejected.
  void cancel() { end_publishing(); }

  // True if the number is that of a message in progress or of one that is about to be added.
  bool end(int number) {
    const auto found = messages_.find(number);
    if (found == messages_.end()) return publishing_ > 0 && early_.insert(number).second;
    bytes_ -= found->second.bytes;
    messages_.erase(found);
    return true;
  }
  // Forgets messages of QoS 0, which the library does not send again, and returns how many.
  uint64_t lose_unacknowledged() {
    uint64_t lost = 0;
    for (auto it = messages_.begin(); it != messages_.end();) {
      if (it->second.qos > 0) {
        ++it;
        continue;
      }
      bytes_ -= it->second.bytes;
      it = messages_.erase(it);
      ++lost;
    }
    return lost;
  }
  bool has_room(size_t bytes, size_t max_messages, size_t max_bytes) const {
    const size_t waiting = messages_.size() + publishing_;
    return waiting == 0 || (waiting < max_messages && bytes_ + bytes <= max_bytes);
  }
  bool empty() const { return messages_.empty() && publishing_ == 0; }

 private:
  struct Sent {
    size_t bytes;
    int qos;
  };
  void end_publishing() {
    if (--publishing_ == 0) early_.clear();
  }

  std::map<int, Sent> messages_;
  std::set<int> early_;
  size_t bytes_ = 0, publishing_ = 0;
};

}  // namespace weir::transport
