// Recording: writes the samples of a stream to files, and describes them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <optional>
#include <string>
#include <utility>

#include "core/dataset/description.hpp"
#include "core/dataset/file_pattern.hpp"
#include "core/dataset/sample_file.hpp"
#include "elements/datareposink/sample_caps.hpp"
#include "gstcpp/buffer/frame_layout.hpp"

namespace weir {

class Recording {
 public:
  Recording() = default;
  explicit Recording(std::string location) : location_(std::move(location)) {}

  // Creates or truncates the file, except for pictures. SPEC_MISMATCH if the samples that follow
  // would not be like those in the file.
  Status set_caps(const SampleCaps& caps);
  bool has_caps() const noexcept { return static_cast<bool>(caps_.caps); }
  // Writes one sample. After an error nothing of it is in the file. Precondition: has_caps().
  Status add(GstBuffer* buffer);
  // Once, when a sample has not the size of the one before.
  std::optional<Error> take_warning() { return std::exchange(warning_, std::nullopt); }
  // Closes the file and writes the description. Does nothing before caps.
  Status finish(const std::string& json);

 private:
  Status add_tensors(GstBuffer* buffer);
  Status append(GstBuffer* buffer, size_t offset, size_t bytes);
  Status add_picture(GstBuffer* buffer);
  void describe(uint64_t start, uint64_t bytes);

  std::string location_;
  SampleCaps caps_;
  dataset::FilePattern pattern_;  // of pictures
  dataset::SampleWriter file_;    // of other samples; of pictures, the last one
  gst::FrameLayout layout_;
  dataset::Description description_;
  std::optional<Error> warning_;
  bool sizes_differ_ = false;
};

}  // namespace weir
