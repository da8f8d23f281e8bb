// Measures windows, a fixed rate and sparse tensors against the bytes that must be moved.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>
#include <memory>
#include <random>

#include "core/tensor/sparse.hpp"
#include "element_stage.hpp"
#include "rounds.hpp"

namespace {

using weir::bench::ElementStage;

constexpr int kRounds = 15;
constexpr size_t kFrame = size_t{3} * 640 * 480;
constexpr char kPicture[] =
    "other/tensors,format=static,num_tensors=1,dimensions=(string)3:640:480:1,types=uint8,"
    "framerate=30/1";

// Copies each frame once into memory for that many frames, which is reused like the windows' own.
class BareCopy {
 public:
  explicit BareCopy(size_t room) : room_(room), to_(room * kFrame) {}
  void frames(size_t count) {
    for (size_t i = 0; i < count; ++i)
      std::memcpy(to_.data() + i % room_ * kFrame, from_.data() + i % 4 * kFrame, kFrame);
  }

 private:
  size_t room_;
  std::vector<uint8_t> from_ = std::vector<uint8_t>(4 * kFrame, 1), to_;
};

void windows() {
  constexpr int kFrames = 200;
  BareCopy four_frames(4), strip(70);
  ElementStage identity("identity", kPicture, kFrame);
  ElementStage four("tensor_aggregator frames-in=1 frames-out=4 frames-flush=4 frames-dim=3",
                    kPicture, kFrame);
  ElementStage overlap("tensor_aggregator frames-out=10 frames-flush=1 frames-dim=3", kPicture,
                       kFrame);
  ElementStage rows("tensor_aggregator frames-out=4 frames-dim=2", kPicture, kFrame);
  const auto costs =
      weir::bench::medians({[&] { identity.push(kFrames); }, [&] { four_frames.frames(kFrames); },
                            [&] { strip.frames(kFrames); }, [&] { four.push(kFrames); },
                            [&] { overlap.push(kFrames); }, [&] { rows.push(kFrames); }},
                           kRounds);
  const auto against = [&](const char* name, size_t index, size_t floor, double max) {
    weir::bench::report(name, "a bare copy of each frame",
                        (costs[index].cpu - costs[0].cpu) / costs[floor].cpu, "x", max);
  };
  against("tensor_aggregator, 640x480, 4 frames together: CPU", 3, 1, 1.2);
  against("tensor_aggregator, 640x480, 10 frames, 90 % overlap: CPU", 4, 2, 1.3);
  against("tensor_aggregator, 640x480, 4 frames along rows: CPU", 5, 1, 1.2);
  weir::bench::report("tensor_aggregator, 10 frames, 90 % overlap: bytes moved",
                      "the bytes of each frame once",
                      static_cast<double>(overlap.stat("bytes-copied")) /
                          static_cast<double>(overlap.stat("received") * kFrame),
                      "x", 1.2);
}

void rate() {
  constexpr int kFrames = 20000;
  constexpr char kBytes[] = "other/tensor,dimension=(string)1024,type=uint8,framerate=1000/1";
  ElementStage floor("identity", kBytes, 1024), half("tensor_rate framerate=500/1", kBytes, 1024);
  const auto costs =
      weir::bench::medians({[&] { floor.push(kFrames); }, [&] { half.push(kFrames); }}, kRounds);
  weir::bench::report("cost of a 1 KB buffer: tensor_rate, half of the frames", "identity",
                      (costs[1].cpu - costs[0].cpu) / kFrames * 1e6, "us", 1.5);
}

// `percent` of the bytes, at random positions, are not zero.
void sparse(unsigned percent, double max_there, double max_back) {
  constexpr int kTimes = 50;
  const weir::TensorSpec spec{weir::ElementType::UInt8, weir::Shape{kFrame}, ""};
  std::mt19937 random(1);
  std::vector<std::byte> dense(kFrame), copy(kFrame);
  for (auto& byte : dense)
    if (random() % 100 < percent) byte = std::byte{7};
  auto chunk = *weir::to_sparse(spec, dense);
  const auto header = *weir::read_sparse_header(chunk);
  const auto costs =
      weir::bench::medians({[&] {
                              for (int i = 0; i < kTimes; ++i) {
                                std::memcpy(copy.data(), dense.data(), kFrame);
                                asm volatile("" : : "r"(copy.data()) : "memory");
                              }
                            },
                            [&] {
                              for (int i = 0; i < kTimes; ++i)
                                weir::write_sparse(*weir::sparse_header(spec, dense), dense, chunk);
                            },
                            [&] {
                              for (int i = 0; i < kTimes; ++i)
                                (void)weir::read_sparse(header, chunk, copy);
                            }},
                           kRounds);
  const std::string name = "sparse, " + std::to_string(percent) + " % of 640x480x3 not zero: ";
  weir::bench::report(name + "from dense", "a copy", costs[1].cpu / costs[0].cpu, "x", max_there);
  weir::bench::report(name + "to dense", "a copy", costs[2].cpu / costs[0].cpu, "x", max_back);
}

}  // namespace

int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  windows();
  rate();
  sparse(1, 8, 3);
  sparse(10, 30, 8);
}
