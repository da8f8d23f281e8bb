// Ledger: counts what happened to every frame of an element.
//
// Invariant: received = consumed + dropped (all reasons) + held. Checked at EOS and after FLUSH.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstdint>
#include <mutex>
#include <string_view>

namespace weir {

// Late, Refused, Lost: what an engine reports of a result that it did not get (weir_no_result).
enum class DropReason { Policy, Qos, Flush, Eos, Error, Time, Late, Refused, Lost };
inline constexpr size_t kDropReasons = 9;
std::string_view to_string(DropReason reason) noexcept;

struct LedgerSnapshot {
  uint64_t received = 0;      // frames that arrived on the sink pad
  uint64_t consumed = 0;      // frames that were processed completely
  uint64_t pushed = 0;        // frames pushed from the source pad
  uint64_t bytes_copied = 0;  // copied payload that could have been shared
  uint64_t integer_divisions_by_zero = 0;
  std::array<uint64_t, kDropReasons> dropped{};
  uint64_t dropped_total() const noexcept;
  uint64_t held() const noexcept { return received - consumed - dropped_total(); }
};

// Thread-safe; one short lock per call.
class Ledger {
 public:
  void received() noexcept {
    change([](auto& s) { ++s.received; });
  }
  void consumed(uint64_t frames = 1) noexcept {
    change([&](auto& s) { s.consumed += frames; });
  }
  void pushed() noexcept {
    change([](auto& s) { ++s.pushed; });
  }
  void consumed_and_pushed() noexcept {
    change([](auto& s) {
      ++s.consumed;
      ++s.pushed;
    });
  }
  void dropped(DropReason reason, uint64_t frames = 1) noexcept {
    change([&](auto& s) { s.dropped[static_cast<size_t>(reason)] += frames; });
  }
  // Moves frames from consumed to dropped when the output they belong to is lost.
  void lost(DropReason reason, uint64_t frames) noexcept {
    change([&](auto& s) {
      s.consumed -= frames;
      s.dropped[static_cast<size_t>(reason)] += frames;
    });
  }
  void copied(uint64_t bytes) noexcept {
    change([&](auto& s) { s.bytes_copied += bytes; });
  }
  void divided_by_zero(uint64_t times) noexcept {
    change([&](auto& s) { s.integer_divisions_by_zero += times; });
  }
  void reset() noexcept {
    change([](auto& s) { s = {}; });
  }
  LedgerSnapshot snapshot() const noexcept {
    std::lock_guard lock(mutex_);
    return state_;
  }

 private:
  template <class F>
  void change(F&& f) noexcept {
    std::lock_guard lock(mutex_);
    f(state_);
  }
  mutable std::mutex mutex_;  // guards state_
  LedgerSnapshot state_;
};

}  // namespace weir
