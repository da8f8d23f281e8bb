// TestCall: a call of a client without a network, for tests.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "net/server/call.hpp"

namespace weir::net {

struct Ended {
  int times = 0, status = -1;
  std::string text;
  std::vector<std::string> sent;
};

// A call without a network. `ended` outlives it.
class TestCall final : public Call {
 public:
  TestCall(Ended* ended, std::string message) : ended_(ended), message_(std::move(message)) {
    method_ = "/inference.GRPCInferenceService/ModelInfer";
    peer_ = "ipv4:127.0.0.1:1";
    request_ = Chunks({std::as_bytes(std::span(message_))});
  }
  bool cancelled() const noexcept override { return is_cancelled; }
  bool respond(const Pieces& pieces, const std::shared_ptr<const void>&) override {
    std::string all;
    for (const auto& piece : pieces)
      all += piece.own.empty() ? std::string(reinterpret_cast<const char*>(piece.borrowed.data()),
                                             piece.borrowed.size())
                               : piece.own;
    return end(0, all);
  }
  bool fail(CallStatus status, const std::string& text) override {
    return end(static_cast<int>(status), text);
  }
  bool ended() const noexcept override { return ended_->times > 0; }
  bool send(const Pieces& pieces) override {
    if (!ended()) ended_->sent.push_back(pieces.at(0).own);
    return !ended();
  }
  void expires_at(Clock::time_point time) { deadline_ = time; }
  bool is_cancelled = false;

 private:
  bool end(int status, const std::string& text) {
    ++ended_->times;
    ended_->status = status;
    ended_->text = text;
    return true;
  }
  Ended* const ended_;
  const std::string message_;
};

}  // namespace weir::net
