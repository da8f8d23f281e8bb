// What tensor_filter reports of its model: in properties, in stats, in errors and with each frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/infer/model/model.hpp"
#include "core/tensor/model_tensor.hpp"
#include "elements/tensor_filter/filter_settings.hpp"
#include "weir/result.hpp"

namespace weir {

// ModelReport: the model's tensors, as which the properties input, inputtype, output etc. read
// where the user set nothing. Thread-safe.
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

// Adds the counts of the engine, and `servers`, an array with a structure for each server that the
// model is on: nothing if the engine reports none.
void add_engine_stats(const infer::Model& model, GstStructure* stats);

// `error` is that of fit(). Elements that only convert the type and the size leave out the mean and
// the scale of the model's card: if a card describes `inputs`, the fix is tensor_preprocess with
// it. Reads the model's file.
Error with_card(Error error, const std::string& model_path, const std::vector<ModelTensor>& inputs);

// Sets who computed a frame in the custom meta "WeirAnsweredBy", which has a string field for each
// filter that the frame went through and that may be answered from several places. The field has
// the name of the element; its value is the address of a server, several with commas for a frame in
// parts, or the path of the fallback. A model in this process needs no field: nothing happens if
// `who` is "".
//
//   GstCustomMeta* meta = gst_buffer_get_custom_meta(buffer, "WeirAnsweredBy");
//   gst_structure_get_string(gst_custom_meta_get_structure(meta), "filter0");
void set_answered_by(GstBuffer* buffer, GstElement* element, const std::string& who);

}  // namespace weir
