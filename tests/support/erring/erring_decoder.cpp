// A C++ decoder for tests that does what a decoder must not do, or what hosts rarely meet. option1
// is the function (open, configure, decode) and option2 what it throws (failure, exception, memory,
// number). Or only option1: no-caps, bad-caps, early-memory, no-such-input, drop-odd, count (writes
// the number of frames since the last reset), to-source (writes the frame's maps, then their
// sources).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>
#include <stdexcept>
#include <string>

#include "weir/decoder.hpp"

namespace {

class Erring {
 public:
  explicit Erring(const weir::Options& options)
      : where_(options.get("option1").value_or("")), what_(options.get("option2").value_or("")) {
    err_in("open");
  }
  void configure(std::span<const weir_tensor_info>, weir::DecoderOutput& output) {
    err_in("configure");
    if (where_ == "no-caps") return;
    if (where_ == "early-memory") output.reserve(1);
    output.set_caps(where_ == "bad-caps" ? "video/x-raw,width=(int" : "application/octet-stream");
  }
  bool decode(const weir_frame& frame, weir::DecoderOutput& output) {
    err_in("decode");
    if (where_ == "to-source") {
      const size_t bytes = frame.n_maps * sizeof *frame.maps;
      const auto out = output.reserve(bytes + 1);
      if (bytes > 0) std::memcpy(out.data(), frame.maps, bytes);
      out[bytes] = static_cast<std::byte>(frame.maps_of);
      return true;
    }
    if (where_ == "no-such-input") output.share_input(7);
    const bool odd = frames_++ % 2 != 0;
    if (where_ == "drop-odd" && odd) return false;
    output.reserve(1)[0] = static_cast<std::byte>(frames_);
    return true;
  }
  void reset() noexcept { frames_ = 0; }

 private:
  void err_in(std::string_view place) const {
    if (where_ != place) return;
    if (what_ == "failure")
      throw weir::Failure({.code = weir::Code::OPTION_VALUE,
                           .what = "failed as ordered",
                           .offered = "option2=failure",
                           .needed = "another option2",
                           .difference = "the first difference",
                           .fix = "option2=nothing"});
    if (what_ == "exception") throw std::runtime_error("thrown in a decoder");
    if (what_ == "memory") throw std::bad_alloc();
    if (what_ == "number") throw 42;
  }

  std::string where_, what_;
  int frames_ = 0;
};

}  // namespace

WEIR_DECODER(Erring, "erring", "", "[]")
