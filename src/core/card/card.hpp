// Card: how a model's input pictures are prepared and what its outputs mean. See docs/cards.md.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/tensor/element_type.hpp"
#include "weir/result.hpp"

namespace weir::card {

enum class Layout { Nhwc, Nchw };
enum class Color { Gray, Rgb, Bgr };
// Crop: the largest centred part with the model's proportions. Letterbox: the whole picture in its
// own proportions, with a border around it.
enum class Fit { Stretch, Crop, Letterbox };

// An input picture of the model. Number = (pixel - mean) * scale, per channel or for all.
struct ImageInput {
  std::string name;
  ElementType type = ElementType::End;
  std::vector<int64_t> shape;  // outermost first, including the batch of 1 if the model has one
  Layout layout = Layout::Nhwc;
  Color color = Color::Rgb;
  std::vector<double> mean;   // empty = 0; one number, or one for each channel
  std::vector<double> scale;  // empty = 1
  Fit resize = Fit::Stretch;
  uint8_t padding = 0;  // pixel value of the border of a letterbox

  int64_t width() const noexcept;
  int64_t height() const noexcept;
  int64_t channels() const noexcept;
};

// The labels themselves, or a file next to the model or the card whose first `skip` lines are
// skipped.
struct Labels {
  std::vector<std::string> names;
  std::string file;
  size_t skip = 0;
};

struct Card {
  std::string name, model;
  std::string sha256;  // of the model file, 64 lower-case hexadecimal digits
  std::string task;
  std::vector<ImageInput> inputs;  // at least one
  Labels labels;
  std::string decoder;  // a mode of tensor_decoder among decoder_modes(), "" = none
  // Properties of tensor_decoder for this model: names and values. Files have their folder.
  std::vector<std::pair<std::string, std::string>> decoder_options;
  std::string path;  // the file that the card was read from, or ""
};

// CARD_INVALID with the field, the value and what is needed. `place` names the card. Files that
// options of the decoder name lie in `folder`.
Result<Card> parse(std::string_view json, const std::string& place,
                   const std::filesystem::path& folder = {});
// FILE_NOT_FOUND, or the errors of parse().
Result<Card> read(const std::string& path);

// The labels; reads a label file next to the model, next to the card or in `folders`.
// LABELS_INVALID if the file is missing or empty.
Result<std::vector<std::string>> read_labels(const Card& card, const std::string& model_path,
                                             const std::vector<std::string>& folders);

// The properties of tensor_preprocess for an input, names and values: width, height, fit, ...
std::vector<std::pair<std::string, std::string>> preprocess_properties(const ImageInput& input);
// tensor_preprocess with these properties, to paste.
std::string preprocess_element(const ImageInput& input);

// The elements that turn a tensor of bytes of the picture's size, colours innermost, into the
// model's input; "" if there is nothing to do.
std::string value_elements(const ImageInput& input);

// The elements that turn raw video into the model's input:
// "videoconvert ! videoscale ... ! tensor_converter ! tensor_transform ...", or tensor_preprocess
// with the properties for a letterbox.
std::string preparation(const ImageInput& input);

}  // namespace weir::card
