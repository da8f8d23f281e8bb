// Description: the JSON file that describes the samples of a data repository
// (docs/compatibility/io.md 7.1).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "weir/result.hpp"

namespace weir::dataset {

inline constexpr size_t kDescriptionLimit = size_t{256} << 20;  // bytes of the text

struct Description {
  std::string caps{};  // of the stream
  uint64_t total_samples = 0;
  std::optional<uint64_t> sample_size{};  // bytes, if all samples have the same size

  // Samples of different sizes: flexible and sparse tensors.
  struct Sizes {
    std::vector<uint64_t> sample_offset;  // where each sample starts in the file
    std::vector<uint64_t> tensor_size;    // bytes of every tensor of all samples, with its header
    std::vector<uint64_t> tensor_count;   // the first tensor of each sample in tensor_size
    bool operator==(const Sizes&) const = default;
  };
  std::optional<Sizes> sizes{};

  bool operator==(const Description&) const = default;
};

// Reads the text of the file `path`. Members that are not known are ignored. Only the members are
// checked, not that they fit together or the file of the samples. Errors: SAMPLES_INVALID.
Result<Description> parse_description(const std::string& path, std::string_view text);
// Writes it as json-glib does: two blanks for each level, "key" : value, one element of an array on
// each line, and no newline at the end.
std::string to_json(const Description& description);

}  // namespace weir::dataset
