// Circuit: decides whether a server gets requests, by how its last requests ended.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "net/protocol/outcome.hpp"

namespace weir::net {

// Closed: requests flow. Two lost requests or three late ones in a row open it; then none flow. A
// probe that the server answers lets one request through (half-open), whose response closes it. Not
// thread-safe.
class Circuit {
 public:
  enum class State { Closed, HalfOpen, Open };
  static constexpr int kMaxLost = 2, kMaxLate = 3;

  State state() const noexcept { return state_; }
  bool admits() const noexcept {
    return state_ == State::Closed || (state_ == State::HalfOpen && !trial_);
  }
  // A request starts. Precondition: admits().
  void begin() noexcept { trial_ = state_ == State::HalfOpen; }
  // A request ended. `begun_half_open`: it was the trial of a half-open circuit.
  void end(Outcome outcome, bool begun_half_open) noexcept {
    if (begun_half_open) trial_ = false;
    switch (outcome) {
      case Outcome::Answered:
      case Outcome::Refused:  // the server is there
        lost_ = late_ = 0;
        if (begun_half_open) state_ = State::Closed;
        return;
      case Outcome::Lost:
        ++lost_;
        break;
      case Outcome::Late:
        ++late_;
        break;
    }
    if (begun_half_open || lost_ >= kMaxLost || late_ >= kMaxLate) open();
  }
  void open() noexcept {
    state_ = State::Open;
    trial_ = false;
  }
  void probe_answered() noexcept {
    if (state_ == State::Open) state_ = State::HalfOpen;
  }

 private:
  State state_ = State::Closed;
  bool trial_ = false;
  int lost_ = 0, late_ = 0;  // in a row
};

}  // namespace weir::net
