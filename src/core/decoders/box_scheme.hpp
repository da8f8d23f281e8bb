// BoxScheme: how the mode bounding_boxes reads the tensors of one family of detectors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/detection/pixel_box.hpp"
#include "core/tensor/geometry.hpp"
#include "weir/module.hpp"

namespace weir::decoders {

// What the options say that concerns schemes.
struct SchemeOptions {
  std::string name;              // as in option1
  std::string parameters;        // option3
  std::optional<size_t> labels;  // lines of the label file; nullopt without one
  Size input;
  const char* selected_by = "option1";  // the property whose value is `name`

  // Names the scheme in errors: "option1=yolov5".
  std::string setting() const { return std::string(selected_by) + "=" + name; }
};

// Used by one thread at a time.
class BoxScheme {
 public:
  virtual ~BoxScheme() = default;
  // Throws Failure (SPEC_MISMATCH) for tensors that are not this head's.
  virtual void check(std::span<const weir_tensor_info* const> tensors) = 0;
  // Returns the boxes in the order in which they are drawn. Precondition: check() accepted the
  // descriptions of these tensors.
  virtual detection::PixelBoxes find(std::span<const weir_tensor> tensors) = 0;
  // Boxes with an angle are drawn as rotated rectangles without labels.
  virtual bool is_rotated() const noexcept { return false; }
};

// Throws Failure (OPTION_VALUE, with the nearest name) unless there is a scheme of this name.
void check_scheme(const std::string& name);
// Opens the scheme; throws Failure for an unknown name and for parameters that it cannot use.
std::unique_ptr<BoxScheme> open_scheme(const SchemeOptions& options);

// The schemes, by name.
std::unique_ptr<BoxScheme> open_yolov5(const SchemeOptions& options);
std::unique_ptr<BoxScheme> open_yolov8(const SchemeOptions& options);
std::unique_ptr<BoxScheme> open_yolov8_obb(const SchemeOptions& options);
std::unique_ptr<BoxScheme> open_yolov10(const SchemeOptions& options);
std::unique_ptr<BoxScheme> open_mobilenet_ssd(const SchemeOptions& options);
// Takes the first class of each anchor that reaches the threshold, not the best one.
std::unique_ptr<BoxScheme> open_mobilenet_ssd_of_first_class(const SchemeOptions& options);
std::unique_ptr<BoxScheme> open_mobilenet_ssd_postprocess(const SchemeOptions& options);
std::unique_ptr<BoxScheme> open_openvino(const SchemeOptions& options);
std::unique_ptr<BoxScheme> open_palm(const SchemeOptions& options);

}  // namespace weir::decoders
