// Test that every engine must pass: without memory it returns errors, and runs again once memory is
// available. Runs in a child process with a limited address space.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <new>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "address_space.hpp"
#include "engine_host_test_support.hpp"

namespace weir::engine_test {

// While it exists, the process may use `room` more bytes of address space than at its construction
// (RLIMIT_AS), for memory and thread stacks.
class AddressSpaceLimit {
 public:
  explicit AddressSpaceLimit(uint64_t room) {
    getrlimit(RLIMIT_AS, &before_);
    rlimit limited = before_;
    limited.rlim_cur = used() + room;
    setrlimit(RLIMIT_AS, &limited);
  }
  AddressSpaceLimit(const AddressSpaceLimit&) = delete;
  AddressSpaceLimit& operator=(const AddressSpaceLimit&) = delete;
  ~AddressSpaceLimit() { setrlimit(RLIMIT_AS, &before_); }

 private:
  // The first number of /proc/self/statm, read without an allocation.
  static uint64_t used() {
    char text[64]{};
    const int file = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
    if (file >= 0 && read(file, text, sizeof text - 1) < 0) text[0] = '\0';
    if (file >= 0) close(file);
    return std::strtoull(text, nullptr, 10) * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
  }

  rlimit before_{};
};

// The test's own objects can also run out of memory; the engine's functions throw nothing.
inline Status tried(const std::function<Status()>& attempt) {
  try {
    return attempt();
  } catch (const std::bad_alloc&) {
    return Error{.code = Code::OUT_OF_MEMORY, .what = "memory ran out in the test"};
  }
}

// Calls `attempt` with 1, 2, 4 ... 1024 MiB of free address space and then without a limit. It must
// return errors first and then successes; returns a line of text for anything else.
inline std::string faults_without_memory(const std::function<Status()>& attempt) {
  std::string faults;
  int errors = 0;
  for (uint64_t mebibytes = 1; mebibytes <= 1024; mebibytes *= 2) {
    Status status = ok();
    {
      const AddressSpaceLimit limit(mebibytes << 20);
      status = tried(attempt);
    }
    if (status) continue;
    ++errors;
    if (status.error().code != Code::OUT_OF_MEMORY) faults += status.error().message() + "\n";
  }
  if (errors == 0) faults += "1 MiB was enough\n";
  if (const Status status = attempt(); !status) faults += status.error().message() + "\n";
  return faults;
}

// A model with one float32 input and output, and the shape to run it on.
struct MemoryCase {
  const weir_engine& engine;
  std::string path;
  std::vector<int64_t> shape;
  std::string folder;  // deleted at the end
  // Opens the model once with enough memory: the C library ends a process that has none for the
  // thread-local data of a library that is being loaded.
  bool is_loaded_before = false;
};

// Opens and runs the model; the engine allocates the output.
inline Status open_and_run(const MemoryCase& given, std::span<float> x) {
  const auto model = OpenEngine::open(given.engine, given.path, {}, 2);
  if (!model) return model.error();
  OneToOne frames(given.shape, x);
  const auto resolved = (*model)->resolve({frames.in.info});
  if (!resolved) return resolved.error();
  frames.out.info = (*resolved)[0];
  const Status status = frames.through(**model);
  if (frames.out.release) frames.out.release(frames.out.owner);
  return status;
}

inline void run_without_memory_and_exit(const MemoryCase& given) {
  const auto elements =
      std::accumulate(given.shape.begin(), given.shape.end(), int64_t{1}, std::multiplies<>());
  std::vector<float> x(static_cast<size_t>(elements), 1);
  if (given.is_loaded_before) {
    EXPECT_TRUE(open_and_run(given, x));
  }
  const std::string faults = faults_without_memory([&] { return open_and_run(given, x); });
  std::filesystem::remove_all(given.folder);
  std::fprintf(stderr, "%s", faults.empty() ? "errors, then successes" : faults.c_str());
  std::_Exit(0);
}

inline void expect_errors_without_memory(const MemoryCase& given) {
  if (!can_limit_address_space()) GTEST_SKIP() << "the address space cannot be limited";
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(run_without_memory_and_exit(given), testing::ExitedWithCode(0),
              "errors, then successes");
}

}  // namespace weir::engine_test
