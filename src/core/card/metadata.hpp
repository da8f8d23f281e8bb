// Reads how pictures are prepared from a model's own metadata.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/card/card.hpp"

namespace weir::card {

// `properties`: keys and values of the model. `input`: the model's input, whose name, type, shape
// and layout are kept. Nullopt if the metadata do not describe how pictures are prepared. Keys of
// ONNX models: Image.BitmapPixelFormat and Image.NominalPixelRange (docs/MetadataProps.md of ONNX);
// of TensorFlow Lite models: tflite.color_space, tflite.mean and tflite.std, as set by the engine's
// module.
std::optional<ImageInput> input_from_metadata(const std::map<std::string, std::string>& properties,
                                              ImageInput input);

// The lines of tflite.labels; empty if there are none.
std::vector<std::string> labels_from_metadata(const std::map<std::string, std::string>& properties);

}  // namespace weir::card
