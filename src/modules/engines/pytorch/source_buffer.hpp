// SourceBuffer: lets std::istream read a model file without a copy of it in memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <streambuf>

#include "model_source.hpp"

namespace weir::engine {

class SourceBuffer : public std::streambuf {
 public:
  // `source` must outlive it.
  explicit SourceBuffer(const ModelSource& source) : source_(source) {}

 protected:
  int_type underflow() override {
    const uint64_t at = place();
    const auto count = std::min<uint64_t>(buffer_.size(), source_.size() - at);
    if (count == 0 || !source_.read(at, std::as_writable_bytes(std::span(buffer_.data(), count))))
      return traits_type::eof();
    begin_ = at;
    setg(buffer_.data(), buffer_.data(), buffer_.data() + count);
    return traits_type::to_int_type(*gptr());
  }
  std::streamsize xsgetn(char* to, std::streamsize count) override {
    const uint64_t at = place();
    const auto wanted = std::min<uint64_t>(static_cast<uint64_t>(count), source_.size() - at);
    if (!source_.read(at, std::as_writable_bytes(std::span(to, wanted)))) return 0;
    go_to(at + wanted);
    return static_cast<std::streamsize>(wanted);
  }
  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override {
    const off_type base = from == std::ios_base::beg   ? 0
                          : from == std::ios_base::cur ? static_cast<off_type>(place())
                                                       : static_cast<off_type>(source_.size());
    const off_type to = base + offset;
    if (to < 0 || static_cast<uint64_t>(to) > source_.size()) return pos_type(off_type(-1));
    go_to(static_cast<uint64_t>(to));
    return to;
  }
  pos_type seekpos(pos_type to, std::ios_base::openmode which) override {
    return seekoff(off_type(to), std::ios_base::beg, which);
  }

 private:
  uint64_t place() const { return begin_ + static_cast<uint64_t>(gptr() - eback()); }
  void go_to(uint64_t at) {
    begin_ = at;
    setg(buffer_.data(), buffer_.data(), buffer_.data());
  }

  const ModelSource& source_;
  uint64_t begin_ = 0;  // offset in the source at which the buffer starts
  std::array<char, 1 << 16> buffer_{};
};

}  // namespace weir::engine
