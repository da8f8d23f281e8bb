// A bar on standard error that shows how many pictures or draws are done, if standard error is a
// terminal.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <cstddef>
#include <string>

namespace weir::app {

class ProgressBar {
 public:
  ProgressBar(size_t all, std::string unit);
  ~ProgressBar() { clear(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void step();                         // one more is done
  void show(const std::string& next);  // at once, with what is being done
  void clear();                        // before other text is printed

 private:
  using Clock = std::chrono::steady_clock;

  void print(const std::string& end);

  const size_t all_;
  const std::string unit_;
  const bool is_terminal_;
  const Clock::time_point begin_ = Clock::now();
  Clock::time_point shown_ = {};
  size_t done_ = 0;
  bool is_visible_ = false;
};

// "[#####               ] 25/100 pictures, 12.5 a second"
std::string progress_text(size_t done, size_t all, const std::string& unit, double seconds);

}  // namespace weir::app
