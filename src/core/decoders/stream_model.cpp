// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/decoders/stream_model.hpp"
#include "core/tensor/geometry.hpp"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

namespace weir::decoders {
namespace {

using heads::ModelSignature;
using heads::OutputSignature;

Shape to_shape(std::span<const int64_t> outermost_first) {
  const size_t rank = outermost_first.size();
  Shape out;
  for (size_t i = 0; i < rank && i < kRankLimit; ++i) {
    const int64_t extent = outermost_first[rank - 1 - i];
    // A batch of unknown size is read picture by picture.
    out[i] = extent > 0 && extent <= UINT32_MAX ? static_cast<uint32_t>(extent) : 1;
  }
  return rank == 0 ? Shape{1} : out;
}

OutputSignature make_facts(const ModelTensor& tensor) {
  return {{.type = tensor.type, .shape = to_shape(tensor.shape), .name = tensor.name},
          tensor.scale != 0};
}

std::vector<ModelTensor> to_model_tensors(const weir_tensor_info* infos, uint32_t count) {
  return infos ? model_tensors({infos, count}) : std::vector<ModelTensor>();
}

// {0: 'person', 1: "traffic light"}: a dict of Python, which is not JSON.
std::vector<std::string> labels_of_dict(const std::string& text) {
  std::vector<std::string> out;
  for (size_t at = text.find(':'); at != std::string::npos; at = text.find(':', at)) {
    const size_t begin = text.find_first_of("'\"", at);
    if (begin == std::string::npos) break;
    const size_t end = text.find(text[begin], begin + 1);
    if (end == std::string::npos) break;
    out.push_back(text.substr(begin + 1, end - begin - 1));
    at = end + 1;
  }
  return out;
}

std::vector<std::string> split_lines(const std::string& text) {
  std::vector<std::string> out;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    out.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return out;
}

std::map<std::string, std::string> parse_metadata(const char* text) {
  std::map<std::string, std::string> out;
  const auto json = nlohmann::json::parse(text ? text : "", nullptr, false);
  const auto add = [&](const nlohmann::json& object) {
    if (!object.is_object()) return;
    for (const auto& [key, value] : object.items())
      if (value.is_string()) out[key] = value.template get<std::string>();
  };
  add(json);
  if (json.is_object() && json.contains("custom_metadata_map")) add(json["custom_metadata_map"]);
  return out;
}

}  // namespace

void StreamModel::set(const weir_stream_model* model) noexcept try {
  *this = StreamModel();
  if (!model) return;
  inputs_ = to_model_tensors(model->inputs, model->n_inputs);
  outputs_ = to_model_tensors(model->outputs, model->n_outputs);
  metadata_ = parse_metadata(model->metadata_json);
  if (model->path) name_ = std::filesystem::path(model->path).stem().string();
  if (const auto names = metadata_.find("names"); names != metadata_.end())
    labels_ = labels_of_dict(names->second);
  if (const auto lines = metadata_.find("tflite.labels"); lines != metadata_.end())
    labels_ = split_lines(lines->second);
  if (const auto characters = metadata_.find("character"); characters != metadata_.end())
    labels_ = split_lines(characters->second);
  constexpr uint32_t kWithCard =
      offsetof(weir_stream_model, n_card_labels) + sizeof model->n_card_labels;
  if (labels_.empty() && model->struct_size >= kWithCard)
    labels_.assign(model->card_labels, model->card_labels + model->n_card_labels);
} catch (const std::exception&) {
  *this = StreamModel();  // out of memory: as if the model were not known
}

// C:W:H or W:H:C, innermost first, by the dimension that can be a number of channels.
Size StreamModel::input_size() const noexcept {
  if (inputs_.empty() || inputs_[0].shape.size() < 3) return {};
  const auto& shape = inputs_[0].shape;
  const auto at = [&](size_t from_inner) { return shape[shape.size() - 1 - from_inner]; };
  const auto size = [](int64_t width, int64_t height) {
    const bool known = width > 0 && height > 0 && width <= 65536 && height <= 65536;
    return known ? Size{static_cast<uint32_t>(width), static_cast<uint32_t>(height)} : Size{};
  };
  const bool is_planar = at(2) == 1 || at(2) == 3 || at(2) == 4;
  const bool is_packed = at(0) == 1 || at(0) == 3 || at(0) == 4;
  return is_planar && !is_packed ? size(at(0), at(1)) : is_packed ? size(at(1), at(2)) : size(0, 0);
}

ModelSignature StreamModel::facts(std::span<const weir_tensor_info> tensors, Size input,
                                  size_t labels) const {
  ModelSignature out;
  out.metadata = metadata_;
  out.labels = labels > 0 ? labels : labels_.size();
  out.input = input.width > 0 ? input : input_size();
  for (const weir_tensor_info& info : tensors)
    out.outputs.push_back(make_facts(model_tensor(info)));
  if (tensors.empty())
    for (const ModelTensor& output : outputs_) out.outputs.push_back(make_facts(output));
  if (out.outputs.empty())
    throw Failure({.code = Code::SPEC_MISMATCH,
                   .what = "the stream does not describe the model's outputs",
                   .offered = "a flexible stream that does not come from tensor_filter",
                   .needed = "the outputs of tensor_filter, or a static stream",
                   .fix = "tensor_filter ... ! tensor_decoder ..."});
  // Names and quantisation are not in caps.
  for (size_t i = 0; i < out.outputs.size() && out.outputs.size() == outputs_.size(); ++i) {
    out.outputs[i].name = outputs_[i].name;
    out.outputs[i].is_quantised = outputs_[i].scale != 0;
  }
  return out;
}

ModelSignature StreamModel::facts(std::span<const weir_tensor> tensors, Size input,
                                  size_t labels) const {
  std::vector<weir_tensor_info> infos;
  for (const weir_tensor& tensor : tensors) infos.push_back(tensor.info);
  return facts(infos, input, labels);
}

std::span<const weir_tensor> StreamModel::with_quantisation(std::span<const weir_tensor> tensors) {
  if (outputs_.size() != tensors.size()) return tensors;
  described_.assign(tensors.begin(), tensors.end());
  for (size_t i = 0; i < tensors.size(); ++i) {
    if (described_[i].info.type != static_cast<uint32_t>(outputs_[i].type)) continue;
    described_[i].info.scale = outputs_[i].scale;
    described_[i].info.zero_point = outputs_[i].zero_point;
  }
  return described_;
}

std::vector<weir_tensor_info> StreamModel::with_quantisation(
    std::span<const weir_tensor_info> infos) const {
  std::vector<weir_tensor_info> out(infos.begin(), infos.end());
  for (size_t i = 0; i < out.size() && outputs_.size() == out.size(); ++i) {
    if (out[i].type != static_cast<uint32_t>(outputs_[i].type)) continue;
    out[i].scale = outputs_[i].scale;
    out[i].zero_point = outputs_[i].zero_point;
  }
  return out;
}

std::string StreamModel::float32_elements() const {
  std::string out;
  for (size_t i = 0; i < outputs_.size(); ++i) {
    if (outputs_[i].scale == 0) continue;
    char option[96];
    std::snprintf(option, sizeof option, "typecast:float32,add:%d.0,mul:%.9g",
                  -outputs_[i].zero_point, double{outputs_[i].scale});
    out += std::string(out.empty() ? "" : " ! ") + "tensor_transform " +
           (outputs_.size() > 1 ? "apply=" + std::to_string(i) + " " : "") +
           "mode=arithmetic option=" + option;
  }
  return out.empty() ? "tensor_transform mode=typecast option=float32" : out;
}

bool has_shapes(const ModelSignature& facts, std::span<const weir_tensor> tensors) noexcept {
  return std::equal(facts.outputs.begin(), facts.outputs.end(), tensors.begin(), tensors.end(),
                    [](const OutputSignature& output, const weir_tensor& tensor) {
                      return static_cast<uint32_t>(output.type) == tensor.info.type &&
                             output.shape ==
                                 to_shape({tensor.info.shape,
                                           std::min<size_t>(tensor.info.rank, WEIR_RANK_LIMIT)});
                    });
}

std::optional<ModelSignature> without_batch(ModelSignature facts) {
  uint32_t batch = 0;
  for (OutputSignature& output : facts.outputs) {
    uint32_t& outermost = output.shape[output.shape.rank() - 1];
    if (outermost <= 1 || (batch != 0 && outermost != batch)) return std::nullopt;
    batch = std::exchange(outermost, 1);
  }
  return batch == 0 ? std::nullopt : std::optional(std::move(facts));
}

bool has_map_fields(const weir_frame& frame) noexcept {
  return frame.struct_size >= offsetof(weir_frame, maps) + sizeof(void*);
}

FrameRegions::FrameRegions(const weir_frame& frame) : frame_(frame) {
  if (!has_map_fields(frame) || frame.maps_of != WEIR_MAPS_OF_REGIONS) return;
  are_regions_ = true;
  count_ = frame.n_maps;
  for (uint32_t i = 0; i < frame.n_tensors; ++i) {
    const weir_tensor_info& info = frame.tensors[i].info;
    if (info.rank > 0 && info.shape[0] >= count_) continue;
    throw Failure({.code = Code::SPEC_MISMATCH,
                   .what = "a tensor of a batch has fewer parts than there are regions",
                   .offered = describe(info),
                   .needed = std::to_string(count_) + " in the outermost dimension"});
  }
}

std::span<const weir_tensor> FrameRegions::tensors(uint32_t region) {
  const std::span<const weir_tensor> all(frame_.tensors, frame_.n_tensors);
  if (!are_regions_) return all;
  slices_.assign(all.begin(), all.end());
  for (weir_tensor& tensor : slices_) {
    const uint64_t bytes = tensor.bytes / static_cast<uint64_t>(tensor.info.shape[0]);
    tensor.data = static_cast<std::byte*>(tensor.data) + bytes * region;
    tensor.bytes = bytes;
    tensor.info.shape[0] = 1;
  }
  return slices_;
}

std::optional<SourceMap> FrameRegions::map(uint32_t region) const noexcept {
  return source_map(frame_, region);
}

int32_t FrameRegions::row(uint32_t region) const noexcept {
  constexpr uint64_t kMax = uint64_t{1} << 24;  // float32 has them exactly
  const auto map = this->map(region);
  const bool known = map && map->row > 0 && map->row <= kMax;
  return static_cast<int32_t>(known ? map->row - 1 : region);
}

}  // namespace weir::decoders
