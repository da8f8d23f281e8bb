// The LSTM (long short-term memory) of the event network's results, as a filter of a pipeline: a
// window of 12 results in, the probability of each activity out.
//
//   tensor_filter framework=custom model=libars-sequence-network.so
//                 custom=weights:sequence_network.f32
//
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <array>

#include "weights.hpp"

namespace {

constexpr size_t kResults = 12, kHidden = 128, kGates = 4 * kHidden;

float sigmoid(float value) {
  return 1 / (1 + std::exp(-value));
}

class SequenceNetwork {
 public:
  static constexpr uint64_t kFlags = WEIR_ENGINE_NEEDS_NO_MODEL;
  static constexpr const char* kOptions = ars::kWeightsOption;

  explicit SequenceNetwork(const weir::OpenRequest& request)
      : numbers_(ars::read_weights(request.options, kNumbers)) {}
  SequenceNetwork(const SequenceNetwork&) = delete;
  SequenceNetwork& operator=(const SequenceNetwork&) = delete;

  std::span<const weir_tensor_info> inputs() const { return {&window_, 1}; }
  std::span<const weir_tensor_info> outputs() const { return {&probabilities_, 1}; }

  // Each window starts with an empty memory: windows overlap, so nothing is kept between them.
  bool invoke(std::span<const weir_tensor> in, std::span<weir_tensor> out) {
    const auto window = weir::elements<const float>(in[0]);
    cell_.fill(0);
    state_.fill(0);
    for (size_t step = 0; step < kResults; ++step) {
      std::copy_n(&window[step * ars::kActivities], ars::kActivities, state_.begin());
      update();
    }
    ars::classify(std::span(state_).subspan(ars::kActivities), classifier_, classifier_bias_,
                  weir::elements<float>(out[0]));
    return true;
  }

 private:
  static constexpr size_t kInputs = ars::kActivities + kHidden;  // the result, the hidden state
  static constexpr size_t kNumbers = (kInputs + 1) * kGates + (kHidden + 1) * ars::kActivities;

  // One time step: gates are in, forget, cell, out.
  void update() {
    std::copy(bias_.begin(), bias_.end(), gates_.begin());
    for (size_t i = 0; i < kInputs; ++i)
      for (size_t g = 0; g < kGates; ++g) gates_[g] += state_[i] * weights_[i * kGates + g];
    for (size_t h = 0; h < kHidden; ++h) {
      cell_[h] = sigmoid(gates_[kHidden + h]) * cell_[h] +
                 sigmoid(gates_[h]) * std::tanh(gates_[2 * kHidden + h]);
      state_[ars::kActivities + h] = sigmoid(gates_[3 * kHidden + h]) * std::tanh(cell_[h]);
    }
  }

  std::vector<float> numbers_;
  ars::Parts parts_{numbers_};
  std::span<const float> weights_ = parts_.next(kInputs * kGates), bias_ = parts_.next(kGates);
  std::span<const float> classifier_ = parts_.next(kHidden * ars::kActivities);
  std::span<const float> classifier_bias_ = parts_.next(ars::kActivities);
  std::array<float, kInputs> state_;
  std::array<float, kHidden> cell_;
  std::array<float, kGates> gates_;
  weir_tensor_info window_ =
      weir::tensor_info("results", WEIR_FLOAT32, {kResults, ars::kActivities});
  weir_tensor_info probabilities_ =
      weir::tensor_info("probabilities", WEIR_FLOAT32, {1, ars::kActivities});
};

}  // namespace

WEIR_ENGINE(SequenceNetwork, "ars-sequence-network", "1", "", "")
