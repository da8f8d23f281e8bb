// Helpers of the tests of local streams: paths, frames, other processes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "becomes.hpp"
#include "says.hpp"
#include "transport/local/publisher.hpp"
#include "transport/local/subscriber.hpp"

namespace weir::local::test {

// A folder that ends with the object.
class Folder {
 public:
  Folder() {
    std::string name = std::filesystem::temp_directory_path() / "weir-local-XXXXXX";
    path_ = mkdtemp(name.data());
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string file(const char* name = "stream") const { return path_ + "/" + name; }

 private:
  std::string path_;
};

inline std::unique_ptr<Publisher> publisher_at(const std::string& path, uint32_t max_held = 16,
                                               bool drop = false) {
  auto out = Publisher::open(
      {.path = path, .max_held = max_held, .drop = drop, .max_readers = 32, .refused = {}});
  EXPECT_TRUE(out) << (out ? "" : out.error().message());
  return out ? *std::move(out) : nullptr;
}

inline std::byte make_byte(uint64_t seed, size_t i) {
  return static_cast<std::byte>((seed * 2654435761U + i * 40503U) >> 7);
}

// A frame of one memory in the publisher's arena, with bytes that depend on `seed`.
inline LocalFrame make_frame(const Publisher& publisher, uint64_t seed, size_t bytes = 4096) {
  const auto block = publisher.arena()->allocate(bytes);
  LocalFrame out;
  if (!block) return out;
  for (size_t i = 0; i < bytes; ++i) block->data()[i] = make_byte(seed, i);
  const auto place = publisher.arena()->find(block->data(), bytes);
  out.times = {.pts = seed,
               .dts = seed + 1,
               .duration = seed + 2,
               .offset = seed + 3,
               .offset_end = seed + 4,
               .flags = 0x40};
  out.memories.push_back({place->block, place->offset, bytes});
  out.owner = block;
  return out;
}

inline Publisher::Outcome publish(Publisher& publisher, LocalFrame frame) {
  return publisher.publish(&frame);
}

inline bool is_made_frame(const ReceivedFrame& frame, uint64_t seed, size_t bytes = 4096) {
  if (frame.memories.size() != 1 || frame.memories[0].size() != bytes) return false;
  for (size_t i = 0; i < bytes; ++i)
    if (frame.memories[0][i] != make_byte(seed, i)) return false;
  return frame.times.pts == seed;
}

inline Subscriber subscriber_at(const std::string& path) {
  auto out = Subscriber::connect(path);
  EXPECT_TRUE(out) << (out ? "" : out.error().message());
  if (!out) std::abort();
  return *std::move(out);
}

inline bool readers_become(const Publisher& publisher, uint32_t count) {
  return becomes_true([&] { return publisher.counts().readers == count; },
                      std::to_string(count) + " readers");
}

// A reader of a writer that may start later.
inline std::optional<Subscriber> subscriber_when_served(const std::string& path) {
  std::optional<Subscriber> out;
  const auto connects = [&] {
    auto made = Subscriber::connect(path);
    if (made) out.emplace(*std::move(made));
    return out.has_value();
  };
  return becomes_true(connects, "a writer") ? std::move(out) : std::nullopt;
}

// Another process that runs `body`, exits with its value, and ends with this one. To be called
// while this process has one thread, so before it has a publisher: a lock that another thread holds
// stays locked in the copy, such as that of AddressSanitizer's allocator.
template <class Body>
pid_t process(const Body& body) {
  const pid_t child = fork();
  if (child != 0) return child;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  _exit(body());
}
inline int wait_for_exit(pid_t child) {
  int status = -1;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
}

inline size_t open_descriptors() {
  size_t count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator("/proc/self/fd"))
    ++count;
  return count;
}

}  // namespace weir::local::test
