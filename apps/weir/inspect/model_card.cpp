// SPDX-License-Identifier: LGPL-2.1-or-later
#include "inspect/model_card.hpp"

#include <filesystem>
#include <map>
#include <vector>

#include "core/card/metadata.hpp"
#include "gstcpp/element/file_digest.hpp"
#include "inspect/launch_line.hpp"

namespace weir::app {
namespace {

namespace fs = std::filesystem;

// An input that has the shape of a picture; open sizes become 224.
card::ImageInput make_image_input(const weir_tensor_info& info) {
  constexpr int64_t kOpenSide = 224;
  card::ImageInput input;
  input.name = info.name ? info.name : "";
  input.type =
      info.type < WEIR_TYPE_END ? static_cast<ElementType>(info.type) : ElementType::Float32;
  input.shape.assign(info.shape, info.shape + info.rank);
  if (info.rank == 4 && input.shape[0] < 0) input.shape[0] = 1;
  for (auto& extent : input.shape)
    if (extent < 0) extent = kOpenSide;
  const bool colors_last = input.shape.back() == 1 || input.shape.back() == 3;
  input.layout =
      info.layout == WEIR_LAYOUT_NCHW || !colors_last ? card::Layout::Nchw : card::Layout::Nhwc;
  return input;
}

std::vector<card::ImageInput> make_image_inputs(const infer::Model& model) {
  std::vector<card::ImageInput> out;
  for (const auto& info : model.inputs())
    if (info.rank == 3 || info.rank == 4) out.push_back(make_image_input(info));
  return out;
}

std::map<std::string, std::string> make_properties(const infer::Model& model) {
  std::map<std::string, std::string> out;
  const char* text = model.info().metadata_json;
  const auto metadata = Json::parse(text ? text : "", nullptr, false);
  if (!metadata.is_object() || !metadata.contains("custom_metadata_map")) return out;
  for (const auto& [key, value] : metadata["custom_metadata_map"].items())
    if (value.is_string()) out[key] = value.get<std::string>();
  return out;
}

}  // namespace

bool has_pictures(const infer::Model& model) {
  return !make_image_inputs(model).empty();
}

card::Search card_search(const std::string& model_path, const infer::Model& model) {
  card::Search search;
  search.model = model_path;
  search.sha256 = [model_path] { return gst::known_sha256(model_path); };
  search.folders = card::card_folders();
  search.inputs = make_image_inputs(model);
  const auto properties = make_properties(model);
  if (search.inputs.size() == 1)
    if (const auto input = card::input_from_metadata(properties, search.inputs[0]))
      search.from_model = {*input};
  search.labels_from_model = card::labels_from_metadata(properties);
  for (const auto& info : model.outputs()) {
    const size_t rank = info.rank == WEIR_RANK_UNKNOWN ? 0 : info.rank;
    search.outputs.push_back({info.name ? info.name : "", type_name(info),
                              std::vector<int64_t>(info.shape, info.shape + rank)});
  }
  return search;
}

Result<card::Card> make_card(const std::string& model_path, const infer::Model& model) {
  return card::find(card_search(model_path, model));
}

Json to_json(const card::Card& card, const std::string& model_path) {
  Json out{
      {"name", card.name}, {"path", card.path}, {"task", card.task}, {"decoder", card.decoder}};
  const auto labels = card::read_labels(card, model_path, {});
  out["labels"] = labels ? Json(*labels) : Json(nullptr);
  if (!labels) out["problem"] = labels.error().message();
  out["preparation"] = card::preparation(card.inputs[0]);
  return out;
}

}  // namespace weir::app
