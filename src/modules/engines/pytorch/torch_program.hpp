// TorchProgram: the method forward of a TorchScript archive. No header of libtorch is needed here:
// its headers take half a minute, and torch_program.cpp alone pays that.
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
  // What the graph says of them, by its own types or by the weights of a convolution that reads the
  // input: type WEIR_TYPE_END, rank WEIR_RANK_UNKNOWN and -1 stand for what it does not say.
  std::vector<weir_tensor_info> inputs;
  std::optional<size_t> outputs;      // nothing: a list whose length the model decides as it runs
  std::set<std::string> operators;    // "aten::conv2d" ...
  bool has_state = false;             // forward stores into attributes
  bool writes_inputs = false;         // or may: frames are copied then
  bool keeps_inputs = false;          // or may, in an attribute: frames are copied then too
  bool sizes_depend_on_data = false;  // nonzero and the like
  uint64_t weight_bytes = 0;
  TorchWork work;
};

class TorchProgram {
 public:
  // Reads `file` during the call. MODEL_UNSUPPORTED names an operator, an input or an output that
  // cannot be; MODEL_INVALID for what libtorch cannot load.
  static Result<std::unique_ptr<TorchProgram>> load(const ModelSource& file,
                                                    std::span<const CompressedEntry> compressed,
                                                    bool freeze, bool optimize);
  ~TorchProgram();
  TorchProgram(const TorchProgram&) = delete;
  TorchProgram& operator=(const TorchProgram&) = delete;

  const TorchFacts& facts() const noexcept;
  // Runs on zeros, and where the model refuses those on ones. What `inputs` lack is an error, and
  // LIMIT_EXCEEDED what is too large for a dry run (dry_run.hpp).
  Result<std::vector<weir_tensor_info>> dry_run(std::span<const weir_tensor_info> inputs,
                                                int threads) const;
  // Inputs are read where they are. An output with data is written into, another gets libtorch's
  // memory with its release function. Any thread, several at a time.
  Status run(std::span<const weir_tensor> in, std::span<weir_tensor> out, int threads) const;

  static std::string version();  // "1.13.1"
  static std::string path();     // of libtorch
  static bool
  has_fast_blas();  // OpenBLAS, MKL or the like: without it matrices take 30 times longer

 private:
  struct Parts;
  explicit TorchProgram(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace weir::engine
