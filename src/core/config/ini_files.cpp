// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/config/ini_files.hpp"

#include <ctime>

namespace weir::config {
namespace {

constexpr size_t kMaxFiles = 16;           // a process uses three or four
constexpr int64_t kSettled = 100'000'000;  // ns; the kernel's file clock ticks every 4 ms

int64_t nanoseconds(const timespec& time) {
  return int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

bool same(const timespec& a, const timespec& b) {
  return nanoseconds(a) == nanoseconds(b);
}

bool same(const struct stat& a, const struct stat& b) {
  return a.st_dev == b.st_dev && a.st_ino == b.st_ino && a.st_size == b.st_size &&
         same(a.st_mtim, b.st_mtim) && same(a.st_ctim, b.st_ctim);
}

bool is_settled(const struct stat& file) {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return nanoseconds(now) - nanoseconds(file.st_ctim) > kSettled;
}

}  // namespace

std::shared_ptr<const Ini> IniFiles::read(const std::string& path) {
  struct stat identity {};
  const bool is_there = stat(path.c_str(), &identity) == 0;
  const bool settled = is_there && is_settled(identity);
  const std::lock_guard lock(mutex_);
  const auto found = kept_.find(path);
  if (found != kept_.end() && is_there && same(found->second.identity, identity))
    return found->second.ini;
  if (found != kept_.end()) kept_.erase(found);
  ++reads_;
  auto ini = std::make_shared<const Ini>(read_ini(path));
  if (kept_.size() >= kMaxFiles) kept_.clear();
  if (settled) kept_[path] = {identity, ini};
  return ini;
}

uint64_t IniFiles::reads() const {
  const std::lock_guard lock(mutex_);
  return reads_;
}

}  // namespace weir::config
