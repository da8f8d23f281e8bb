// An engine for tests that harms its process in the ways native code can. On uint8 [-1]: the output
// is the sum of the bytes as one uint64; the first byte of a frame selects what else happens.
// Options: open:WORD does it when the model is opened; with output:dynamic the engine allocates its
// output, whose size frames cannot predict: as many bytes as the input, each one greater.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <pthread.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <mutex>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

#include "weir/engine.hpp"
// Must follow weir/engine.hpp: a macro in this header has the name of an error code.
#include <sys/mman.h>

namespace {

// The orders in the first byte of a frame; the tests use the numbers.
enum Order : uint8_t {
  kNothing = 0,
  kCrash = 200,
  kAbort,
  kExit,
  kLoop,
  kEatMemory,
  kWriteInput,  // memory that is lent only for reading
  kSocket,      // the result is 0 and the errno of the attempt
  kFork,
  kExec,
  kKillParent,
  kCloseSocket,   // the pipeline's socket
  kTalkNonsense,  // to the pipeline
  kFail,
  kDrop,
  kProcess,     // the result is its process id
  kKeepMemory,  // reads the padding after the input
  kSystemCall,  // a SystemCallOrder; the result is errno, or kSucceeded and the value
  kThreads,     // starts and joins some; the result is their number
  kGenerate,    // writes a function into memory and calls it; the result is its return value
  kVariable     // whether the variable named by the next bytes is in the environment
};

constexpr uint64_t kSucceeded = uint64_t{1} << 32;

// The layout of a frame for kSystemCall. The bytes to which arguments point follow it.
struct SystemCallOrder {
  uint8_t order;
  uint8_t pointers;  // bit i: arguments[i] is an offset into those bytes
  uint8_t unused[6];
  int64_t number;
  int64_t arguments[6];
};

[[noreturn]] void loop_for_ever() {
  std::atomic<unsigned> turns{0};
  for (;;) ++turns;
}

void eat_memory() {
  std::vector<std::vector<char>> eaten;
  for (;;) eaten.emplace_back(16 << 20, 'x');
}

void crash() {
  raise(SIGSEGV);
}

uint64_t tried(long result) {
  return result < 0 ? static_cast<uint64_t>(errno) : 0;
}

uint64_t try_to_fork() {
  const pid_t child = fork();
  if (child == 0) _exit(0);
  if (child > 0) waitpid(child, nullptr, 0);
  return tried(child);
}

uint64_t try_to_exec() {
  char name[] = "/bin/true";
  char* const arguments[] = {name, nullptr};
  char* const environment[] = {nullptr};
  return tried(execve(name, arguments, environment));
}

uint64_t make_system_call(const uint8_t* bytes, uint64_t size) {
  SystemCallOrder order;
  if (size < sizeof order) return EINVAL;
  std::memcpy(&order, bytes, sizeof order);
  std::vector<uint8_t> data(bytes + sizeof order, bytes + size);  // writable for the kernel
  auto& a = order.arguments;
  for (size_t i = 0; i < std::size(a); ++i)
    if (order.pointers >> i & 1) a[i] = reinterpret_cast<int64_t>(data.data() + a[i]);
  const long value = syscall(order.number, a[0], a[1], a[2], a[3], a[4], a[5]);
  if (value < 0) return static_cast<uint64_t>(errno);
  return kSucceeded | static_cast<uint32_t>(value);
}

// Each waits for its turn. This thread names the last one, which the kernel checks in /proc.
uint64_t start_threads() {
  constexpr uint64_t kNumber = 4;
  std::mutex mutex;
  std::condition_variable changed;
  uint64_t turn = 0;
  std::vector<std::thread> threads;
  std::unique_lock hold(mutex);
  for (uint64_t i = 0; i < kNumber; ++i)
    threads.emplace_back([&, i] {
      std::unique_lock lock(mutex);
      changed.wait(lock, [&] { return turn == i; });
      ++turn;
      changed.notify_all();
    });
  const bool named = pthread_setname_np(threads.back().native_handle(), "unruly") == 0;
  hold.unlock();
  for (auto& thread : threads) thread.join();
  return named ? turn : 0;
}

uint64_t generate_code() {
#if defined(__x86_64__)
  const uint8_t code[] = {0xB8, 42, 0, 0, 0, 0xC3};  // mov eax, 42; ret
#else
  const uint32_t code[] = {0x52800540, 0xD65F03C0};  // mov w0, #42; ret
#endif
  constexpr size_t kPage = 65536;
  void* at = mmap(nullptr, kPage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (at == MAP_FAILED) return 0;
  std::memcpy(at, code, sizeof code);
  if (mprotect(at, kPage, PROT_READ | PROT_EXEC) != 0) return 0;
  __builtin___clear_cache(static_cast<char*>(at), static_cast<char*>(at) + sizeof code);
  const int result = reinterpret_cast<int (*)()>(at)();
  munmap(at, kPage);
  return static_cast<uint64_t>(result);
}

void talk_nonsense() {
  const std::vector<uint32_t> words(64, 0xFFFFFFFF);
  if (write(3, words.data(), words.size() * sizeof words[0]) < 0) abort();
}

// Only a sanitizer detects this.
void read_beyond_memory() {
  const std::vector<char> bytes(7, 'x');
  const volatile size_t end = bytes.size();
  static std::atomic<char> kept;
  kept = bytes.data()[end];
}

void obey_at_open(std::string_view word) {
  if (word == "crash") crash();
  if (word == "abort") abort();
  if (word == "exit") exit(4);
  if (word == "loop") loop_for_ever();
  if (word == "memory") eat_memory();
  if (word == "throw") throw std::bad_alloc();
  if (word == "overflow") read_beyond_memory();
}

class Unruly {
 public:
  explicit Unruly(const weir::OpenRequest& request) {
    if (const auto word = request.options.get("open")) obey_at_open(*word);
    dynamic_ = request.options.get("output") == "dynamic";
    input_.type = WEIR_UINT8;
    input_.rank = 1;
    input_.shape[0] = -1;
    input_.name = "bytes";
    input_.batch_axis = WEIR_NO_BATCH_AXIS;
    output_ = input_;
    output_.name = "result";
    if (!dynamic_) output_.type = WEIR_UINT64;
    if (!dynamic_) output_.shape[0] = 1;
  }
  std::span<const weir_tensor_info> inputs() const { return {&input_, 1}; }
  std::span<const weir_tensor_info> outputs() const { return {&output_, 1}; }

  bool invoke(std::span<const weir_tensor> in, std::span<weir_tensor> out) {
    auto* bytes = static_cast<uint8_t*>(in[0].data);
    if (in[0].bytes > 0 && bytes[0] == kDrop) return false;
    if (dynamic_) return allocate(in[0], out[0]);
    uint64_t result = std::accumulate(bytes, bytes + in[0].bytes, uint64_t{0});
    if (in[0].bytes > 0) obey(bytes, in[0], &result);
    std::memcpy(out[0].data, &result, sizeof result);
    return true;
  }

 private:
  bool allocate(const weir_tensor& in, weir_tensor& out) {
    if (weir::module_host->allocate(nullptr, WEIR_MEMORY_HOST, in.bytes, 1, &out) < 0)
      throw std::bad_alloc();
    out.info = in.info;
    const auto* from = static_cast<const uint8_t*>(in.data);
    auto* to = static_cast<uint8_t*>(out.data);
    for (uint64_t i = 0; i < in.bytes; ++i) to[i] = static_cast<uint8_t>(from[i] + 1);
    return true;
  }

  void obey(uint8_t* bytes, const weir_tensor& in, uint64_t* result) {
    switch (bytes[0]) {
      case kCrash:
        return crash();
      case kAbort:
        abort();
      case kExit:
        exit(3);
      case kLoop:
        loop_for_ever();
      case kEatMemory:
        return eat_memory();
      case kWriteInput:
        bytes[0] = 0;
        return;
      case kSocket:
        *result = tried(socket(AF_INET, SOCK_STREAM, 0));
        return;
      case kFork:
        *result = try_to_fork();
        return;
      case kExec:
        *result = try_to_exec();
        return;
      case kKillParent:
        *result = tried(kill(getppid(), 0));
        return;
      case kCloseSocket:
        close(3);
        return loop_for_ever();
      case kTalkNonsense:
        return talk_nonsense();
      case kFail:
        throw weir::Failure({.code = weir::Code::INVOKE_FAILED,
                             .what = "ordered to fail",
                             .offered = "the first byte",
                             .fix = "another frame"});
      case kProcess:
        *result = static_cast<uint64_t>(getpid());
        return;
      case kKeepMemory:
        *result = in.capacity;
        return;
      case kSystemCall:
        *result = make_system_call(bytes, in.bytes);
        return;
      case kThreads:
        *result = start_threads();
        return;
      case kGenerate:
        *result = generate_code();
        return;
      case kVariable: {
        const std::string name(reinterpret_cast<const char*>(bytes + 1), in.bytes - 1);
        *result = getenv(name.c_str()) ? 1 : 0;
        return;
      }
      default:
        return;
    }
  }

  weir_tensor_info input_{}, output_{};
  bool dynamic_ = false;
};

}  // namespace

WEIR_ENGINE(Unruly, "unruly", "1", "", "")
