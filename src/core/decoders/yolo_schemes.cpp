// Reads the options and tensors of YOLO models.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/decoders/box_scheme.hpp"

#include "core/decoders/scheme_checks.hpp"
#include "core/decoders/tensor_values.hpp"
#include "core/detection/box_layouts.hpp"
#include "core/detection/pixel_box.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::decoders {
namespace {

constexpr float kUsualThreshold = 0.25f;

void check_float32(const SchemeOptions& options, std::span<const weir_tensor_info* const> tensors,
                   const std::string& needed) {
  // Quantised outputs are read as the real numbers that they stand for.
  if (tensors[0]->type != WEIR_FLOAT32 && tensors[0]->scale == 0)
    throw wrong_tensors(options, tensors, needed, "tensor_transform mode=typecast option=float32");
}

// What differs between the versions whose rows have one score for each class.
struct Version {
  int64_t fixed;   // values of a row besides the scores
  size_t anchors;  // of each cell
  bool is_oriented;
  detection::Candidates (*decode)(std::span<const float> rows, size_t classes, float threshold,
                                  detection::YoloUnit unit, Size picture);
};
constexpr Version kV5{5, 3, false, detection::decode_yolov5};
constexpr Version kV8{4, 1, false, detection::decode_yolov8};
constexpr Version kV8Obb{5, 1, true, detection::decode_yolov8_obb};

class Yolo final : public BoxScheme {
 public:
  Yolo(const SchemeOptions& options, const Version& version)
      : options_(options), version_(version) {
    const auto parts =
        split_parameters(options_, 3, "IN_PIXELS[:THRESHOLD[:IOU_THRESHOLD]], such as 0:0.25:0.45");
    if (read_number(options_, parts[0], "unit", 0) != 0) unit_ = detection::YoloUnit::Pixels;
    threshold_ = read_number(options_, parts[1], "threshold", kUsualThreshold);
    max_overlap_ = read_number(options_, parts[2], "threshold of the overlap", 0.45f);
  }

  void check(std::span<const weir_tensor_info* const> tensors) override {
    const auto rows = static_cast<int64_t>(detection::yolo_rows(options_.input, version_.anchors));
    const std::string needed = "1 tensor float32 " + std::to_string(version_.fixed) +
                               "+CLASSES:" + std::to_string(rows) + " for the input size " +
                               std::to_string(options_.input.width) + ":" +
                               std::to_string(options_.input.height) + " of option5";
    check_count_and_type(options_, tensors, 1, needed);
    const int64_t length = dimension(*tensors[0], 0);
    const bool is_transposed = length == rows && dimension(*tensors[0], 1) > version_.fixed;
    if (length <= version_.fixed || rows == 0 || !has_dimensions(*tensors[0], {length, rows}))
      throw wrong_tensors(options_, tensors, needed,
                          is_transposed ? "tensor_transform mode=transpose option=1:0:2:3" : "");
    if (!version_.is_oriented) check_float32(options_, tensors, needed);
    check_labels(options_, length - version_.fixed, LabelCount::Equal, *tensors[0]);
  }

  detection::PixelBoxes find(std::span<const weir_tensor> tensors) override {
    using detection::Limits;
    const auto found = version_.decode(rows_.read(tensors[0]), options_.labels.value_or(0),
                                       threshold_, unit_, options_.input);
    auto boxes = detection::to_pixels(
        found, version_.is_oriented ? Limits::Corner : Limits::CornerAndSize, options_.input);
    return version_.is_oriented ? detection::suppress_rotated(std::move(boxes), max_overlap_)
                                : detection::suppress(std::move(boxes), max_overlap_);
  }

  bool is_rotated() const noexcept override { return version_.is_oriented; }

 private:
  SchemeOptions options_;
  const Version& version_;
  detection::YoloUnit unit_ = detection::YoloUnit::Picture;
  float threshold_, max_overlap_;
  TensorValues rows_;
};

class Yolov10 final : public BoxScheme {
 public:
  explicit Yolov10(const SchemeOptions& options) : options_(options) {
    const auto parts = split_parameters(options_, 2, "0:THRESHOLD, such as 0:0.25");
    threshold_ = read_number(options_, parts[1], "threshold", kUsualThreshold);
  }

  void check(std::span<const weir_tensor_info* const> tensors) override {
    const std::string needed = "1 tensor float32 6:N";
    check_count_and_type(options_, tensors, 1, needed);
    const int64_t rows = dimension(*tensors[0], 1);
    if (rows <= 0 || !has_dimensions(*tensors[0], {int64_t{detection::kYolov10Row}, rows}))
      throw wrong_tensors(options_, tensors, needed);
    check_float32(options_, tensors, needed);
  }

  detection::PixelBoxes find(std::span<const weir_tensor> tensors) override {
    return detection::to_pixels(
        detection::decode_yolov10(rows_.read(tensors[0]), threshold_, options_.input),
        detection::Limits::None, options_.input);
  }

 private:
  SchemeOptions options_;
  float threshold_;
  TensorValues rows_;
};

}  // namespace

std::unique_ptr<BoxScheme> open_yolov5(const SchemeOptions& options) {
  return std::make_unique<Yolo>(options, kV5);
}
std::unique_ptr<BoxScheme> open_yolov8(const SchemeOptions& options) {
  return std::make_unique<Yolo>(options, kV8);
}
std::unique_ptr<BoxScheme> open_yolov8_obb(const SchemeOptions& options) {
  return std::make_unique<Yolo>(options, kV8Obb);
}
std::unique_ptr<BoxScheme> open_yolov10(const SchemeOptions& options) {
  return std::make_unique<Yolov10>(options);
}

}  // namespace weir::decoders
