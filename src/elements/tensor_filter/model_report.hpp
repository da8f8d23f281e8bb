// What tensor_filter reports of its model: in properties, in stats, in errors and with each frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/filter/layout_list.hpp"
#include "core/filter/model_description.hpp"
#include "core/infer/model/invoke_statistics.hpp"
#include "core/infer/model/model.hpp"
#include "elements/tensor_filter/filter_settings.hpp"
#include "weir/result.hpp"

namespace weir {

class OpenModel;

// ModelReport: base class of the element with the properties that read as values of the model where
// the user set nothing. Thread-safe.
class ModelReport {
 public:
  std::string framework() const;
  std::string sub_plugins() const;
  // The property as the user set it, otherwise that of the model's tensors.
  template <auto Own, bool Input, std::string (*Text)(const std::vector<ModelTensor>&)>
  std::string reported() const {
    const FilterSettings s = current_settings();
    return (s.*Own).empty() ? Text(tensors(s, Input)) : s.*Own;
  }
  // The properties of this name, as NNStreamer reads them: names are one comma less than tensors
  // without names, layouts are ANY unless the user set them, ranks those of the dimensions as the
  // user spelled them.
  template <auto Own, bool Input>
  std::string reported_names() const {
    const FilterSettings s = current_settings();
    return (s.*Own).empty() ? names(s, Input) : s.*Own;
  }
  template <auto Own, bool Input>
  std::string reported_layouts() const {
    const FilterSettings s = current_settings();
    return (s.*Own).empty() ? layouts(s, Input) : layouts_text(s.*Own);
  }
  template <bool Input>
  std::string reported_ranks() const {
    return ranks(current_settings(), Input);
  }
  int latency() const;
  int throughput() const;

 protected:
  ~ModelReport() = default;
  virtual FilterSettings current_settings() const = 0;
  // The model that is open, or null.
  virtual std::shared_ptr<const OpenModel> opened() const = 0;
  // Reports the tensors of a negotiated stream, until forget().
  void report(ModelTensors tensors);
  void forget();

  infer::InvokeStatistics statistics_;

 private:
  std::vector<ModelTensor> tensors(const FilterSettings& settings, bool inputs) const;
  std::string names(const FilterSettings& settings, bool inputs) const;
  std::string layouts(const FilterSettings& settings, bool inputs) const;
  std::string ranks(const FilterSettings& settings, bool inputs) const;
  std::shared_ptr<const ModelTensors> tensors_of_unopened(const FilterSettings& settings) const;

  mutable std::mutex mutex_;                    // guards stream_
  std::shared_ptr<const ModelTensors> stream_;  // null: no stream was negotiated
  mutable std::mutex opening_;                  // guards the rest
  mutable FilterSettings known_of_;
  mutable std::shared_ptr<const ModelTensors> known_;
};

// Adds the counts of the engine, and `servers`, an array with a structure for each server that the
// model is on: nothing if the engine reports none.
void add_engine_stats(const infer::Model& model, GstStructure* stats);

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
