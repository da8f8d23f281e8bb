// Finds a model's card by the digest of its file, and its family by its outputs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/input_fix.hpp"

#include "core/card/find_card.hpp"
#include "core/decoders/stream_model.hpp"
#include "core/heads/readings.hpp"
#include "core/heads/usual_input.hpp"
#include "core/text/shell_quote.hpp"
#include "gstcpp/element/file_digest.hpp"

namespace weir {
namespace {

// Whether tensor_preprocess with the card makes a tensor for the model.
bool describes(const card::ImageInput& input, const ModelTensor& needed) {
  if (input.type != needed.type || input.shape.size() != needed.shape.size()) return false;
  for (size_t i = 0; i < needed.shape.size(); ++i)
    if (needed.shape[i] >= 0 && needed.shape[i] != input.shape[i]) return false;
  return true;
}

// The card of the model that describes its input; "" without one.
std::string find_card_for(const std::string& model_path, const ModelTensor& input) {
  if (model_path.empty()) return "";
  card::Search search;
  search.model = model_path;
  search.sha256 = [&model_path] { return gst::known_sha256(model_path); };
  search.folders = card::card_folders();
  const auto card = card::find(search);
  const bool is_usable =
      card && !card->path.empty() && card->inputs.size() == 1 && describes(card->inputs[0], input);
  return is_usable ? card->path : "";
}

// How pictures usually are prepared for the model, by its outputs; nullopt if it takes none.
std::optional<card::ImageInput> find_usual_input(const infer::Model& model,
                                                 const ModelTensor& needed, std::string* note) {
  const auto &inputs = model.inputs(), &outputs = model.outputs();
  const weir_stream_model facts{.struct_size = sizeof facts,
                                .n_inputs = static_cast<uint32_t>(inputs.size()),
                                .n_outputs = static_cast<uint32_t>(outputs.size()),
                                .inputs = inputs.data(),
                                .outputs = outputs.data(),
                                .path = nullptr,
                                .metadata_json = model.info().metadata_json,
                                .card_labels = nullptr,
                                .n_card_labels = 0};
  decoders::StreamModel described;
  described.set(&facts);
  if (inputs.size() != 1 || inputs[0].rank > WEIR_RANK_LIMIT || outputs.empty())
    return std::nullopt;
  weir_tensor_info input = inputs[0];
  if (needed.shape.size() != input.rank) return std::nullopt;
  for (size_t i = 0; i < needed.shape.size(); ++i)
    if (needed.shape[i] >= 0) input.shape[i] = needed.shape[i];
  heads::set_open_sides(facts.metadata_json, &input);
  const auto reading =
      heads::only_reading(described.facts(std::span<const weir_tensor_info>(), {}, 0));
  auto usual =
      heads::usual_input(reading ? reading->family->name : heads::kUnknownFamily, input, note);
  return usual && describes(*usual, needed) ? std::move(usual) : std::nullopt;
}

// The elements that make the model's input of video, or of a tensor of bytes; "" if they are not
// known.
std::string make_elements(const card::ImageInput& pixels, const TensorSpec& offered,
                          gst::Medium medium) {
  if (medium == gst::Medium::Video) return "videoconvert ! " + card::preprocess_element(pixels);
  const Shape packed{static_cast<uint32_t>(pixels.channels()),
                     static_cast<uint32_t>(pixels.width()), static_cast<uint32_t>(pixels.height())};
  const bool is_picture = offered.type == ElementType::UInt8 && offered.shape == packed;
  return is_picture ? card::value_elements(pixels) : "";
}

// The elements that make the input of the model; "" if they are not known. `note`: what is assumed.
std::string find_elements(const OpenModel& model, const TensorSpec& offered, gst::Medium medium,
                          std::string* note) {
  const ModelTensor& needed = model.inputs()[0];
  const auto& shared = *model.lease().shared();
  const auto& paths = shared.source().options.paths;
  const auto card = medium == gst::Medium::Video && paths.size() == 1
                        ? find_card_for(paths[0], needed)
                        : std::string();
  if (!card.empty()) return "videoconvert ! tensor_preprocess card=" + launch_value(card);
  const auto opened = shared.model();
  const auto pixels = opened ? find_usual_input(*opened, needed, note) : std::nullopt;
  return pixels ? make_elements(*pixels, offered, medium) : "";
}

}  // namespace

Error with_input_fix(Error error, const OpenModel& model, const std::vector<TensorSpec>& stream,
                     gst::Medium medium) {
  const auto& inputs = model.inputs();
  const auto& choice = model.description().input_choice;
  // Its numbers would be those of the chosen tensors.
  if (!choice.empty() && error.fix.starts_with("tensor_filter input-combination=")) error.fix = "";
  if (error.code != Code::SPEC_MISMATCH || inputs.size() != 1) return error;
  const auto chosen = choose_tensors(stream, choice, "input-combination");
  const bool has_other_fix = error.fix.starts_with("tensor_filter ");  // invoke-rows
  if (!chosen || chosen->size() != 1 || has_other_fix || fit(inputs, *chosen)) return error;
  const bool is_video = medium == gst::Medium::Video;
  if (medium != gst::Medium::Unknown)
    error.fix = suggested_fix(chosen->front(), inputs[0], is_video);
  std::string note;
  const std::string elements = find_elements(model, chosen->front(), medium, &note);
  if (elements.empty()) return error;
  error.fix = elements + " ! tensor_filter";
  if (!note.empty()) error.needed += "; " + note;
  if (is_video) error.needed += "; the fix replaces the elements between the video and the filter";
  return error;
}

}  // namespace weir
