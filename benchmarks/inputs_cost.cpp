// Measures elements with many inputs: tensor_mux with growing numbers of pads against threads that
// only synchronise; tensor_merge along each dimension and tensor_crop against plain copies.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <mutex>

#include "core/tensor/tensor_header.hpp"
#include "inputs_stage.hpp"
#include "rounds.hpp"

namespace {

using weir::bench::InputLine;
using weir::bench::InputsStage;
using weir::gst::Ref;

constexpr int kMuxFrames = 2000, kPictures = 40;
constexpr size_t kWidth = 1920, kHeight = 1080, kPicture = 3 * kWidth * kHeight;

Ref<GstBuffer> make_buffer(size_t bytes) {
  auto buffer = Ref<GstBuffer>::adopt(gst_buffer_new_allocate(nullptr, bytes, nullptr));
  gst_buffer_memset(buffer.get(), 0, 7, bytes);
  GST_BUFFER_PTS(buffer.get()) = 0;
  return buffer;
}
std::string tensor(const std::string& dims) {
  return "other/tensor,dimension=(string)" + dims + ",type=uint8,framerate=30/1";
}

// Threads that sleep until all have arrived; std::barrier would spin first, unlike a stream.
void meet(int threads, int times) {
  std::mutex mutex;
  std::condition_variable met;
  int here = 0, meeting = 0;
  std::vector<std::thread> all;
  for (int t = 0; t < threads; ++t)
    all.emplace_back([&] {
      for (int i = 0; i < times; ++i) {
        std::unique_lock lock(mutex);
        if (++here < threads) {
          met.wait(lock, [&] { return meeting > i; });
          continue;
        }
        here = 0;
        ++meeting;
        lock.unlock();
        met.notify_all();
      }
    });
  for (auto& thread : all) thread.join();
}

void measure_mux(int rounds) {
  for (const int pads : {2, 8, 16}) {
    InputsStage stage("tensor_mux sync-mode=nosync",
                      std::vector<InputLine>(static_cast<size_t>(pads),
                                             {"sink_%u", tensor("1024"), make_buffer(1024)}));
    const auto costs = weir::bench::min(
        {[&] { meet(pads, kMuxFrames); }, [&] { stage.push(kMuxFrames); }}, rounds);
    const double floor = costs[0].cpu / kMuxFrames * 1e6;
    weir::bench::report(
        "tensor_mux of " + std::to_string(pads) + " pads: CPU of a frame out",
        "threads that only meet, " + std::to_string(static_cast<int>(floor)) + " us",
        costs[1].cpu / costs[0].cpu, "x", 2);
  }
}

// Keeps every core busy while it exists.
class OtherWork {
 public:
  OtherWork() {
    for (unsigned i = std::max(std::thread::hardware_concurrency(), 1u); i > 0; --i)
      threads_.emplace_back([this] {
        while (!over_.load(std::memory_order_relaxed)) {
        }
      });
  }
  ~OtherWork() {
    over_ = true;
    for (auto& thread : threads_) thread.join();
  }
  OtherWork(const OtherWork&) = delete;
  OtherWork& operator=(const OtherWork&) = delete;

