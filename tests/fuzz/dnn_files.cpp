// Fuzz target: parses network files as the OpenCV modules do before OpenCV reads them. The first
// byte selects .prototxt, .caffemodel, .pb or .cfg.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdint>
#include <span>

#include "opencv-dnn/dnn_description.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const auto file = std::as_bytes(std::span(data + 1, size - 1));
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  switch (data[0] % 4) {
    case 0:
      (void)weir::engine::describe_caffe(text);
      break;
    case 1:
      (void)weir::engine::check_caffe_weights(file);
      break;
    case 2:
      (void)weir::engine::describe_tensorflow(file);
      break;
    default:
      (void)weir::engine::describe_darknet(text);
  }
  return 0;
}
