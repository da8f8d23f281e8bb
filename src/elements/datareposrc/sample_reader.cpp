// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/datareposrc/sample_reader.hpp"

#include <array>
#include <filesystem>
#include <numeric>
#include <utility>

#include "core/dataset/description.hpp"
#include "core/split/pick_list.hpp"
#include "core/tensor/tensor_header.hpp"
#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/buffer/caps_text.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"

namespace weir {
namespace {

using Medium = SampleCaps::Medium;
using gst::Ref;
using MaybeDescription = std::optional<dataset::Description>;

Error invalid_samples(std::string what, std::string offered, std::string needed) {
  return Error{.code = Code::SAMPLES_INVALID,
               .what = std::move(what),
               .offered = std::move(offered),
               .needed = std::move(needed),
               .fix = "datareposrc with the location and the json that one datareposink wrote"};
}

std::string bytes_text(uint64_t bytes) {
  return std::to_string(bytes) + " bytes";
}

Result<MaybeDescription> read_description(const std::string& json) {
  if (json.empty()) return MaybeDescription();
  const auto text = dataset::read_text("json", json, dataset::kDescriptionLimit);
  if (!text) return text.error();
  auto description = dataset::parse_description(json, *text);
  if (!description) return description.error();
  return MaybeDescription(*std::move(description));
}

Result<Ref<GstCaps>> described_caps(const MaybeDescription& description,
                                    const ReaderRequest& request) {
  if (!description) return request.caps;
  auto caps = gst::caps_from_text(description->caps);
  if (caps) return caps;
  Error error = caps.error();
  error.what = "gst_caps of " + request.json + " cannot be read: " + error.what;
  return error;
}

Error sequence_of_others(const GstCaps* caps) {
  return Error{.code = Code::OPTION_VALUE,
               .what = "tensors-sequence selects static tensors only",
               .offered = gst::to_string(caps),
               .needed = "other/tensors,format=static",
               .fix = "datareposrc without tensors-sequence"};
}

std::vector<size_t> every_index(size_t count) {
  std::vector<size_t> out(count);
  std::iota(out.begin(), out.end(), size_t{0});
  return out;
}

Ref<GstCaps> caps_of_chosen(const GstCaps* caps, const std::vector<TensorSpec>& tensors) {
  auto out = Ref<GstCaps>::adopt(gst_caps_copy(caps));
  GstStructure* fields = gst_caps_get_structure(out.get(), 0);
  gst_structure_set_name(fields, "other/tensors");
  gst_structure_remove_fields(fields, "dimension", "type", nullptr);
  gst_structure_set(fields, "format", G_TYPE_STRING, "static", "num_tensors", G_TYPE_INT,
                    static_cast<int>(tensors.size()), "dimensions", G_TYPE_STRING,
                    join_shapes(tensors).c_str(), "types", G_TYPE_STRING,
                    join_types(tensors).c_str(), nullptr);
  return out;
}

// Counts the files of a pattern up to the first that is missing.
uint64_t count_files(const dataset::FilePattern& pattern) {
  uint64_t count = 0;
  std::error_code ignored;
  while (std::filesystem::exists(pattern.name(count), ignored)) ++count;
  return count;
}

}  // namespace

Result<SampleReader> SampleReader::open(const ReaderRequest& request) {
  auto description = read_description(request.json);
  if (!description) return description.error();
  const auto caps = described_caps(*description, request);
  if (!caps) return caps.error();
  auto sample = read_sample_caps(caps->get());
  if (!sample && *description) {
    Error error = sample.error();
    error.offered = request.json + ": gst_caps is " + error.offered;
    return error;
  }
  if (!sample) return sample.error();
  SampleReader out;
  out.sample_ = *std::move(sample);
  out.output_caps_ = *caps;
  Status status = out.choose_tensors(request.tensor_sequence);
  if (status)
    status = out.sample_.medium == Medium::Image ? out.open_pictures(request, *description)
                                                 : out.open_file(request, *std::move(description));
  if (!status) return status.error();
  return out;
}

Status SampleReader::open_pictures(const ReaderRequest& request,
                                   const MaybeDescription& description) {
  auto pattern = dataset::FilePattern::parse(request.location);
  if (!pattern) return pattern.error();
  pattern_ = *std::move(pattern);
  count_ = description ? description->total_samples : count_files(pattern_);
  if (count_ > 0) return ok();
  return invalid_samples("there are no samples", pattern_.name(0), "a picture or more");
}

Status SampleReader::open_file(const ReaderRequest& request, MaybeDescription description) {
  auto file = dataset::SampleFile::open("location", request.location);
  if (!file) return file.error();
  file_ = *std::move(file);
  if (description && description->total_samples == 0)
    return invalid_samples("there are no samples", request.json + ": total_samples is 0",
                           "a sample or more");
  Result<dataset::SampleIndex> index{Error{}};
  if (sample_.medium == Medium::HeaderedTensors) {
    index = dataset::SampleIndex::of_listed(description.value_or(dataset::Description()),
                                            request.json.empty() ? "caps" : request.json,
                                            request.location, file_.bytes());
  } else {
    if (auto status = choose_size(request, description); !status) return status;
    index = dataset::SampleIndex::of_equal(sample_bytes_, count_samples(request, description),
                                           request.location, file_.bytes());
  }
  if (!index) return index.error();
  index_ = *std::move(index);
  count_ = index_.count();
  if (count_ > 0) return ok();
  return invalid_samples("there are no samples",
                         request.location + ": " + bytes_text(file_.bytes()),
                         "a sample or more, each of " + bytes_text(sample_bytes_));
}

// The caps give the size, or else the JSON file, or else the property blocksize.
Status SampleReader::choose_size(const ReaderRequest& request,
                                 const MaybeDescription& description) {
  const auto described = description ? description->sample_size : std::nullopt;
  sample_bytes_ = sample_.bytes > 0 ? sample_.bytes : described.value_or(request.block_bytes);
  if (!described || *described == sample_bytes_ || sample_.medium == Medium::Audio) return ok();
  return invalid_samples("sample_size does not fit gst_caps",
                         request.json + ": sample_size is " + std::to_string(*described),
                         bytes_text(sample_bytes_) + " of " + gst::to_string(sample_.caps.get()));
}

uint64_t SampleReader::count_samples(const ReaderRequest& request,
                                     const MaybeDescription& description) {
  const uint64_t in_file = sample_bytes_ > 0 ? file_.bytes() / sample_bytes_ : 0;
  if (!description) return in_file;
  const uint64_t total = description->total_samples;
  const auto described = description->sample_size;
  if (sample_.medium == Medium::Audio && described && *described != sample_bytes_) {
    warnings_.push_back(
        invalid_samples("audio is read in seconds, and was not recorded in seconds",
                        request.json + ": sample_size is " + std::to_string(*described),
                        bytes_text(sample_bytes_) + ", a second of the audio"));
    warnings_.back().fix = "audiobuffersplit output-buffer-duration=1/1 ! datareposink";
    return in_file;
  }
  if (in_file > total)
    warnings_.push_back(invalid_samples("the file is longer than its description",
                                        request.location + ": " + bytes_text(file_.bytes()),
                                        std::to_string(total) + " samples of " +
                                            bytes_text(sample_bytes_) +
                                            "; what follows them is not read"));
  return total;
}

Status SampleReader::choose_tensors(const std::string& sequence) {
  auto chosen = parse_index_list("tensors-sequence", sequence, ",");
  if (!chosen) return chosen.error();
  if (sample_.medium != Medium::StaticTensors)
    return chosen->empty() ? ok() : Status(sequence_of_others(sample_.caps.get()));
  if (chosen->empty()) return take_tensors(every_index(sample_.tensors.tensors.size()));
  if (chosen->size() > kTensorLimit)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "tensors-sequence has too many tensors",
                 .offered = std::to_string(chosen->size()),
                 .needed = "at most " + std::to_string(kTensorLimit)};
  if (auto status = take_tensors(*chosen); !status) return status;
  output_caps_ = caps_of_chosen(output_caps_.get(), tensors_);
  return ok();
}

