// Reads the inputs that the files of a Caffe, TensorFlow or Darknet network declare, and checks
// that the files are complete, before OpenCV opens them.
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
  // Outermost-first in the format's own order, so TensorFlow's pictures are NHWC; -1 = open. An
  // undeclared type is float32.
  std::vector<DeclaredTensor> inputs;
  std::set<std::string> nodes;                // names of all layers, if the format has names
  std::set<std::string> operators;            // types of all layers
  std::set<std::string> pictures;             // TensorFlow: nodes whose result is NHWC
  std::map<std::string, std::string> passed;  // TensorFlow: nodes that OpenCV merges into others
  bool nhwc = false;                          // TensorFlow: convolutions read NHWC
};

// Parses a .prototxt: text fields of caffe.proto.
Result<DnnDescription> describe_caffe(std::string_view prototxt);
// Checks a .caffemodel: a sequence of fields in which every blob has as many values as its shape.
Status check_caffe_weights(std::span<const std::byte> caffemodel);
// Parses a frozen GraphDef. Field numbers: graph.proto, node_def.proto, attr_value.proto,
// tensor.proto.
Result<DnnDescription> describe_tensorflow(std::span<const std::byte> graph);
// Parses a .cfg: sections in brackets, key=value.
Result<DnnDescription> describe_darknet(std::string_view cfg);

}  // namespace weir::engine
