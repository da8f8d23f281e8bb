// DnnNet: a network that OpenCV has read. Including this needs no OpenCV header.
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
  std::string name;                             // for error messages
  std::vector<std::byte> description, weights;  // TensorFlow's graph is `weights`
};

// One input of a run. NHWC is permuted to NCHW and types other than float32 are converted.
struct DnnInput {
  std::string name;  // "" for the only input
  const void* data = nullptr;
  weir_tensor_info info{};
  bool nhwc = false;
};

// One output of a run. The net owns the memory, valid until the next run.
struct DnnOutput {
  weir_tensor_info info{};
  const void* data = nullptr;
};

// One thread at a time.
class DnnNet {
 public:
  // `threads` sets OpenCV's thread count for the whole process, including other users of OpenCV.
  // MODEL_INVALID, or MODEL_UNSUPPORTED with the layer and operator that OpenCV lacks.
  static Result<std::unique_ptr<DnnNet>> read(const DnnFiles& files, int threads);
  ~DnnNet();
  DnnNet(const DnnNet&) = delete;
  DnnNet& operator=(const DnnNet&) = delete;

  std::vector<std::string> layers() const;
  std::vector<std::string> ends() const;  // layers whose output no other layer reads
  // `pictures`: whether to permute output i to NHWC. `threads`: as for read(), 0 = as it is set;
  // networks of another count wait. INVOKE_FAILED names the layer if it is known.
  Result<std::vector<DnnOutput>> run(std::span<const DnnInput> inputs,
                                     std::span<const std::string> outputs,
                                     std::span<const bool> pictures, int threads);

  static int threads();          // of the process, as it is set
  static std::string version();  // of the loaded library
  static std::string path();

 private:
  struct Parts;
  explicit DnnNet(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace weir::engine
