// An external converter for tests: text such as "1 2 3;4 5" becomes int32 tensors, one per part
// between semicolons; "count" becomes the number of frames since the last reset. Words select
// faults: drop, nothing, rate, no rate, failure, exception, memory, number, many, time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <charconv>
#include <cstring>
#include <stdexcept>
#include <string>

#include "weir/converter.hpp"

namespace {

std::vector<int32_t> numbers_in(std::string_view text) {
  std::vector<int32_t> out;
  while (!text.empty()) {
    int32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc()) out.push_back(value);
    text.remove_prefix(std::max<size_t>(1, static_cast<size_t>(end - text.data())));
  }
  return out;
}

class Numbers {
 public:
  explicit Numbers(const weir::Options&) {}
  std::vector<weir_tensor_info> configure(std::string_view caps) {
    if (caps.find("refused") != std::string_view::npos)
      throw weir::Failure({.code = weir::Code::OPTION_VALUE,
                           .what = "these caps are refused",
                           .offered = std::string(caps),
                           .needed = "others",
                           .fix = "mode=(string)accepted"});
    if (caps.find("unknown") != std::string_view::npos)
      return {weir::dense_tensor(WEIR_INT32, {-1})};
    if (caps.find("three") != std::string_view::npos)
      return {weir::dense_tensor(WEIR_INT32, {1, 3})};
    return {};
  }
  bool convert(const weir_frame& frame, weir::ConverterOutput& output) {
    ++frames_;
    std::string text;
    for (uint32_t i = 0; i < frame.n_tensors; ++i)
      text.append(static_cast<const char*>(frame.tensors[i].data), frame.tensors[i].bytes);
    if (text == "drop") return false;
    if (text == "nothing") return true;
    if (text == "time") output.set_time(frame.pts + 1, 2);
    rate_.reset();
    if (text == "rate") rate_ = {25, 1};
    if (text == "no rate") rate_ = {25, 0};
    if (rate_) return add({25}, output);
    if (text == "count" || text == "time") return add({frames_}, output);
    if (text == "many") return add_many(output);
    err(text, output);
    for (size_t at = 0; at <= text.size();) {
      const size_t end = std::min(text.find(';', at), text.size());
      add(numbers_in(std::string_view(text).substr(at, end - at)), output);
      at = end + 1;
    }
    return true;
  }
  void reset() noexcept { frames_ = 0; }
  std::optional<std::pair<int32_t, int32_t>> rate() const noexcept { return rate_; }

 private:
  static bool add(const std::vector<int32_t>& values, weir::ConverterOutput& output) {
    const auto to =
        output.add(weir::dense_tensor(WEIR_INT32, {static_cast<int64_t>(values.size())}));
    std::memcpy(to.data(), values.data(), to.size());
    return true;
  }
  static bool add_many(weir::ConverterOutput& output) {
    for (int32_t i = 0; i <= WEIR_TENSOR_LIMIT; ++i) add({i}, output);
    return true;
  }
  static void err(const std::string& what, weir::ConverterOutput& output) {
    if (what == "failure")
      throw weir::Failure({.code = weir::Code::OPTION_VALUE,
                           .what = "failed as ordered",
                           .offered = "failure",
                           .needed = "numbers",
                           .fix = "send numbers"});
    if (what == "exception") throw std::runtime_error("thrown in a converter");
    if (what == "number") throw 42;
    if (what != "memory") return;
    add({1}, output);  // the host must release it
    throw std::bad_alloc();
  }

  int32_t frames_ = 0;
  std::optional<std::pair<int32_t, int32_t>> rate_;
};

}  // namespace

WEIR_CONVERTER(Numbers, "numbers", "application/x-numbers-too",
               "application/x-numbers, framerate=(fraction)[ 0/1, 2147483647/1 ]", "[]")
