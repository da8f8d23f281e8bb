// Reads picture and label information from TensorFlow Lite metadata.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <map>
#include <span>
#include <string>

namespace weir::engine {

// `metadata`: the buffer TFLITE_METADATA of `file`. Keys, each only if the metadata have it:
// tflite.color_space (RGB or GRAYSCALE), tflite.mean and tflite.std (comma-separated numbers) of
// the first input; tflite.labels (lines) of the first output, from the files archived after the
// model. Damaged metadata give no keys. Fields: metadata_schema.fbs of TensorFlow Lite Support.
// Archive: APPNOTE of the ZIP format, only entries that are stored without compression.
std::map<std::string, std::string> tflite_properties(std::span<const std::byte> file,
                                                     std::span<const std::byte> metadata);

}  // namespace weir::engine
