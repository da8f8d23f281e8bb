// The convolutional network of event frames, as a filter of a pipeline: a window of 8 frames of
// 64x48 numbers in, the probability of each activity out.
//
//   tensor_filter framework=custom model=libars-event-network.so custom=weights:event_network.f32
//
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <array>

#include "weights.hpp"

namespace {

constexpr size_t kFrames = 8, kHeight = 48, kWidth = 64;

// A 3x3 convolution with a border of zeros, then ReLU. Maps are [height, width, channels].
template <size_t Height, size_t Width, size_t Inputs, size_t Outputs, size_t Stride>
class Convolution {
 public:
  static constexpr size_t kWeights = 9 * Inputs * Outputs, kNumbers = kWeights + Outputs;
  static constexpr size_t kOutHeight = Height / Stride, kOutWidth = Width / Stride;

  explicit Convolution(ars::Parts& parts)
      : weights_(parts.next(kWeights)), bias_(parts.next(Outputs)) {}

  void run(const float* in, float* out) const {
    for (size_t y = 0; y < kOutHeight; ++y)
      for (size_t x = 0; x < kOutWidth; ++x, out += Outputs) pixel(in, y * Stride, x * Stride, out);
  }

 private:
  // Computes all channels of the output whose 3x3 inputs are centred at `y`, `x`.
  void pixel(const float* in, size_t y, size_t x, float* out) const {
    std::array<float, Outputs> sums;
    std::copy_n(bias_.data(), Outputs, sums.data());
    for (size_t ky = y == 0; ky < 3 && y + ky <= Height; ++ky)
      for (size_t kx = x == 0; kx < 3 && x + kx <= Width; ++kx) {
        const float* from = in + ((y + ky - 1) * Width + x + kx - 1) * Inputs;
        const float* weights = weights_.data() + (ky * 3 + kx) * Inputs * Outputs;
        for (size_t i = 0; i < Inputs; ++i, weights += Outputs)
          for (size_t o = 0; o < Outputs; ++o) sums[o] += from[i] * weights[o];
      }
    for (size_t o = 0; o < Outputs; ++o) out[o] = std::max(sums[o], 0.0F);
  }

  std::span<const float> weights_, bias_;
};

class EventNetwork {
 public:
  static constexpr uint64_t kFlags = WEIR_ENGINE_NEEDS_NO_MODEL;
  static constexpr const char* kOptions = ars::kWeightsOption;

  explicit EventNetwork(const weir::OpenRequest& request)
      : numbers_(ars::read_weights(request.options, kNumbers)) {}
  EventNetwork(const EventNetwork&) = delete;
  EventNetwork& operator=(const EventNetwork&) = delete;

  std::span<const weir_tensor_info> inputs() const { return {&window_, 1}; }
  std::span<const weir_tensor_info> outputs() const { return {&probabilities_, 1}; }

  bool invoke(std::span<const weir_tensor> in, std::span<weir_tensor> out) {
    const auto window = weir::elements<const float>(in[0]);
    float *from = maps_[0].data(), *to = maps_[1].data();
    for (size_t frame = 0; frame < kFrames; ++frame)  // [frames, height, width] to channels last
      for (size_t i = 0; i < kHeight * kWidth; ++i)
        from[i * kFrames + frame] = window[frame * kHeight * kWidth + i];
    first_.run(from, to);
    second_.run(to, from);
    third_.run(from, to);
    fourth_.run(to, from);
    pool(from);
    ars::classify(features_, classifier_, bias_, weir::elements<float>(out[0]));
    return true;
  }

 private:
  static constexpr std::array<size_t, 4> kChannels{32, 64, 96, 96};  // of the outputs
  using First = Convolution<kHeight, kWidth, kFrames, kChannels[0], 2>;
  using Second = Convolution<24, 32, kChannels[0], kChannels[1], 2>;
  using Third = Convolution<12, 16, kChannels[1], kChannels[2], 1>;
  using Fourth = Convolution<12, 16, kChannels[2], kChannels[3], 2>;
  static constexpr size_t kLast = kChannels[3], kPixels = Fourth::kOutHeight * Fourth::kOutWidth;
  static constexpr size_t kFeatures = 2 * kLast;  // mean and maximum of each channel
  static constexpr size_t kNumbers = First::kNumbers + Second::kNumbers + Third::kNumbers +
                                     Fourth::kNumbers + (kFeatures + 1) * ars::kActivities;

  void pool(const float* map) {
    features_.fill(0);
    for (size_t i = 0; i < kPixels; ++i)
      for (size_t c = 0; c < kLast; ++c) {
        features_[c] += map[i * kLast + c] / kPixels;
        features_[kLast + c] = std::max(features_[kLast + c], map[i * kLast + c]);
      }
  }

  std::vector<float> numbers_;
  ars::Parts parts_{numbers_};
  First first_{parts_};
  Second second_{parts_};
  Third third_{parts_};
  Fourth fourth_{parts_};
  std::span<const float> classifier_ = parts_.next(kFeatures * ars::kActivities);
  std::span<const float> bias_ = parts_.next(ars::kActivities);
  // Two maps in turn; the largest is the network's input.
  std::array<std::array<float, kFrames * kHeight * kWidth>, 2> maps_;
  std::array<float, kFeatures> features_;
  weir_tensor_info window_ = weir::tensor_info("windows", WEIR_FLOAT32, {kFrames, kHeight, kWidth});
  weir_tensor_info probabilities_ =
      weir::tensor_info("probabilities", WEIR_FLOAT32, {1, ars::kActivities});
};

}  // namespace

WEIR_ENGINE(EventNetwork, "ars-event-network", "1", "", "")
