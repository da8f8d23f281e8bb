// OipSignature: the tensors of a model on a server, as the server or the user describes them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "declared_tensors.hpp"
#include "net/protocol/oip_messages.hpp"

namespace weir::engine {

struct OipTensor {
  std::string name, datatype;  // as the server has them
  std::vector<int64_t> shape;  // of the stream's tensor; -1 = any
  uint32_t type = WEIR_TYPE_END;
  size_t bytes_rank = 0;  // of a BYTES tensor on the server

  bool operator==(const OipTensor&) const = default;
  bool is_bytes() const noexcept { return datatype == "BYTES"; }
  weir_tensor_info info() const;  // borrows the name
  std::string to_string() const;  // "input FP32 [-1,3]"
};

struct OipSignature {
  std::vector<OipTensor> inputs, outputs;

  bool operator==(const OipSignature&) const = default;
  std::string to_string() const;
  // Whether both have as many tensors, of the same types, and shapes that can be equal. Names are
  // not compared: declared tensors may have none.
  bool is_compatible(const OipSignature& other) const;
  // MODEL_UNSUPPORTED for types and ranks that streams do not have.
  static Result<OipSignature> from(const net::ModelMetadata& metadata);
  // Empty lists unless type and shape of every tensor are declared.
  static OipSignature from(const DeclaredTensors& declared);
};

}  // namespace weir::engine
