// Texts, and a model that is opened for its description alone.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/model_report.hpp"

#include <algorithm>

#include "core/filter/layout.hpp"
#include "elements/tensor_filter/opened_model.hpp"
#include "weir/abi.h"

namespace weir {
namespace {

std::string joined_layouts(const std::vector<uint32_t>& layouts) {
  static constexpr const char* kWords[] = {"ANY", "NHWC", "NCHW", "NONE"};
  std::string out;
  for (const uint32_t layout : layouts)
    out += (out.empty() ? "" : ",") +
           std::string(kWords[std::min<uint32_t>(layout, WEIR_LAYOUT_NONE)]);
  return out;
}

// Innermost first; 1 for what the model leaves open, nothing for a rank that it does not say.
std::string dimensions_of(const ModelShape& shape) {
  if (shape.shape.empty()) return shape.rank_known ? "1" : "";
  std::string out;
  for (size_t i = shape.shape.size(); i-- > 0;)
    out += (out.empty() ? "" : ":") + std::to_string(std::max<int64_t>(shape.shape[i], 1));
  return out;
}

// What decides which tensors a model has.
std::string key_of(const FilterSettings& s) {
  std::string out;
  for (const auto* text :
       {&s.framework, &s.model, &s.input, &s.inputtype, &s.inputname, &s.inputlayout, &s.output,
        &s.outputtype, &s.outputname, &s.outputlayout, &s.custom, &s.accelerator})
    out += *text + '\n';
  return out + (s.invoke_dynamic ? "dynamic" : "");
}

}  // namespace

std::string dimensions_text(const std::vector<ModelShape>& shapes) {
  std::string out;
  for (size_t i = 0; i < shapes.size(); ++i) out += (i ? "," : "") + dimensions_of(shapes[i]);
  return out;
}
std::string types_text(const std::vector<ModelShape>& shapes) {
  return join_types(known_parts(shapes));
}
std::string names_text(const std::vector<ModelShape>& shapes) {
  return join_names(known_parts(shapes));
}
std::string layouts_text(const std::vector<ModelShape>& shapes) {
  std::vector<uint32_t> layouts;
  for (const auto& shape : shapes) layouts.push_back(shape.layout);
  return joined_layouts(layouts);
}
std::string layouts_text(const std::string& list) {
  return joined_layouts(parse_layout_list(list, "layout"));
}

void ModelReport::negotiated(Tensors tensors) {
  std::lock_guard lock(mutex_);
  stream_ = std::make_shared<const Tensors>(std::move(tensors));
}

void ModelReport::forget() {
  std::lock_guard lock(mutex_);
  stream_.reset();
}

std::shared_ptr<const ModelReport::Tensors> ModelReport::of_stream() const {
  std::lock_guard lock(mutex_);
  return stream_;
}

std::shared_ptr<const ModelReport::Tensors> ModelReport::of_settings(
    const FilterSettings& settings) {
  // A worker process is not started to answer a question.
  if (settings.model.empty() || settings.isolate != IsolateChoice::None) return nullptr;
  FilterSettings alone = settings;
  alone.workers = 1;
  alone.batch_size = 1;
  alone.invoke_async = false;
  std::lock_guard lock(opening_);
  const auto key = key_of(alone);
  if (known_ && key == known_key_) return known_;
  std::vector<Error> warnings;
  const auto opened = OpenedModel::open(alone, nullptr, &warnings);
  if (!opened) return nullptr;
  known_ = std::make_shared<const Tensors>(Tensors{(*opened)->inputs(), (*opened)->outputs()});
  known_key_ = key;
  return known_;
}

}  // namespace weir
