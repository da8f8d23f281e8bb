// DnnNet: a network read by OpenCV. No header of OpenCV is needed here.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "opencv-dnn/dnn_description.hpp"
#include "weir/abi.h"

namespace weir::engine {

struct DnnFiles {
  DnnFormat format = DnnFormat::Caffe;
  std::string name;                             // for messages
  std::vector<std::byte> description, weights;  // TensorFlow's graph is `weights`
};

// What one run reads. NHWC is turned into what OpenCV computes with; other types than float32 are
// converted.
struct DnnInput {
  std::string name;  // "" = the only one
  const void* data = nullptr;
  weir_tensor_info info{};
  bool nhwc = false;
};

// What one run made; the memory is the net's, until its next run.
struct DnnOutput {
  weir_tensor_info info{};
  const void* data = nullptr;
};

// Used by one thread at a time.
class DnnNet {
 public:
  // MODEL_INVALID, or MODEL_UNSUPPORTED with the layer and its operator that OpenCV lacks.
  static Result<std::unique_ptr<DnnNet>> read(const DnnFiles& files);
  ~DnnNet();
  DnnNet(const DnnNet&) = delete;
  DnnNet& operator=(const DnnNet&) = delete;

  std::vector<std::string> layers() const;
  std::vector<std::string> ends() const;  // layers that no other reads
  // `pictures`: whether output i is to be turned into NHWC. `threads` is OpenCV's number of threads
  // in this process, whoever else uses OpenCV. INVOKE_FAILED names the layer where that is found.
  Result<std::vector<DnnOutput>> run(std::span<const DnnInput> inputs,
                                     std::span<const std::string> outputs,
                                     std::span<const bool> pictures, int threads);

  static std::string version();  // of the library that runs
  static std::string path();

 private:
  struct Parts;
  explicit DnnNet(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace weir::engine