 private:
  std::atomic<bool> over_{false};
  std::vector<std::thread> threads_;
};

// A thread that yields its core while it waits gets it back one time slice later.
void measure_mux_beside_others(int rounds) {
  constexpr int kPads = 4, kFrames = 500;
  InputsStage stage("tensor_mux sync-mode=nosync",
                    std::vector<InputLine>(kPads, {"sink_%u", tensor("1024"), make_buffer(1024)}));
  const OtherWork others;
  const auto costs =
      weir::bench::medians({[] { meet(kPads, kFrames); }, [&] { stage.push(kFrames); }}, rounds);
  const auto floor = static_cast<int>(costs[0].wall / kFrames * 1e6);
  weir::bench::report("tensor_mux of 4 pads, other work on every core: wall of a frame out",
                      "threads that only meet, " + std::to_string(floor) + " us",
                      costs[1].wall / costs[0].wall, "x", 2);
}

// A plain loop that alternates blocks of both inputs.
template <size_t kBlock>
void strided(const char* a, const char* b, char* out, size_t block, size_t rows) {
  const size_t size = kBlock ? kBlock : block;
  for (size_t i = 0; i < rows; ++i) std::memcpy(out + 2 * i * size, a + i * size, size);
  for (size_t i = 0; i < rows; ++i) std::memcpy(out + (2 * i + 1) * size, b + i * size, size);
}

void measure_merge(int rounds) {
  const size_t blocks[] = {3, 3 * kWidth, kPicture, kPicture};
  const auto a = make_buffer(kPicture), b = make_buffer(kPicture), out = make_buffer(2 * kPicture);
  for (size_t dimension = 0; dimension < 4; ++dimension) {
    InputsStage stage(
        "tensor_merge mode=linear option=" + std::to_string(dimension),
        {{"sink_%u", tensor("3:1920:1080:1"), a}, {"sink_%u", tensor("3:1920:1080:1"), b}});
    const auto bare = [&] {
      GstMapInfo in_a, in_b, to;
      gst_buffer_map(a.get(), &in_a, GST_MAP_READ);
      gst_buffer_map(b.get(), &in_b, GST_MAP_READ);
      gst_buffer_map(out.get(), &to, GST_MAP_WRITE);
      const auto* from_a = reinterpret_cast<const char*>(in_a.data);
      const auto* from_b = reinterpret_cast<const char*>(in_b.data);
      const size_t rows = kPicture / blocks[dimension];
      auto* f = dimension == 0 ? strided<3> : strided<0>;
      for (int i = 0; i < kPictures; ++i)
        f(from_a, from_b, reinterpret_cast<char*>(to.data), blocks[dimension], rows);
      gst_buffer_unmap(a.get(), &in_a);
      gst_buffer_unmap(b.get(), &in_b);
      gst_buffer_unmap(out.get(), &to);
    };
    const auto costs = weir::bench::min({bare, [&] { stage.push(kPictures); }}, rounds);
    const auto floor = static_cast<int>(costs[0].cpu / kPictures * 1e6);
    weir::bench::report(
        "tensor_merge of two Full HD along dimension " + std::to_string(dimension) + ": CPU",
        "a strided copy, " + std::to_string(floor) + " us", costs[1].cpu / costs[0].cpu, "x", 1.2);
  }
}

constexpr uint32_t kSide = 128;
std::vector<uint32_t> make_regions(uint32_t count) {
  std::vector<uint32_t> numbers;
  for (uint32_t i = 0; i < count; ++i)
    numbers.insert(numbers.end(), {i * 28, i * 14, kSide, kSide});
  return numbers;
}
std::vector<InputLine> crop_inputs(const Ref<GstBuffer>& picture,
                                   const std::vector<uint32_t>& numbers) {
  weir::TensorHeader header;
  header.spec = {weir::ElementType::UInt32,
                 weir::Shape{4, static_cast<uint32_t>(numbers.size() / 4)}, ""};
  header.format = weir::Format::Flexible;
  std::vector<std::byte> bytes(weir::kTensorHeaderBytes + numbers.size() * 4);
  weir::write_tensor_header(header, std::span(bytes).first<weir::kTensorHeaderBytes>());
  std::memcpy(bytes.data() + weir::kTensorHeaderBytes, numbers.data(), numbers.size() * 4);
  const auto info = Ref<GstBuffer>::adopt(gst_buffer_new_memdup(bytes.data(), bytes.size()));
  return {{"raw", tensor("3:1920:1080:1"), picture},
          {"info", "other/tensors,format=flexible,framerate=30/1", info}};
}

void measure_crop(int rounds) {
  const auto picture = make_buffer(kPicture);
  const auto numbers = make_regions(64);
  InputsStage stage("tensor_crop", crop_inputs(picture, numbers));
  std::vector<char> out(numbers.size() / 4 * kSide * kSide * 3);
  constexpr int kFrames = 50;
  const auto bare = [&] {
    GstMapInfo map;
    gst_buffer_map(picture.get(), &map, GST_MAP_READ);
    for (int frame = 0; frame < kFrames; ++frame) {
      char* to = out.data();
      for (size_t r = 0; r < numbers.size(); r += 4)
        for (size_t y = 0; y < kSide; ++y, to += kSide * 3)
          std::memcpy(to, map.data + ((numbers[r + 1] + y) * kWidth + numbers[r]) * 3, kSide * 3);
    }
    gst_buffer_unmap(picture.get(), &map);
  };
  const auto costs = weir::bench::min({bare, [&] { stage.push(kFrames); }}, rounds);
  const auto floor = static_cast<int>(costs[0].cpu / kFrames * 1e6);
  weir::bench::report("tensor_crop of 64 regions of 128x128 from Full HD: CPU",
                      "the bare copies, " + std::to_string(floor) + " us",
                      costs[1].cpu / costs[0].cpu, "x", 2);
}

// An identity in between prevents the regions from being views.
void measure_views(uint32_t regions, int rounds) {
  const auto inputs = crop_inputs(make_buffer(kPicture), make_regions(regions));
  const std::string clamp = "tensor_transform mode=clamp option=10:200";
  InputsStage copied("tensor_crop", inputs, {"identity", clamp}),
      viewed("tensor_crop", inputs, {clamp});
  constexpr int kFrames = 50;
  const auto costs =
      weir::bench::min({[&] { copied.push(kFrames); }, [&] { viewed.push(kFrames); }}, rounds);
  const auto floor = static_cast<int>(costs[0].cpu / kFrames * 1e6);
  weir::bench::report(
      "tensor_crop of " + std::to_string(regions) + " regions of 128x128 as views, and clamp: CPU",
      "the same with copies, " + std::to_string(floor) + " us", costs[1].cpu / costs[0].cpu, "x",
      1);
}

}  // namespace

int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 15;
  measure_mux(rounds);
  measure_mux_beside_others(rounds);
  measure_merge(rounds);
  measure_crop(rounds);
  for (const uint32_t regions : {16, 64}) measure_views(regions, rounds);
}
