// What the files of a Caffe, TensorFlow or Darknet network say of its inputs, read before OpenCV
// reads them; and whether they are whole.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "declared_tensors.hpp"
#include "weir/result.hpp"

namespace weir::engine {

enum class DnnFormat { Caffe, Tensorflow, Darknet };

struct DnnDescription {
  // Outermost-first as the format has them, so TensorFlow's pictures are NHWC; -1 = open. A type
  // that is not said is float32.
  std::vector<DeclaredTensor> inputs;
  std::set<std::string> nodes;      // names of all layers, where the format has such
  std::set<std::string> operators;  // types of all layers
  std::set<std::string> pictures;   // of TensorFlow: nodes whose result is NHWC
  std::map<std::string, std::string>
      passed;         // of TensorFlow: nodes that OpenCV makes part of another
  bool nhwc = false;  // of TensorFlow: convolutions read NHWC
};

// A .prototxt: fields of caffe.proto by their names.
Result<DnnDescription> describe_caffe(std::string_view prototxt);
// A .caffemodel is a sequence of fields, and every blob has the number of values that its shape
// says.
Status check_caffe_weights(std::span<const std::byte> caffemodel);
// A frozen GraphDef. Field numbers: graph.proto, node_def.proto, attr_value.proto, tensor.proto.
Result<DnnDescription> describe_tensorflow(std::span<const std::byte> graph);
// A .cfg: sections in brackets, key=value.
Result<DnnDescription> describe_darknet(std::string_view cfg);

}  // namespace weir::engine
