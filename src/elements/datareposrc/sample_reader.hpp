// SampleReader: the samples of a data repository as buffers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <optional>
#include <string>
#include <vector>

#include "core/dataset/file_pattern.hpp"
#include "core/dataset/sample_file.hpp"
#include "core/dataset/sample_index.hpp"
#include "core/limit/buffer_limit.hpp"
#include "elements/datareposink/sample_caps.hpp"

namespace weir {

struct ReaderRequest {
  std::string location;
  std::string json;             // "": `caps` describe the samples
  gst::Ref<GstCaps> caps;       // used without `json`
  uint64_t block_bytes = 0;     // of samples whose size neither the caps nor the JSON file give
  std::string tensor_sequence;  // "0,2"; "" is all
};

class SampleReader {
 public:
  SampleReader() = default;
  // Errors: SAMPLES_INVALID, FILE_NOT_FOUND, FORMAT_UNSUPPORTED, and those of the properties.
  static Result<SampleReader> open(const ReaderRequest& request);

  // Of the buffers: with the tensors that were chosen.
  GstCaps* caps() const noexcept { return output_caps_.get(); }
  const SampleCaps& sample() const noexcept { return sample_; }
  uint64_t count() const noexcept { return count_; }
  // What does not keep the samples from being read, but may surprise.
  const std::vector<Error>& warnings() const noexcept { return warnings_; }

  // Reads one sample into a new buffer. Precondition: index < count().
  Result<gst::Ref<GstBuffer>> read(uint64_t index, const BufferLimit& limit) const;

 private:
  Status open_pictures(const ReaderRequest& request,
                       const std::optional<dataset::Description>& description);
  Status open_file(const ReaderRequest& request, std::optional<dataset::Description> description);
  Status choose_size(const ReaderRequest& request,
                     const std::optional<dataset::Description>& description);
  uint64_t count_samples(const ReaderRequest& request,
                         const std::optional<dataset::Description>& description);
  Status choose_tensors(const std::string& sequence);
  Status take_tensors(const std::vector<size_t>& chosen);

  Result<gst::Ref<GstBuffer>> read_picture(uint64_t index, const BufferLimit& limit) const;
  Result<gst::Ref<GstBuffer>> read_tensors(uint64_t index, const BufferLimit& limit) const;
  // Checks the header of a tensor that has `bytes` with it.
  Result<TensorSpec> read_header(uint64_t at, uint64_t bytes) const;
  Result<gst::Ref<GstBuffer>> read_headered(uint64_t index, const BufferLimit& limit) const;
  Result<gst::Ref<GstBuffer>> read_bytes(const dataset::SampleFile& file, uint64_t offset,
                                         uint64_t bytes, const BufferLimit& limit) const;

  SampleCaps sample_;
  gst::Ref<GstCaps> output_caps_;
  uint64_t count_ = 0;
  uint64_t sample_bytes_ = 0;     // of samples of equal size
  dataset::FilePattern pattern_;  // of pictures
  dataset::SampleFile file_;      // of other samples
  dataset::SampleIndex index_;
  // Static tensors of a buffer: where each lies in its sample.
  std::vector<TensorSpec> tensors_;
  std::vector<uint64_t> tensor_offsets_, tensor_bytes_;
  std::vector<Error> warnings_;
};

}  // namespace weir
