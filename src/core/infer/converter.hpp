// Converter: an opened external converter of any module, or a function of the process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/infer/converted_frame.hpp"

namespace weir::infer {

class Converter {
 public:
  using Options = std::vector<std::pair<std::string, std::string>>;
  static Result<std::unique_ptr<Converter>> open(const weir_converter_type& type,
                                                 const Options& options);
  virtual ~Converter() = default;

  // Caps as text -> the tensors of each frame; none when they are not known before the first.
  virtual Result<std::vector<TensorSpec>> configure(const std::string& caps) = 0;
  // `in` holds one uint8 tensor for each memory.
  virtual Result<ConvertedFrame> convert(const weir_frame& in) = 0;
  // The frames that follow do not continue those before.
  virtual void reset() noexcept {}
};

}  // namespace weir::infer
