// Measures tensor_filter with users' C and C++ filters: a function of the program (custom-easy), a
// class (cpp), a shared object with Weir's interface (custom). Reports the CPU time of a 1 KB frame
// above the same copy in a plain loop, as the minimum of interleaved rounds.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdlib>
#include <cstring>
#include <vector>

#include "element_stage.hpp"
#include "rounds.hpp"
#include "weir/custom_filter.hpp"

namespace {

constexpr size_t kBytes = 1024;
constexpr int kFrames = 2000;
constexpr const char* kCaps =
    "other/tensors,format=static,num_tensors=1,dimensions=(string)1024,types=(string)uint8,"
    "framerate=(fraction)30/1";

weir_tensor_info bytes(int64_t count) {
  return weir::tensor_info("bytes", WEIR_UINT8, {count});
}
void copy(std::span<const weir_tensor> in, std::span<weir_tensor> out) {
  std::memcpy(out[0].data, in[0].data, in[0].bytes);
}

class Copier {
 public:
  static constexpr uint64_t kFlags = WEIR_ENGINE_NEEDS_NO_MODEL;
  explicit Copier(const weir::OpenRequest&) {}
  std::span<const weir_tensor_info> inputs() const { return {&bytes_, 1}; }
  std::span<const weir_tensor_info> outputs() const { return {&bytes_, 1}; }
  bool invoke(std::span<const weir_tensor> in, std::span<weir_tensor> out) {
    copy(in, out);
    return true;
  }

 private:
  weir_tensor_info bytes_ = bytes(kBytes);
};

void plain_copies() {
  static std::vector<unsigned char> from(kBytes), to(kBytes);
  for (int i = 0; i < kFrames; ++i) {
    std::memcpy(to.data(), from.data(), kBytes);
    __asm__ volatile("" ::: "memory");  // prevents eliding the copies
  }
}

}  // namespace

// Usage: custom_cost SHARED_OBJECT ROUNDS
int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  if (argc != 3) return 2;
  const weir::RegisteredFilter function(
      "copier", {.inputs = {bytes(kBytes)}, .outputs = {bytes(kBytes)}}, copy);
  const weir::RegisteredFilterClass<Copier> type("copier-class");
  using weir::bench::ElementStage;
  ElementStage easy("tensor_filter framework=custom-easy model=copier", kCaps, kBytes);
  ElementStage cpp("tensor_filter framework=cpp model=copier-class", kCaps, kBytes);
  ElementStage custom(std::string("tensor_filter framework=custom model=") + argv[1], kCaps,
                      kBytes);
  const auto costs = weir::bench::min({plain_copies, [&] { easy.push(kFrames); },
                                       [&] { cpp.push(kFrames); }, [&] { custom.push(kFrames); }},
                                      std::atoi(argv[2]));
  size_t at = 0;
  for (const char* what : {"custom-easy", "cpp", "custom"})
    weir::bench::report(
        std::string("tensor_filter framework=") + what + ", 1 KB copied: CPU above it",
        "the copy in a bare loop", (costs[++at].cpu - costs[0].cpu) / kFrames * 1e6, "us", 20);
}
