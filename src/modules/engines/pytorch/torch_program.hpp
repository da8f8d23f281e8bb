// TorchProgram: the method forward of a TorchScript archive. Including this needs no libtorch
// header: those take half a minute to compile, only in torch_program.cpp.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "pytorch/torch_file.hpp"
#include "pytorch/torch_work.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::engine {

struct TorchFacts {
  std::vector<std::string> input_names;
  // From the graph's types, or from the weights of a convolution that reads the input. Unknown
  // values are type WEIR_TYPE_END, rank WEIR_RANK_UNKNOWN and dimension -1.
  std::vector<weir_tensor_info> inputs;
  std::optional<size_t> outputs;      // empty: a list whose length is set at run time
  std::set<std::string> operators;    // "aten::conv2d" ...
  bool has_state = false;             // forward stores into attributes
  bool writes_inputs = false;         // or may write them: frames are copied
  bool keeps_inputs = false;          // or may, in an attribute: frames are copied
  bool sizes_depend_on_data = false;  // nonzero and similar operators
  uint64_t weight_bytes = 0;
  TorchWork work;
};

class TorchProgram {
 public:
  // Reads `file` during the call. MODEL_UNSUPPORTED names an unsupported operator, input or output;
  // MODEL_INVALID for a file that libtorch cannot load.
  static Result<std::unique_ptr<TorchProgram>> load(const ModelSource& file,
                                                    std::span<const CompressedEntry> compressed,
                                                    bool freeze, bool optimize);
  ~TorchProgram();
  TorchProgram(const TorchProgram&) = delete;
  TorchProgram& operator=(const TorchProgram&) = delete;

  const TorchFacts& facts() const noexcept;
  // Runs on zeros, or on ones if the model fails on zeros. An error when a shape in `inputs` is not
  // fixed; LIMIT_EXCEEDED when they are too large for a dry run (dry_run.hpp).
  Result<std::vector<weir_tensor_info>> dry_run(std::span<const weir_tensor_info> inputs,
                                                int threads) const;
  // Reads inputs in place. Writes into outputs that have data; others get libtorch's memory with
  // its release function. Any thread, concurrently.
  Status run(std::span<const weir_tensor> in, std::span<weir_tensor> out, int threads) const;

  static std::string version();  // "1.13.1"
  static std::string path();     // path of libtorch
  static bool
  has_fast_blas();  // OpenBLAS, MKL or similar; without it matrix products take 30 times longer

 private:
  struct Parts;
  explicit TorchProgram(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace weir::engine
