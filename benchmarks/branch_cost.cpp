// Measures tensor_demux, tensor_split and tensor_if per frame above GStreamer's identity, and their
// copies and passes against plain loops.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstring>

#include "branch_stage.hpp"
#include "rounds.hpp"

namespace {

using weir::bench::BranchStage;

constexpr int kFrames = 5000, kRounds = 15;
constexpr size_t kWidth = 1920, kHeight = 1080, kPixels = kWidth * kHeight;

// Caps of this many uint8 tensors of 1 KB.
std::string tensors(int count) {
  std::string dimensions = "1024", types = "uint8";
  for (int i = 1; i < count; ++i) dimensions += ",1024", types += ",uint8";
  return "other/tensors,format=static,num_tensors=" + std::to_string(count) +
         ",dimensions=(string)\"" + dimensions + "\",types=(string)\"" + types +
         "\",framerate=30/1";
}

// Measured above an identity that gets the same frames.
void per_frame(const std::string& name, const std::string& launch, int count, double max_us) {
  const std::vector<size_t> bytes(static_cast<size_t>(count), 1024);
  BranchStage floor("identity", tensors(count), bytes), stage(launch, tensors(count), bytes);
  const auto costs =
      weir::bench::medians({[&] { floor.push(kFrames); }, [&] { stage.push(kFrames); }}, kRounds);
  weir::bench::report("cost of a frame: " + name, "identity",
                      (costs[1].cpu - costs[0].cpu) / kFrames * 1e6, "us", max_us);
}

std::string picture() {
  return "other/tensors,format=static,num_tensors=1,dimensions=(string)3:1920:1080,types=uint8,"
         "framerate=30/1";
}

// Copies a block at every `Step` bytes.
template <size_t Block, size_t Step>
void copy_blocks(const uint8_t* from, uint8_t* to) {
  for (size_t n = 3 * kPixels / Step; n > 0; --n, from += Step, to += Block)
    std::memcpy(to, from, Block);
}

// Splits a Full HD picture along a dimension, above identity, against loops that copy the same
// blocks, with a compile-time length, into existing memory.
template <size_t First, size_t Second>
void strided(int dimension, const std::string& sizes) {
  constexpr int kPictures = 10;
  constexpr size_t kStep = First + Second;
  BranchStage floor("identity", picture(), {3 * kPixels});
  BranchStage stage("tensor_split split-dim=" + std::to_string(dimension) + " tensorseg=" + sizes,
                    picture(), {3 * kPixels});
  const std::vector<uint8_t> from(3 * kPixels, 1);
  std::vector<uint8_t> one(3 * kPixels / kStep * First), two(3 * kPixels / kStep * Second);
  const auto bare = [&] {
    for (int i = 0; i < kPictures; ++i) {
      copy_blocks<First, kStep>(from.data(), one.data());
      copy_blocks<Second, kStep>(from.data() + First, two.data());
    }
  };
  const auto costs = weir::bench::medians(
      {bare, [&] { floor.push(kPictures); }, [&] { stage.push(kPictures); }}, kRounds);
  weir::bench::report("Full HD cut along dimension " + std::to_string(dimension) + ": time",
                      "a bare strided copy", (costs[2].cpu - costs[1].cpu) / costs[0].cpu, "x",
                      1.2);
}

void average() {
  constexpr int kPictures = 20;
  BranchStage stage(
      "tensor_if compared-value=TENSOR_AVERAGE_VALUE compared-value-option=0 operator=GT "
      "supplied-value=100",
      picture(), {3 * kPixels});
  std::vector<uint8_t> from(3 * kPixels, 1), to(3 * kPixels);
  const auto pass = [&] {
    for (int i = 0; i < kPictures; ++i) std::memcpy(to.data(), from.data(), from.size());
  };
  const auto costs = weir::bench::medians({pass, [&] { stage.push(kPictures); }}, kRounds);
  weir::bench::report("Full HD, tensor_if by its average: time", "a memcpy of the picture",
                      costs[1].cpu / costs[0].cpu, "x", 4);
}

}  // namespace

int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  for (const int count : {2, 8, 16})
    per_frame("tensor_demux, " + std::to_string(count) + " pads", "tensor_demux", count,
              0.3 * count);
  per_frame("tensor_split, 2 segments", "tensor_split tensorseg=512,512", 1, 0.8);
  per_frame("tensor_if, an element",
            "tensor_if compared-value-option=5,0 operator=GT supplied-value=100", 1, 0.3);
  per_frame("tensor_if, an average",
            "tensor_if compared-value=TENSOR_AVERAGE_VALUE compared-value-option=0 operator=GT "
            "supplied-value=100",
            1, 1);
  per_frame("tensor_if, 1 of 2 tensors picked",
            "tensor_if compared-value-option=5,0 operator=GT supplied-value=100 else=TENSORPICK "
            "else-option=1",
            2, 1.2);
  strided<1, 2>(0, "1,2");
  strided<2880, 2880>(1, "960,960");
  average();
}
