// Measures routing elements per frame with growing numbers of pads and sizes of frames; prints one
// JSON object per line for tools/plot. CPU time of all threads in microseconds.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdio>
#include <cstdlib>

#include "branch_stage.hpp"
#include "inputs_stage.hpp"
#include "rounds.hpp"

namespace {

using weir::bench::BranchStage;
using weir::bench::InputLine;
using weir::bench::InputsStage;
using weir::gst::Ref;

constexpr size_t kBytesARound = 64u << 20;  // fewer frames when they are large
constexpr size_t kMaxFrames = 2000;

int count_frames(size_t bytes) {
  return static_cast<int>(std::clamp(kBytesARound / bytes, size_t{8}, kMaxFrames));
}
Ref<GstBuffer> make_buffer(size_t bytes) {
  auto buffer = Ref<GstBuffer>::adopt(gst_buffer_new_allocate(nullptr, bytes, nullptr));
  gst_buffer_memset(buffer.get(), 0, 7, bytes);
  GST_BUFFER_PTS(buffer.get()) = 0;
  return buffer;
}
std::string tensor(size_t bytes) {
  return "other/tensor,dimension=(string)" + std::to_string(bytes) + ",type=uint8,framerate=30/1";
}
std::string tensors(size_t count, size_t bytes) {
  std::string dimensions, types;
  for (size_t i = 0; i < count; ++i) {
    dimensions += (i ? "," : "") + std::to_string(bytes);
    types += i ? ",uint8" : "uint8";
  }
  return "other/tensors,format=static,num_tensors=" + std::to_string(count) +
         ",dimensions=(string)\"" + dimensions + "\",types=(string)\"" + types +
         "\",framerate=30/1";
}

template <class Stage>
void measure(const char* series, const char* axis, size_t x, Stage&& stage, size_t bytes,
             int rounds) {
  const int frames = count_frames(bytes);
  const auto cost = weir::bench::medians({[&] { stage.push(frames); }}, rounds)[0];
  std::printf("{\"series\": \"%s\", \"axis\": \"%s\", \"x\": %zu, \"us\": %.4f}\n", series, axis, x,
              cost.cpu / frames * 1e6);
  std::fflush(stdout);
}

void inputs(const char* series, const char* launch, const char* axis, size_t x, size_t pads,
            size_t bytes, int rounds) {
  measure(series, axis, x,
          InputsStage(launch,
                      std::vector<InputLine>(pads, {"sink_%u", tensor(bytes), make_buffer(bytes)})),
          pads * bytes, rounds);
}
void branches(const char* series, const std::string& launch, const char* axis, size_t x,
              size_t count, size_t bytes, int rounds) {
  measure(series, axis, x,
          BranchStage(launch, tensors(count, bytes), std::vector<size_t>(count, bytes)),
          count * bytes, rounds);
}

}  // namespace

int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 9;
  for (const size_t pads : {1, 2, 4, 8, 16}) {
    inputs("tensor_mux", "tensor_mux sync-mode=nosync", "pads", pads, pads, 1024, rounds);
    inputs("tensor_merge", "tensor_merge option=0", "pads", pads, pads, 1024, rounds);
    branches("tensor_demux", "tensor_demux", "pads", pads, pads, 1024, rounds);
  }
  for (size_t bytes = 1024; bytes <= (size_t{4} << 20); bytes *= 8) {
    const std::string half = std::to_string(bytes / 2);
    inputs("tensor_mux (2 pads)", "tensor_mux sync-mode=nosync", "bytes", bytes, 2, bytes, rounds);
    inputs("tensor_merge (2 pads)", "tensor_merge option=0", "bytes", bytes, 2, bytes, rounds);
    branches("tensor_demux (2 pads)", "tensor_demux", "bytes", bytes, 2, bytes, rounds);
    branches("tensor_split (2 segments)", "tensor_split tensorseg=" + half + "," + half, "bytes",
             bytes, 1, bytes, rounds);
    branches("tensor_aggregator (4 frames)", "tensor_aggregator frames-out=4 frames-dim=0", "bytes",
             bytes, 1, bytes, rounds);
    branches("tensor_if", "tensor_if compared-value-option=5,0 operator=GT supplied-value=100",
             "bytes", bytes, 1, bytes, rounds);
  }
}
