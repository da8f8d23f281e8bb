// Measures memory sharing between two cores, without Weir: one thread writes 150 KB, then the same
// thread or one on another core sums them, repeatedly. Times of each pass as measured by its own
// thread. Usage: other_core_cost ROUNDS
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <sched.h>
#include <sys/mman.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <numeric>
#include <thread>
#include <vector>

#include "rounds.hpp"

namespace {

constexpr size_t kBytes = 224 * 224 * 3;
using weir::bench::seconds;

std::vector<int> usable_cores() {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  sched_getaffinity(0, sizeof allowed, &allowed);
  std::vector<int> out;
  for (int i = 0; i < CPU_SETSIZE; ++i)
    if (CPU_ISSET(i, &allowed)) out.push_back(i);
  return out;
}
void stay_on(int core) {
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(core, &one);
  sched_setaffinity(0, sizeof one, &one);
}

// As compiled in an engine with -O2.
__attribute__((noinline)) uint64_t add(const uint8_t* from) {
  return std::accumulate(from, from + kBytes, uint64_t{0});
}
// glibc's string functions, and plain stores.
__attribute__((noinline)) void write_by_memcpy(uint8_t* to, const uint8_t* from) {
  std::memcpy(to, from, kBytes);
}
__attribute__((noinline)) void write_by_stores(uint8_t* to, const uint8_t* from) {
  for (size_t i = 0; i < kBytes; i += sizeof(uint64_t)) {
    uint64_t word;
    std::memcpy(&word, from + i, sizeof word);
    word ^= 0x55;
    std::memcpy(to + i, &word, sizeof word);
  }
}

struct Times {
  double write, read;
};
using Write = void (*)(uint8_t*, const uint8_t*);

// `read_core` < 0: reads on the writing thread.
Times measure(uint8_t* page, const uint8_t* from, Write write, int read_core, int rounds) {
  const std::vector<uint8_t> source(kBytes, 3);
  std::vector<double> writes, reads;
  std::atomic<int> turn{0};
  std::atomic<double> other_read{0};
  std::atomic<uint64_t> sum{0};
  const auto timed = [&] {
    const double began = seconds(CLOCK_MONOTONIC);
    sum += add(from);
    return seconds(CLOCK_MONOTONIC) - began;
  };
  const auto wait_for = [&turn](int value) {
    while (turn.load(std::memory_order_acquire) != value) {
    }
  };
  std::thread reader;
  if (read_core >= 0)
    reader = std::thread([&] {
      stay_on(read_core);
      for (int i = 0; i < rounds; ++i) {
        wait_for(2 * i + 1);
        other_read = timed();
        turn.store(2 * i + 2, std::memory_order_release);
      }
    });
  for (int i = 0; i < rounds; ++i) {
    const double began = seconds(CLOCK_MONOTONIC);
    write(page, source.data());
    writes.push_back(seconds(CLOCK_MONOTONIC) - began);
    if (read_core >= 0) {
      turn.store(2 * i + 1, std::memory_order_release);
      wait_for(2 * i + 2);
    }
    reads.push_back(read_core >= 0 ? other_read.load() : timed());
  }
  if (reader.joinable()) reader.join();
  return {weir::bench::median(writes) * 1e6, weir::bench::median(reads) * 1e6};
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc == 2 ? std::max(1, std::atoi(argv[1])) : 0;
  const auto cores = usable_cores();
  if (rounds == 0 || cores.size() < 2) {
    std::fprintf(stderr, "other_core_cost ROUNDS, on two cores at least\n");
    return 2;
  }
  stay_on(cores[0]);
  void* const shared = mmap(nullptr, 2 * kBytes, PROT_READ | PROT_WRITE,
                            MAP_SHARED | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
  if (shared == MAP_FAILED) return 1;
  auto* const page = static_cast<uint8_t*>(shared);
  const uint8_t* const untouched = page + kBytes;
  const auto print = [&](const char* what, const uint8_t* from, Write write, int core) {
    const Times times = measure(page, from, write, core, rounds);
    std::printf("  %-42s write %6.1f us   read %6.1f us\n", what, times.write, times.read);
  };
  const auto all = [&](const char* how, Write write) {
    std::printf("written by %s\n", how);
    print("one core writes and reads", page, write, -1);
    print("another core reads what this one writes", page, write, cores[1]);
    print("another core reads what is not written", untouched, write, cores[1]);
  };
  all("memcpy", write_by_memcpy);
  all("stores", write_by_stores);
  return 0;
}
