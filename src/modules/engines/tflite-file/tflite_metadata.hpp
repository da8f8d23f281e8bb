// What TensorFlow Lite metadata say of a model's picture and labels.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <map>
#include <span>
#include <string>

namespace weir::engine {

// `metadata`: the buffer TFLITE_METADATA of `file`. Keys, each only where the metadata say it:
// tflite.color_space (RGB or GRAYSCALE), tflite.mean and tflite.std (numbers with commas) of the
// first input; tflite.labels (lines) of the first output, out of the files that are packed behind
// the model. Damaged metadata say nothing. Fields: metadata_schema.fbs of TensorFlow Lite Support;
// the archive: APPNOTE of the ZIP format, entries that are stored and not compressed.
std::map<std::string, std::string> tflite_properties(std::span<const std::byte> file,
                                                     std::span<const std::byte> metadata);

}  // namespace weir::engine
