// OnnxSummary: the description of an ONNX file, read without ONNX Runtime.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>

#include "weir/result.hpp"

namespace weir::engine {

struct OnnxSummary {
  int64_t ir_version = 0;
  std::string producer, producer_version;
  std::map<std::string, int64_t> opsets;  // domain ("ai.onnx" for the default) -> version
  std::set<std::string> operators;        // of the graph, its subgraphs and its functions
  std::set<std::string> shapeless;        // inputs and outputs without a rank in the file
  uint64_t weight_bytes = 0;              // of the initialisers in the file
  uint64_t constant_bytes = 0;            // of tensors in the attributes of nodes
  // Elements of the largest input, a batch of unknown size taken as one; empty if another axis is
  // unknown.
  std::optional<uint64_t> largest_input = 0;
  bool may_need_other_files = false;  // tensors may have their data in files next to it

  // Whether an operator's output shape depends on the values of a frame, not only on shapes.
  bool shapes_depend_on_data() const;

  // Whether waking a second thread at each operator takes longer than it saves: whether the bytes
  // of all weights times the elements of the input, an estimate from above, are below 4e9. R-Net of
  // MTCNN (0.7e9) takes 1.3 times as long with two threads as with one, MobileNet v2 (2000e9) 0.7
  // times. False if sizes are unknown.
  bool is_small() const;
};

// Returns 0 to 100: the confidence that a file with these first bytes is for ONNX Runtime.
int onnx_score(std::span<const unsigned char> head) noexcept;

// Checks the first bytes of a file: MODEL_INVALID when the rest need not be read.
Status check_onnx_head(std::span<const std::byte> head);

// Parses the whole file except weights. MODEL_INVALID, with the place, when it is truncated or its
// structure is damaged. Field numbers: onnx.proto3 of the ONNX project.
Result<OnnxSummary> read_onnx(std::span<const std::byte> file);

}  // namespace weir::engine
