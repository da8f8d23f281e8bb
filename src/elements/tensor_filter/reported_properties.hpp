// ReportedProperties: the properties of tensor_filter that read as the values of its model where
// the user set nothing.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "core/filter/layout.hpp"
#include "core/infer/model/invoke_statistics.hpp"
#include "core/infer/module/module_library.hpp"
#include "elements/tensor_filter/filter_settings.hpp"
#include "elements/tensor_filter/model_report.hpp"
#include "elements/tensor_filter/model_source.hpp"
#include "elements/tensor_filter/open_model.hpp"
#include "gstcpp/element/property.hpp"
#include "weir/join.hpp"

namespace weir {

// Base class of the element `Filter`, which has settings() and opened(), its model or null.
template <class Filter>
class ReportedProperties {
 public:
  std::string framework() const {
    const auto model = filter().opened();
    return model ? model->engine() : framework_name(filter().settings());
  }
  std::string sub_plugins() const {
    return join(infer::ModuleLibrary::instance().engine_names(), ",");
  }
  // The property as the user set it, otherwise that of the model's tensors.
  template <auto Own, bool Input, std::string (*Text)(const std::vector<ModelTensor>&)>
  std::string reported() const {
    const FilterSettings s = filter().settings();
    return (s.*Own).empty() ? Text(tensors<Input>(s)) : s.*Own;
  }
  template <auto Own, bool Input>
  std::string reported_layouts() const {
    const FilterSettings s = filter().settings();
    return (s.*Own).empty() ? layouts_text(tensors<Input>(s)) : layouts_text(s.*Own);
  }
  template <bool Input>
  std::string reported_ranks() const {
    return ranks_text(tensors<Input>(filter().settings()));
  }
  int latency() const { return filter().settings().latency ? statistics_.latency_us() : -1; }
  int throughput() const {
    return filter().settings().throughput ? statistics_.throughput_milli() : -1;
  }

 protected:
  mutable ModelReport report_;
  infer::InvokeStatistics statistics_;

 private:
  const Filter& filter() const { return static_cast<const Filter&>(*this); }

  template <bool Input>
  std::vector<ModelTensor> tensors(const FilterSettings& s) const {
    auto known = report_.of_stream();
    if (!known) {
      if (const auto model = filter().opened()) return Input ? model->inputs() : model->outputs();
      known = report_.of_settings(s);
    }
    if (!known) return {};
    return Input ? known->inputs : known->outputs;
  }
};

template <class Filter>
constexpr auto reported_properties() {
  using R = ReportedProperties<Filter>;
  using S = FilterSettings;
  constexpr auto kPlaying = gst::Changeable::WhilePlaying;
  return std::tuple{
      gst::Accessor{"input", &S::input, &R::template reported<&S::input, true, dimensions_text>,
                    "Dimensions of the model's inputs, if the model leaves them open", kPlaying},
      gst::Accessor{"inputtype", &S::inputtype,
                    &R::template reported<&S::inputtype, true, types_text>,
                    "Element types of the model's inputs", kPlaying},
      gst::Accessor{"inputname", &S::inputname,
                    &R::template reported<&S::inputname, true, names_text>,
                    "Names of the model's inputs", kPlaying},
      gst::Accessor{"inputlayout", &S::inputlayout,
                    &R::template reported_layouts<&S::inputlayout, true>,
                    "NCHW, NHWC, ANY or NONE for each input", kPlaying},
      gst::Accessor{"output", &S::output, &R::template reported<&S::output, false, dimensions_text>,
                    "Dimensions of the model's outputs", kPlaying},
      gst::Accessor{"outputtype", &S::outputtype,
                    &R::template reported<&S::outputtype, false, types_text>,
                    "Element types of the model's outputs", kPlaying},
      gst::Accessor{"outputname", &S::outputname,
                    &R::template reported<&S::outputname, false, names_text>,
                    "Names of the model's outputs", kPlaying},
      gst::Accessor{"outputlayout", &S::outputlayout,
                    &R::template reported_layouts<&S::outputlayout, false>,
                    "NCHW, NHWC, ANY or NONE for each output", kPlaying},
      gst::Accessor{"framework", &S::framework, &R::framework,
                    "Name of the engine; auto = selected by the extension of the model file",
                    kPlaying},
      gst::ReadOnly{"inputranks", &R::template reported_ranks<true>, "Ranks of the model's inputs"},
      gst::ReadOnly{"outputranks", &R::template reported_ranks<false>,
                    "Ranks of the model's outputs"},
      gst::ReadOnly{"sub-plugins", &R::sub_plugins, "Installed engines"},
      gst::Gauge{"latency", &S::latency, &R::latency,
                 "Write 1 to enable; reads as the mean of the last 10 invokes in microseconds", 0,
                 1},
      gst::Gauge{"throughput", &S::throughput, &R::throughput,
                 "Write 1 to enable; reads as outputs per second x 1000", 0, 1},
  };
}

}  // namespace weir
