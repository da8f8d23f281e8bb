// Reads the records of OpenVINO's detectors. Boxes have no class, so that a label file hides them
// (docs/compatibility/decoder.md 5.3).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/decoders/openvino_scheme.hpp"

#include "core/decoders/scheme_checks.hpp"
#include "core/decoders/tensor_values.hpp"
#include "core/detection/openvino_records.hpp"

namespace weir::decoders {
namespace {

class Openvino final : public BoxScheme {
 public:
  explicit Openvino(const SchemeOptions& options) : options_(options) {}

  void check(std::span<const weir_tensor_info* const> tensors) override {
    const std::string needed = "1 tensor 7:" + std::to_string(kRecords);
    check_count_and_type(options_, tensors, 1, needed);
    if (!has_dimensions(*tensors[0], {int64_t{detection::kOpenvinoRecord}, kRecords}))
      throw wrong_tensors(options_, tensors, needed);
  }

  detection::PixelBoxes find(std::span<const weir_tensor> tensors) override {
    constexpr float kThreshold = 0.8f;
    auto boxes = detection::to_pixels(
        detection::decode_openvino(records_.read(tensors[0]), kThreshold, options_.input),
        detection::Limits::None, options_.input);
    for (auto& box : boxes) box.class_index = -1, box.probability = 1;
    return boxes;
  }

 private:
  static constexpr int64_t kRecords = 200;

  SchemeOptions options_;
  TensorValues records_;
};

}  // namespace

std::unique_ptr<BoxScheme> open_openvino(const SchemeOptions& options) {
  return std::make_unique<Openvino>(options);
}

}  // namespace weir::decoders
