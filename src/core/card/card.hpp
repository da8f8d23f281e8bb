// A model card: how a model's pixels are prepared and what its outputs mean. docs/cards.md.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/tensor/element_type.hpp"
#include "weir/result.hpp"

namespace weir::card {

enum class Layout { Nhwc, Nchw };
enum class Color { Gray, Rgb, Bgr };
enum class Resize { Stretch, Crop };  // Crop: the middle part of the model's proportions

// A picture that the model takes. Number = (pixel - mean) * scale, per channel or for all.
struct ImageInput {
  std::string name;
  ElementType type = ElementType::End;
  std::vector<int64_t> shape;  // outermost-first, with the batch of 1 when the model has one
  Layout layout = Layout::Nhwc;
  Color color = Color::Rgb;
  std::vector<double> mean;   // empty = 0; one, or one for each channel
  std::vector<double> scale;  // empty = 1
  Resize resize = Resize::Stretch;

  int64_t width() const noexcept;
  int64_t height() const noexcept;
  int64_t channels() const noexcept;
};

// Either the labels themselves or a file beside the model or the card, whose first `skip` lines do
// not count.
struct Labels {
  std::vector<std::string> names;
  std::string file;
  size_t skip = 0;
};

struct Card {
  std::string name, model;
  std::string sha256;  // of the model file, 64 hexadecimal digits in lower case
  std::string task;
  std::vector<ImageInput> inputs;  // at least one
  Labels labels;
  std::string decoder;  // a mode of tensor_decoder, "" = none
  std::string path;     // where the card was read, "" when it was not read from a file
};

// CARD_INVALID with the place in the card: what came, what is needed. `place` names the card.
Result<Card> parse(std::string_view json, const std::string& place);
// FILE_NOT_FOUND, or as parse().
Result<Card> read(const std::string& path);

// The labels, read where they are in a file: beside the model, beside the card, or in `folders`.
// LABELS_INVALID when the file is nowhere or empty.
Result<std::vector<std::string>> labels_of(const Card& card, const std::string& model_path,
                                           const std::vector<std::string>& folders);

// The elements from a raw video stream to the model's input, for a pipeline:
// "videoconvert ! videoscale ... ! tensor_converter ! tensor_transform ...".
std::string preparation(const ImageInput& input);

}  // namespace weir::card
