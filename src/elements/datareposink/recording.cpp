// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/datareposink/recording.hpp"

#include <algorithm>
#include <utility>

#include "gstcpp/buffer/caps_text.hpp"
#include "gstcpp/buffer/frame_errors.hpp"

namespace weir {
namespace {

using Medium = SampleCaps::Medium;
constexpr char kLocation[] = "location";

Error caps_changed(const GstCaps* offered, const GstCaps* needed, uint64_t samples) {
  return Error{.code = Code::SPEC_MISMATCH,
               .what = "the caps changed, and the samples of one file have the same caps",
               .offered = gst::to_string(offered),
               .needed = gst::to_string(needed) + ", as " + std::to_string(samples) +
                         (samples == 1 ? " sample before" : " samples before"),
               .fix = "insert a capsfilter, or record each stream with its own datareposink"};
}

Error size_changed(uint64_t offered, uint64_t needed) {
  return Error{.code = Code::FRAME_SIZE,
               .what = "the samples have different sizes, and the description has only one",
               .offered = std::to_string(offered) + " bytes",
               .needed = std::to_string(needed) + " bytes, as the sample before",
               .fix = "filesrc blocksize=" + std::to_string(needed) +
                      ", or another source of buffers of one size"};
}

}  // namespace

Status Recording::set_caps(const SampleCaps& caps) {
  const bool has_samples = description_.total_samples > 0;
  // Each picture has its own file, which says what it is.
  const bool stay_pictures = caps.medium == Medium::Image && caps_.medium == Medium::Image;
  if (has_samples && !stay_pictures && !gst_caps_is_equal(caps.caps.get(), caps_.caps.get()))
    return caps_changed(caps.caps.get(), caps_.caps.get(), description_.total_samples);
  if (!has_samples && caps.medium == Medium::Image) {
    auto pattern = dataset::FilePattern::parse(location_);
    if (!pattern) return pattern.error();
    pattern_ = *std::move(pattern);
  } else if (!has_samples) {
    auto file = dataset::SampleWriter::create(kLocation, location_);
    if (!file) return file.error();
    file_ = *std::move(file);
  }
  if (!has_samples) {
    description_.sample_size.reset();
    description_.sizes.reset();
    if (caps.medium == Medium::HeaderedTensors)
      description_.sizes.emplace();
    else
      description_.sample_size = 0;
  }
  caps_ = caps;
  description_.caps = gst::to_string(caps.caps.get());
  return ok();
}

Status Recording::add(GstBuffer* buffer) {
  if (caps_.medium == Medium::Image) return add_picture(buffer);
  const bool is_tensors =
      caps_.medium == Medium::StaticTensors || caps_.medium == Medium::HeaderedTensors;
  const uint64_t start = file_.bytes();
  if (auto status =
          is_tensors ? add_tensors(buffer) : append(buffer, 0, gst_buffer_get_size(buffer));
      !status) {
    file_.cut(start);
    return status;
  }
  describe(start, file_.bytes() - start);
  return ok();
}

// The packed memory of more than 16 tensors has a header of its own, which is left out.
Status Recording::add_tensors(GstBuffer* buffer) {
  if (auto status = layout_.locate(buffer, caps_.tensors); !status) return status;
  for (const auto& place : layout_.tensors())
    if (auto status = append(buffer, place.offset, place.size); !status) return status;
  return ok();
}

// Maps one memory after the other: GStreamer would copy them to map all at once.
Status Recording::append(GstBuffer* buffer, size_t offset, size_t bytes) {
  guint first = 0, count = 0;
  gsize skip = 0;
  if (bytes == 0 || !gst_buffer_find_memory(buffer, offset, bytes, &first, &count, &skip))
    return ok();
  for (guint i = first; i < first + count; ++i) {
    const gst::MappedMemory map(gst_buffer_peek_memory(buffer, i), GST_MAP_READ);
    if (!map) return gst::memory_not_mapped();
    const auto part = map.bytes().subspan(std::exchange(skip, 0));
    const size_t length = std::min(bytes, part.size());
    if (auto status = file_.append(part.first(length)); !status) return status;
    bytes -= length;
  }
  return ok();
}

Status Recording::add_picture(GstBuffer* buffer) {
  auto file = dataset::SampleWriter::create(kLocation, pattern_.name(description_.total_samples));
  if (!file) return file.error();
  file_ = *std::move(file);
  if (auto status = append(buffer, 0, gst_buffer_get_size(buffer)); !status) return status;
  const uint64_t bytes = file_.bytes();
  if (auto status = file_.close(); !status) return status;
  describe(0, bytes);
  return ok();
}

void Recording::describe(uint64_t start, uint64_t bytes) {
  const bool is_first = description_.total_samples++ == 0;
  if (auto& sizes = description_.sizes) {
    sizes->sample_offset.push_back(start);
    sizes->tensor_count.push_back(sizes->tensor_size.size());
    for (const auto& place : layout_.tensors()) sizes->tensor_size.push_back(place.size);
    return;
  }
  // Audio is read in seconds, however long its buffers were.
  const bool has_one_size = caps_.medium == Medium::Bytes || caps_.medium == Medium::Video;
  const uint64_t before = std::exchange(description_.sample_size, bytes).value_or(bytes);
  if (!has_one_size || is_first || before == bytes || sizes_differ_) return;
  sizes_differ_ = true;
  warning_ = size_changed(bytes, before);
}

Status Recording::finish(const std::string& json) {
  if (!has_caps()) return ok();
  const Status closed = file_.close();
  const Status written = dataset::write_text("json", json, dataset::to_json(description_));
  return written ? closed : written;
}

}  // namespace weir
