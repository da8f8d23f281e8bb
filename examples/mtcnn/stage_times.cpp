// Writes the times of each picture as JSON.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "stage_times.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <span>

#include "weir/join.hpp"

namespace mtcnn {
namespace {

// Formats seconds as JSON.
std::string list(std::span<const std::chrono::steady_clock::time_point> times) {
  const auto format_time = [](std::chrono::steady_clock::time_point time) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6f",
                  std::chrono::duration<double>(time.time_since_epoch()).count());
    return std::string(text);
  };
  return "[" + weir::join(times, ", ", format_time) + "]";
}

}  // namespace

void StageTimes::reached(Stage stage, int64_t pts, Clock::time_point time) {
  const std::lock_guard lock(mutex_);
  times_[pts][static_cast<size_t>(stage)] = time;
}

void StageTimes::shown() {
  const auto now = Clock::now();
  const std::lock_guard lock(mutex_);
  shown_.push_back(now);
}

void StageTimes::copied(uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  copied_ = copied_.value_or(0) + bytes;
}

weir::Status StageTimes::write(const std::string& file) const {
  const std::lock_guard lock(mutex_);
  const std::unique_ptr<FILE, int (*)(FILE*)> out(std::fopen(file.c_str(), "w"), std::fclose);
  if (!out)
    return weir::Error{.code = weir::Code::FILE_NOT_WRITTEN,
                       .what = "the report cannot be written",
                       .offered = file};
  std::string pictures;
  size_t begun = 0;
  for (const auto& [pts, stages] : times_) {
    if (stages[0] != Clock::time_point{}) ++begun;
    if (std::ranges::count(stages, Clock::time_point{}) == 0)
      pictures += (pictures.empty() ? "" : ",\n") + list(stages);
  }
  std::fprintf(out.get(), "{\"pictures\": [%s], \"begun\": %zu, \"shown\": %s, \"copied\": %s}\n",
               pictures.c_str(), begun, list(shown_).c_str(),
               copied_ ? std::to_string(*copied_).c_str() : "null");
  return weir::ok();
}

}  // namespace mtcnn