Status SampleReader::take_tensors(const std::vector<size_t>& chosen) {
  const auto& all = sample_.tensors.tensors;
  std::vector<uint64_t> starts;
  uint64_t start = 0;
  for (const auto& tensor : all) {
    starts.push_back(start);
    start += tensor.bytes().value_or(0);
  }
  for (const size_t i : chosen) {
    if (i >= all.size()) return index_beyond("tensors-sequence", "tensor", i, all.size());
    tensors_.push_back(all[i]);
    tensor_offsets_.push_back(starts[i]);
    tensor_bytes_.push_back(all[i].bytes().value_or(0));
  }
  return ok();
}

Result<Ref<GstBuffer>> SampleReader::read(uint64_t index, const BufferLimit& limit) const {
  switch (sample_.medium) {
    case Medium::Image:
      return read_picture(index, limit);
    case Medium::StaticTensors:
      return read_tensors(index, limit);
    case Medium::HeaderedTensors:
      return read_headered(index, limit);
    case Medium::Video:
    case Medium::Audio:
    case Medium::Bytes:
      break;
  }
  return read_bytes(file_, index_.offset(index), sample_bytes_, limit);
}

Result<Ref<GstBuffer>> SampleReader::read_bytes(const dataset::SampleFile& file, uint64_t offset,
                                                uint64_t bytes, const BufferLimit& limit) const {
  if (auto status = limit.check(bytes); !status) return status.error();
  auto buffer = gst::allocate_buffer(bytes);
  if (!buffer) return buffer;
  const gst::Mapped map(buffer->get(), GST_MAP_WRITE);
  if (!map) return gst::output_not_writable();
  if (auto status = file.read(offset, map.bytes()); !status) return status.error();
  return buffer;
}

