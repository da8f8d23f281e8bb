// Copies tensors into a buffer after checking all of them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pipeline/pushed_buffer.hpp"

#include <algorithm>
#include <cstring>
#include <functional>
#include <limits>
#include <vector>

#include "core/tensor/tensor_header.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/memory_part.hpp"

namespace weir::pipeline {
namespace {

std::string name_of_tensor(size_t index) {
  return "tensor " + std::to_string(index);
}

Result<Shape> to_shape(const weir_tensor_info& info, size_t index) {
  Shape shape{1};
  if (info.rank == 0) return shape;
  for (uint32_t i = 0; i < info.rank; ++i) {
    const int64_t extent = info.shape[info.rank - 1 - i];
    if (extent < 0 || extent > std::numeric_limits<uint32_t>::max())
      return Error{.code = Code::SPEC_MISMATCH,
                   .what = name_of_tensor(index) + " has an impossible shape",
                   .offered = "an extent of " + std::to_string(extent),
                   .needed = "0 to 4294967295",
                   .difference = "axis " + std::to_string(info.rank - 1 - i)};
    shape[i] = static_cast<uint32_t>(extent);
  }
  if (shape.rank() < info.rank) shape.set_rank(info.rank);
  return shape;
}

// The bytes of one memory: the payload of a tensor, with its header if there is one.
size_t chunk_bytes(const weir_tensor& tensor, Format format) {
  return tensor.bytes + (format == Format::Flexible ? kTensorHeaderBytes : 0);
}

void write_chunk(const weir_tensor& tensor, const TensorSpec& spec, Format format,
                 std::span<std::byte> out) {
  if (format == Format::Flexible) {
    TensorHeader header;
    header.spec = spec;
    header.format = Format::Flexible;
    write_tensor_header(header, out.first<kTensorHeaderBytes>());
    out = out.subspan(kTensorHeaderBytes);
  }
  if (tensor.bytes > 0) std::memcpy(out.data(), tensor.data, tensor.bytes);
}

// The rows of a plane, without padding.
struct PlaneRows {
  size_t count = 0, bytes = 0;
};

PlaneRows find_rows(const GstVideoInfo& video, guint plane) {
  for (guint i = 0; i < GST_VIDEO_INFO_N_COMPONENTS(&video); ++i)
    if (GST_VIDEO_INFO_COMP_PLANE(&video, i) == plane)
      return {static_cast<size_t>(GST_VIDEO_INFO_COMP_HEIGHT(&video, i)),
              static_cast<size_t>(GST_VIDEO_INFO_COMP_WIDTH(&video, i)) *
                  static_cast<size_t>(GST_VIDEO_INFO_COMP_PSTRIDE(&video, i))};
  return {};
}

}  // namespace

size_t picture_bytes_without_padding(const GstVideoInfo& video) {
  size_t bytes = 0;
  for (guint plane = 0; plane < GST_VIDEO_INFO_N_PLANES(&video); ++plane) {
    const auto rows = find_rows(video, plane);
    if (rows.bytes == 0) return 0;
    bytes += rows.count * rows.bytes;
  }
  return bytes;
}

Result<gst::Ref<GstBuffer>> padded_picture(const std::byte* bytes, const GstVideoInfo& video) {
  auto out = gst::Ref<GstBuffer>::adopt(gst_buffer_new_allocate(nullptr, video.size, nullptr));
  if (!out) return Error{.code = Code::OUT_OF_MEMORY, .what = "no memory for a picture"};
  const gst::MappedMemory map(gst_buffer_peek_memory(out.get(), 0), GST_MAP_WRITE);
  if (!map) return Error{.code = Code::MAPPING_FAILED, .what = "a picture cannot be written"};
  std::byte* const to = map.bytes().data();
  std::fill_n(to, video.size, std::byte{0});
  for (guint plane = 0; plane < GST_VIDEO_INFO_N_PLANES(&video); ++plane) {
    const auto rows = find_rows(video, plane);
    for (size_t row = 0; row < rows.count; ++row, bytes += rows.bytes)
      std::memcpy(to + GST_VIDEO_INFO_PLANE_OFFSET(&video, plane) +
                      row * static_cast<size_t>(GST_VIDEO_INFO_PLANE_STRIDE(&video, plane)),
                  bytes, rows.bytes);
  }
  return out;
}

Result<TensorSpec> pushed_spec(const weir_tensor& tensor, const TensorSpec* expected,
                               size_t index) {
  if (tensor.info.type >= WEIR_TYPE_END)
    return Error{.code = Code::TYPE_SYNTAX,
                 .what = name_of_tensor(index) + " has an unknown type",
                 .offered = std::to_string(tensor.info.type),
                 .needed = "one of enum weir_type"};
  TensorSpec spec{static_cast<ElementType>(tensor.info.type), {}, ""};
  if (tensor.info.rank <= WEIR_RANK_LIMIT) {
    auto shape = to_shape(tensor.info, index);
    if (!shape) return shape.error();
    spec.shape = *shape;
  } else if (expected) {
    spec.shape = expected->shape;
  } else {
    return Error{
        .code = Code::SPEC_MISMATCH,
        .what =
            name_of_tensor(index) + " has no shape, and the caps of the appsrc do not define it",
        .offered =
            std::string(to_string(spec.type)) + ", " + std::to_string(tensor.bytes) + " bytes",
        .needed = "a shape, or caps in the pipeline description",
        .fix =
            "appsrc name=... caps=other/tensors,format=static,num_tensors=1,dimensions=...,"
            "types=" +
            std::string(to_string(spec.type)) + ",framerate=0/1"};
  }
  if (expected && !expected->same_layout(spec))
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = name_of_tensor(index) + " does not match the caps of the appsrc",
                 .offered = spec.to_string(),
                 .needed = expected->to_string(),
                 .difference = first_difference({spec}, {*expected})};
  const auto bytes = spec.bytes();
  if (!bytes || *bytes != tensor.bytes || (!tensor.data && tensor.bytes > 0))
    return Error{
        .code = Code::FRAME_SIZE,
        .what = name_of_tensor(index) + " has a size that does not match its shape",
        .offered = tensor.data ? std::to_string(tensor.bytes) + " bytes" : "no memory",
        .needed = (bytes ? std::to_string(*bytes) : "too many") + " bytes: " + spec.to_string()};
  return spec;
}

Result<gst::Ref<GstBuffer>> pushed_buffer(std::span<const weir_tensor> tensors,
                                          std::span<const TensorSpec> specs, Format format) {
  auto buffer = gst::Ref<GstBuffer>::adopt(gst_buffer_new());
  std::vector<uint64_t> sizes(tensors.size());
  std::transform(tensors.begin(), tensors.end(), sizes.begin(),
                 [format](const auto& tensor) { return chunk_bytes(tensor, format); });
  const auto fill = [&](size_t n, std::span<std::byte> bytes) -> Status {
    write_chunk(tensors[n], specs[n], format, bytes);
    return ok();
  };
  if (auto status = gst::append_filled(specs, sizes, buffer.get(), std::ref(fill)); !status)
    return status.error();
  return buffer;
}

}  // namespace weir::pipeline
