// ModelReport: the model's tensors, as which the properties input, inputtype, output etc. of
// tensor_filter read where the user set nothing.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "elements/tensor_filter/filter_settings.hpp"

namespace weir {

// Thread-safe.
class ModelReport {
 public:
  using Tensors = ModelTensors;
  // Sets the tensors of a negotiated stream, until forget().
  void negotiated(Tensors tensors);
  void forget();
  // Null if no stream was negotiated.
  std::shared_ptr<const Tensors> of_stream() const;
  // The tensors of the model of a filter that is not running. The model is opened for this, once
  // for the same settings. Null without a model, or if it cannot be opened.
  std::shared_ptr<const Tensors> of_settings(const FilterSettings& settings);

 private:
  mutable std::mutex mutex_;  // guards stream_
  std::shared_ptr<const Tensors> stream_;
  std::mutex opening_;  // guards the rest
  FilterSettings known_of_;
  std::shared_ptr<const Tensors> known_;
};

}  // namespace weir
