// SPDX-License-Identifier: LGPL-2.1-or-later
#include "evaluate/progress_bar.hpp"

#include <unistd.h>

#include <cstdio>

#include "run/html.hpp"

namespace weir::app {

ProgressBar::ProgressBar(size_t all, std::string unit)
    : all_(all), unit_(std::move(unit)), is_terminal_(isatty(STDERR_FILENO) == 1) {}

void ProgressBar::step() {
  constexpr std::chrono::milliseconds kBetween{100};
  ++done_;
  const auto now = Clock::now();
  if (!is_terminal_ || now - shown_ < kBetween) return;
  shown_ = now;
  print("");
}

void ProgressBar::show(const std::string& next) {
  if (is_terminal_) print(": " + next);
}

void ProgressBar::print(const std::string& end) {
  const double seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
  std::fprintf(stderr, "\r\033[K%s%s", progress_text(done_, all_, unit_, seconds).c_str(),
               end.c_str());
  std::fflush(stderr);
  is_visible_ = true;
}

void ProgressBar::clear() {
  if (is_visible_) std::fputs("\r\033[K", stderr);
  is_visible_ = false;
}

std::string progress_text(size_t done, size_t all, const std::string& unit, double seconds) {
  constexpr size_t kLength = 30;
  const size_t marks = all > 0 ? kLength * done / all : 0;
  std::string out = "[" + std::string(marks, '#') + std::string(kLength - marks, ' ') + "] " +
                    std::to_string(done) + "/" + std::to_string(all) + " " + unit;
  if (seconds > 0) out += ", " + fixed(static_cast<double>(done) / seconds, 1) + " a second";
  return out;
}

}  // namespace weir::app
