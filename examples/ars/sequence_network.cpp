// The LSTM (long short-term memory) of two layers of the event network's results, as a filter of a
// pipeline: a window of 12 results in, the probability of each activity out.
//
//   tensor_filter framework=custom model=libars-sequence-network.so
//                 custom=weights:sequence_network.f16
//
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <array>

#include "weights.hpp"

namespace {

constexpr size_t kResults = 12, kHidden = 256;

float sigmoid(float value) {
  return 1 / (1 + std::exp(-value));
}

// One of the LSTM's layers, with its hidden state and its memory, the cell.
template <size_t Inputs>
class Layer {
 public:
  static constexpr size_t kGates = 4 * kHidden, kWeights = (Inputs + kHidden) * kGates;
  static constexpr size_t kNumbers = kWeights + kGates;

  explicit Layer(ars::Parts& parts) : weights_(parts.next(kWeights)), bias_(parts.next(kGates)) {}

  void reset() {
    hidden_.fill(0);
    cell_.fill(0);
  }
  // Computes a time step; returns the hidden state. Gates are in, forget, cell, out.
  std::span<const float> step(std::span<const float> in) {
    std::copy(bias_.begin(), bias_.end(), gates_.begin());
    add(in, weights_.data());
    add(hidden_, weights_.data() + Inputs * kGates);
    for (size_t h = 0; h < kHidden; ++h) {
      cell_[h] = sigmoid(gates_[kHidden + h]) * cell_[h] +
                 sigmoid(gates_[h]) * std::tanh(gates_[2 * kHidden + h]);
      hidden_[h] = sigmoid(gates_[3 * kHidden + h]) * std::tanh(cell_[h]);
    }
    return hidden_;
  }

 private:
  void add(std::span<const float> values, const float* weights) {
    for (const float value : values) {
      for (size_t g = 0; g < kGates; ++g) gates_[g] += value * weights[g];
      weights += kGates;
    }
  }

  std::span<const float> weights_, bias_;
  std::array<float, kHidden> hidden_{}, cell_{};
  std::array<float, kGates> gates_{};
};

class SequenceNetwork {
 public:
  static constexpr uint64_t kFlags = WEIR_ENGINE_NEEDS_NO_MODEL;
  static constexpr const char* kOptions = ars::kWeightsOption;

  explicit SequenceNetwork(const weir::OpenRequest& request)
      : numbers_(ars::read_weights<ars::Half>(request.options, kNumbers)) {}
  SequenceNetwork(const SequenceNetwork&) = delete;
  SequenceNetwork& operator=(const SequenceNetwork&) = delete;

  std::span<const weir_tensor_info> inputs() const { return {&window_, 1}; }
  std::span<const weir_tensor_info> outputs() const { return {&probabilities_, 1}; }

  // Each window starts with an empty memory: windows overlap, so nothing is kept between them.
  bool invoke(std::span<const weir_tensor> in, std::span<weir_tensor> out) {
    const auto window = weir::elements<const float>(in[0]);
    first_.reset();
    second_.reset();
    std::span<const float> hidden;
    for (size_t step = 0; step < kResults; ++step)
      hidden = second_.step(first_.step(window.subspan(step * ars::kActivities, ars::kActivities)));
    ars::classify(hidden, classifier_, classifier_bias_, weir::elements<float>(out[0]));
    return true;
  }

 private:
  using First = Layer<ars::kActivities>;
  using Second = Layer<kHidden>;
  static constexpr size_t kNumbers =
      First::kNumbers + Second::kNumbers + (kHidden + 1) * ars::kActivities;

  std::vector<float> numbers_;
  ars::Parts parts_{numbers_};
  First first_{parts_};
  Second second_{parts_};
  std::span<const float> classifier_ = parts_.next(kHidden * ars::kActivities);
  std::span<const float> classifier_bias_ = parts_.next(ars::kActivities);
  weir_tensor_info window_ =
      weir::tensor_info("results", WEIR_FLOAT32, {kResults, ars::kActivities});
  weir_tensor_info probabilities_ =
      weir::tensor_info("probabilities", WEIR_FLOAT32, {1, ars::kActivities});
};

}  // namespace

WEIR_ENGINE(SequenceNetwork, "ars-sequence-network", "1", "", "")
