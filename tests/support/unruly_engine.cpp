// An engine for tests that does to its process what native code can do. On uint8 [-1]: the output
// is the sum of the bytes, as one uint64; the first byte of a frame says what else happens.
// Options: open:WORD does it when the model is opened, output:dynamic lets the engine allocate its
// output, frames it cannot know the size of: as many bytes as the input has, each one greater.
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <numeric>
#include <string>
#include <vector>

#include "weir/engine.hpp"

namespace {

// What the first byte of a frame orders; the numbers are used by the tests.
enum Order : uint8_t {
  kNothing = 0,
  kCrash = 200,
  kAbort,
  kExit,
  kLoop,
  kEatMemory,
  kWriteInput,  // memory that is only lent for reading
  kSocket,      // 0 and errno of what is tried, as the result
  kFork,
  kExec,
  kKillParent,
  kCloseSocket,   // to the pipeline
  kTalkNonsense,  // to the pipeline
  kFail,
  kDrop,
  kProcess,     // its own id, as the result
  kKeepMemory,  // reads behind the input: padding
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

void talk_nonsense() {
  const std::vector<uint32_t> words(64, 0xFFFFFFFF);
  if (write(3, words.data(), words.size() * sizeof words[0]) < 0) abort();
}

void obey_at_open(std::string_view word) {
  if (word == "crash") crash();
  if (word == "abort") abort();
  if (word == "exit") exit(4);
  if (word == "loop") loop_for_ever();
  if (word == "memory") eat_memory();
  if (word == "throw") throw std::bad_alloc();
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
        throw weir::Failure({weir::Code::INVOKE_FAILED, "ordered to fail", "the first byte", "", "",
                             "another frame"});
      case kProcess:
        *result = static_cast<uint64_t>(getpid());
        return;
      case kKeepMemory:
        *result = in.capacity;
        return;
      default:
        return;
    }
  }

  weir_tensor_info input_{}, output_{};
  bool dynamic_ = false;
};

}  // namespace

WEIR_ENGINE(Unruly, "unruly", "1", "", "")
