// ModelReport: what the properties input, inputtype, inputname, output... of tensor_filter say
// where the user said nothing: the tensors of the model.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/filter/model_shape.hpp"
#include "elements/tensor_filter/filter_settings.hpp"

namespace weir {

// Lists as the properties are written; "" for no tensors.
std::string dimensions_text(const std::vector<ModelShape>& shapes);
std::string types_text(const std::vector<ModelShape>& shapes);
std::string names_text(const std::vector<ModelShape>& shapes);
std::string layouts_text(const std::vector<ModelShape>& shapes);
// The user's list as it was understood: an unknown word is NONE.
std::string layouts_text(const std::string& list);

// Thread-safe.
class ModelReport {
 public:
  struct Tensors {
    std::vector<ModelShape> inputs, outputs;
  };
  // Of a stream that was negotiated; until forget().
  void negotiated(Tensors tensors);
  void forget();
  // Null where nothing was negotiated.
  std::shared_ptr<const Tensors> of_stream() const;
  // Of the model of a filter that does not run, which is opened for it, once for the same settings.
  // Null without a model, and for one that does not open.
  std::shared_ptr<const Tensors> of_settings(const FilterSettings& settings);

 private:
  mutable std::mutex mutex_;  // guards stream_
  std::shared_ptr<const Tensors> stream_;
  std::mutex opening_;  // guards the rest
  std::string known_key_;
  std::shared_ptr<const Tensors> known_;
};

}  // namespace weir
