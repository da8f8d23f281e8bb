// Reads and writes headers of flexible and sparse tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstring>
#include <optional>

#include "compat/guard.hpp"
#include "compat/spec.hpp"
#include "core/tensor/tensor_header.hpp"
#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/element/ref.hpp"
#include "nnstreamer_plugin_api.h"

using namespace weir::compat;

namespace {

using Bytes = std::array<std::byte, weir::kTensorHeaderBytes>;

// Parses the fields followed by zeros, as in a stream, by the common header parser.
std::optional<weir::TensorHeader> to_header(const GstTensorMetaInfo& meta) {
  Bytes bytes{};
  std::memcpy(bytes.data(), &meta, sizeof meta);
  const auto header = weir::read_tensor_header(bytes);
  return header ? std::optional(*header) : std::nullopt;
}

void read(const Bytes& bytes, GstTensorMetaInfo* meta) {
  std::memcpy(meta, bytes.data(), sizeof *meta);
}

}  // namespace

void gst_tensor_meta_info_init(GstTensorMetaInfo* meta) {
  if (!given(__func__, {meta})) return;
  Bytes bytes{};
  weir::write_tensor_header({}, bytes);
  read(bytes, meta);
}

gboolean gst_tensor_meta_info_validate(const GstTensorMetaInfo* meta) {
  if (!given(__func__, {meta})) return FALSE;
  return or_else(__func__, FALSE, [&]() -> gboolean { return to_header(*meta).has_value(); });
}

gboolean gst_tensor_meta_info_get_version(const GstTensorMetaInfo* meta, guint* major,
                                          guint* minor) {
  if (!given(__func__, {meta}) || meta->magic != 0xfeedcced ||
      (meta->version & 0xDE000000) != 0xDE000000)
    return FALSE;
  if (major) *major = (meta->version & 0x00FFF000) >> 12;
  if (minor) *minor = meta->version & 0x00000FFF;
  return TRUE;
}

gsize gst_tensor_meta_info_get_header_size(const GstTensorMetaInfo* meta) {
  return gst_tensor_meta_info_get_version(meta, nullptr, nullptr) ? weir::kTensorHeaderBytes : 0;
}

gsize gst_tensor_meta_info_get_data_size(const GstTensorMetaInfo* meta) {
  if (!given(__func__, {meta})) return 0;
  return or_else<gsize>(__func__, 0, [&]() -> gsize {
    const auto header = to_header(*meta);
    return header ? header->payload_bytes().value_or(0) : 0;
  });
}

gboolean gst_tensor_meta_info_update_header(const GstTensorMetaInfo* meta, gpointer header) {
  if (!given(__func__, {meta, header})) return FALSE;
  return or_else(__func__, FALSE, [&]() -> gboolean {
    if (!to_header(*meta)) return FALSE;
    std::memset(header, 0, weir::kTensorHeaderBytes);
    std::memcpy(header, meta, sizeof *meta);
    return TRUE;
  });
}

gboolean gst_tensor_meta_info_parse_header(GstTensorMetaInfo* meta, gconstpointer header) {
  if (!given(__func__, {meta, header})) return FALSE;
  return or_else(__func__, FALSE, [&]() -> gboolean {
    Bytes bytes;
    std::memcpy(bytes.data(), header, bytes.size());
    if (!weir::read_tensor_header(bytes)) return FALSE;
    read(bytes, meta);
    return TRUE;
  });
}

gboolean gst_tensor_meta_info_parse_memory(GstTensorMetaInfo* meta, GstMemory* memory) {
  if (!given(__func__, {meta, memory})) return FALSE;
  const weir::gst::MappedMemory mapped(memory, GST_MAP_READ);
  return mapped && mapped.bytes().size() >= weir::kTensorHeaderBytes &&
         gst_tensor_meta_info_parse_header(meta, mapped.bytes().data());
}

GstMemory* gst_tensor_meta_info_append_header(GstTensorMetaInfo* meta, GstMemory* memory) {
  if (!given(__func__, {meta, memory})) return nullptr;
  return or_else<GstMemory*>(__func__, nullptr, [&]() -> GstMemory* {
    const weir::gst::MappedMemory data(memory, GST_MAP_READ);
    if (!data || !to_header(*meta)) return nullptr;
    auto made = weir::gst::allocate_memory(weir::kTensorHeaderBytes + data.bytes().size());
    if (!made) {
      warn("gst_tensor_meta_info_append_header", made.error());
      return nullptr;
    }
    {
      const weir::gst::MappedMemory to(made->get(), GST_MAP_WRITE);
      if (!to) return nullptr;
      gst_tensor_meta_info_update_header(meta, to.bytes().data());
      std::copy(data.bytes().begin(), data.bytes().end(),
                to.bytes().begin() + weir::kTensorHeaderBytes);
    }
    return made->release();
  });
}

gboolean gst_tensor_meta_info_convert(const GstTensorMetaInfo* meta, GstTensorInfo* info) {
  if (!given(__func__, {meta, info}) || !gst_tensor_meta_info_validate(meta)) return FALSE;
  gst_tensor_info_init(info);
  info->type = static_cast<tensor_type>(meta->type);
  std::copy_n(meta->dimension, NNS_TENSOR_RANK_LIMIT, info->dimension);
  return TRUE;
}

gboolean gst_tensor_info_convert_to_meta(const GstTensorInfo* info, GstTensorMetaInfo* meta) {
  if (!given(__func__, {info, meta}) || !gst_tensor_info_validate(info)) return FALSE;
  gst_tensor_meta_info_init(meta);
  meta->type = info->type;
  std::copy_n(info->dimension, NNS_TENSOR_RANK_LIMIT, meta->dimension);
  return TRUE;
}
