// What a model's own metadata say of its picture.
#pragma once
#include <map>
#include <optional>
#include <string>

#include "core/card/card.hpp"

namespace weir::card {

// `properties`: keys and values from the model. `asked`: the model's input; its name, type, shape
// and layout are kept. Nullopt when they do not say how a picture is prepared. Keys of ONNX models:
// Image.BitmapPixelFormat and Image.NominalPixelRange of ONNX's docs/MetadataProps.md.
std::optional<ImageInput> input_from_metadata(const std::map<std::string, std::string>& properties,
                                              ImageInput asked);

}  // namespace weir::card