Result<Ref<GstBuffer>> SampleReader::read_picture(uint64_t index, const BufferLimit& limit) const {
  const auto file =
      dataset::SampleFile::open("sample " + std::to_string(index), pattern_.name(index));
  if (!file) return file.error();
  return read_bytes(*file, 0, file->bytes(), limit);
}

Result<Ref<GstBuffer>> SampleReader::read_tensors(uint64_t index, const BufferLimit& limit) const {
  uint64_t all = 0;
  for (const uint64_t bytes : tensor_bytes_) all += bytes;
  if (auto status = limit.check(all); !status) return status.error();
  auto buffer = Ref<GstBuffer>::adopt(gst_buffer_new());
  const auto fill = [&](size_t n, std::span<std::byte> bytes) {
    return file_.read(index_.offset(index) + tensor_offsets_[n], bytes);
  };
  if (auto s = gst::append_filled(tensors_, tensor_bytes_, buffer.get(), fill); !s)
    return s.error();
  return buffer;
}

Result<TensorSpec> SampleReader::read_header(uint64_t at, uint64_t bytes) const {
  std::array<std::byte, kTensorHeaderBytes> head;
  if (auto status = file_.read(at, head); !status) return status.error();
  auto header = read_tensor_header(head);
  if (!header) return header.error();
  const uint64_t needed = kTensorHeaderBytes + header->payload_bytes().value_or(0);
  if (needed > bytes)
    return invalid_samples("a tensor is longer than its tensor_size", bytes_text(bytes),
                           bytes_text(needed));
  return std::move(header->spec);
}

Result<Ref<GstBuffer>> SampleReader::read_headered(uint64_t index, const BufferLimit& limit) const {
  const auto sizes = index_.tensor_sizes(index);
  std::vector<TensorSpec> specs;
  std::vector<uint64_t> offsets;
  uint64_t at = index_.offset(index);
  for (const uint64_t bytes : sizes) {
    auto spec = read_header(at, bytes);
    if (!spec) {
      Error error = spec.error();
      error.offered = "sample " + std::to_string(index) + ", tensor " +
                      std::to_string(offsets.size()) + " at byte " + std::to_string(at) + ": " +
                      error.offered;
      return error;
    }
    specs.push_back(*std::move(spec));
    offsets.push_back(at);
    at += bytes;
  }
  if (auto status = limit.check(at - index_.offset(index)); !status) return status.error();
  auto buffer = Ref<GstBuffer>::adopt(gst_buffer_new());
  const auto fill = [&](size_t n, std::span<std::byte> bytes) {
    return file_.read(offsets[n], bytes);
  };
  if (auto s = gst::append_filled(specs, sizes, buffer.get(), fill); !s) return s.error();
  return buffer;
}

}  // namespace weir
