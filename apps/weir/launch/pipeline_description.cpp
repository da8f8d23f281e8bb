// Parses elements with names only, then sets their properties.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "launch/pipeline_description.hpp"

#include <algorithm>

#include "core/text/shell_quote.hpp"
#include "gstcpp/element/property_text.hpp"
#include "launch/pipeline_text.hpp"

namespace weir::app {
namespace {

constexpr std::string_view kName = "name";

Status set_property(GstElement* element, const std::string& name, const std::string& text) {
  const auto spec = gst::find_property(element, name);
  if (!spec) return spec.error();
  gst::Value value((*spec)->value_type);
  if (auto status = gst::read_value(element, *spec, text, value.get()); !status) return status;
  g_object_set_property(G_OBJECT(element), name.c_str(), value.get());
  return ok();
}

}  // namespace

PipelineDescription& PipelineDescription::text(std::string_view part) {
  parts_.push_back({std::string(part), "", {}});
  return *this;
}

PipelineDescription& PipelineDescription::element(std::string factory, Properties properties) {
  parts_.push_back({"", std::move(factory), std::move(properties)});
  return *this;
}

PipelineDescription& PipelineDescription::append(const PipelineDescription& other) {
  parts_.insert(parts_.end(), other.parts_.begin(), other.parts_.end());
  return *this;
}

std::string PipelineDescription::get_name(size_t index) const {
  const Part& part = parts_[index];
  for (const auto& [name, value] : part.properties)
    if (name == kName) return value;
  const auto before =
      std::count_if(parts_.begin(), parts_.begin() + static_cast<std::ptrdiff_t>(index),
                    [&part](const Part& other) { return other.factory == part.factory; });
  return part.factory + std::to_string(before);
}

std::string PipelineDescription::pasted() const {
  std::string out;
  for (const Part& part : parts_) {
    out += part.text + part.factory;
    for (const auto& [name, value] : part.properties) out += " " + name + "=" + launch_value(value);
  }
  return out;
}

Result<gst::Ref<GstElement>> PipelineDescription::make() const {
  std::string text;
  for (size_t i = 0; i < parts_.size(); ++i)
    text += parts_[i].factory.empty() ? parts_[i].text : parts_[i].factory + " name=" + get_name(i);
  auto pipeline = read_pipeline({text});
  if (!pipeline) return pipeline;
  for (size_t i = 0; i < parts_.size(); ++i) {
    if (parts_[i].factory.empty()) continue;
    const auto element = gst::Ref<GstElement>::adopt(
        gst_bin_get_by_name(GST_BIN(pipeline->get()), get_name(i).c_str()));
    for (const auto& [name, value] : parts_[i].properties) {
      if (name == kName || !element) continue;
      if (auto status = set_property(element.get(), name, value); !status) return status.error();
    }
  }
  return pipeline;
}

}  // namespace weir::app
