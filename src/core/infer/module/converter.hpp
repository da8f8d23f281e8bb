// Converter: an open external converter of a module, or a function of the application.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/infer/module/converted_frame.hpp"

namespace weir::infer {

class Converter {
 public:
  using Options = std::vector<std::pair<std::string, std::string>>;
  static Result<std::unique_ptr<Converter>> open(const weir_converter_type& type,
                                                 const Options& options);
  virtual ~Converter() = default;

  // Returns the tensors of each frame for caps as text; none if unknown before the first frame.
  virtual Result<std::vector<TensorSpec>> configure(const std::string& caps) = 0;
  // `in` holds one uint8 tensor per memory.
  virtual Result<ConvertedFrame> convert(const weir_frame& in) = 0;
  // The next frame does not continue the previous ones.
  virtual void reset() noexcept {}
};

}  // namespace weir::infer
