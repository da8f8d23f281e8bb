// SampleIndex: where each sample lies in its file.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/dataset/description.hpp"
#include "weir/result.hpp"

namespace weir::dataset {

// Everything that it returns lies within the file whose size was given.
class SampleIndex {
 public:
  SampleIndex() = default;
  // `count` samples of `bytes` each, one after the other. SAMPLES_INVALID if there is no room for
  // them in a file `path` of `file_bytes`.
  static Result<SampleIndex> of_equal(uint64_t bytes, uint64_t count, const std::string& path,
                                      uint64_t file_bytes);
  // Tensors with headers, whose sizes the description lists. SAMPLES_INVALID with the first
  // contradiction between the lists, or between them and the file. `json` and `path` are the names
  // of the description and of the file.
  static Result<SampleIndex> of_listed(Description description, const std::string& json,
                                       const std::string& path, uint64_t file_bytes);

  uint64_t count() const noexcept { return count_; }
  // Precondition of both: sample < count().
  uint64_t offset(uint64_t sample) const noexcept {
    return bytes_ > 0 ? sample * bytes_ : sizes_.sample_offset[sample];
  }
  // The bytes of each tensor, with its header; empty for samples of equal size.
  std::span<const uint64_t> tensor_sizes(uint64_t sample) const noexcept;

 private:
  uint64_t count_ = 0;
  uint64_t bytes_ = 0;  // of each sample; 0: listed
  Description::Sizes sizes_;
};

}  // namespace weir::dataset
