// What a model's own metadata say of its picture.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/card/card.hpp"

namespace weir::card {

// `properties`: keys and values from the model. `asked`: the model's input; its name, type, shape
// and layout are kept. Nullopt when they do not say how a picture is prepared. Keys of ONNX models:
// Image.BitmapPixelFormat and Image.NominalPixelRange of ONNX's docs/MetadataProps.md; of
// TensorFlow Lite models: tflite.color_space, tflite.mean, tflite.std, as the engine's module gives
// them.
std::optional<ImageInput> input_from_metadata(const std::map<std::string, std::string>& properties,
                                              ImageInput asked);

// The lines of tflite.labels; none when there are no labels.
std::vector<std::string> labels_from_metadata(const std::map<std::string, std::string>& properties);

}  // namespace weir::card
