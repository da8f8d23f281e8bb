// The GstMeta of source maps: copied with a buffer even when its memory is replaced.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/tensor_meta.hpp"

#include <algorithm>
#include <new>

namespace weir::gst {
namespace {

struct TensorMeta {
  GstMeta meta;
  std::vector<SourceMap> maps;
  MapsOf of;
};

// Another copy of this file in the process may have registered both types.
GType tensor_meta_api() {
  static const GType type = [] {
    static const gchar* tags[] = {nullptr};
    if (const GType known = g_type_from_name("WeirTensorMetaAPI")) return known;
    return gst_meta_api_type_register("WeirTensorMetaAPI", tags);
  }();
  return type;
}

gboolean init_tensor_meta(GstMeta* meta, gpointer, GstBuffer*) {
  new (&reinterpret_cast<TensorMeta*>(meta)->maps) std::vector<SourceMap>();
  reinterpret_cast<TensorMeta*>(meta)->of = MapsOf::Tensors;
  return TRUE;
}

void release_tensor_meta(GstMeta* meta, GstBuffer*) {
  reinterpret_cast<TensorMeta*>(meta)->maps.~vector();
}

gboolean copy_tensor_meta(GstBuffer* target, GstMeta* meta, GstBuffer*, GQuark type, gpointer) {
  if (!GST_META_TRANSFORM_IS_COPY(type)) return FALSE;
  const auto* from = reinterpret_cast<TensorMeta*>(meta);
  set_source_maps(target, from->maps, from->of);
  return TRUE;
}

const GstMetaInfo* tensor_meta_info() {
  static const GstMetaInfo* const registered = [] {
    if (const auto* known = gst_meta_get_info("WeirTensorMeta")) return known;
    return gst_meta_register(tensor_meta_api(), "WeirTensorMeta", sizeof(TensorMeta),
                             init_tensor_meta, release_tensor_meta, copy_tensor_meta);
  }();
  return registered;
}

TensorMeta* find_tensor_meta(GstBuffer* buffer) noexcept {
  return reinterpret_cast<TensorMeta*>(gst_buffer_get_meta(buffer, tensor_meta_api()));
}

}  // namespace

std::span<const SourceMap> source_maps(GstBuffer* buffer) noexcept {
  const TensorMeta* meta = find_tensor_meta(buffer);
  return meta ? std::span<const SourceMap>(meta->maps) : std::span<const SourceMap>();
}

MapsOf maps_of(GstBuffer* buffer) noexcept {
  const TensorMeta* meta = find_tensor_meta(buffer);
  return meta ? meta->of : MapsOf::Tensors;
}

void FrameMaps::fill(GstBuffer* buffer, std::span<const size_t> chosen, weir_frame* frame) {
  const auto maps = source_maps(buffer);
  const MapsOf of = maps_of(buffer);
  maps_.clear();
  if (of == MapsOf::Tensors && maps.size() > 1 && !chosen.empty())
    for (const size_t index : chosen)
      maps_.push_back(abi_map(maps[std::min(index, maps.size() - 1)]));
  else
    for (const auto& map : maps) maps_.push_back(abi_map(map));
  frame->maps = maps_.empty() ? nullptr : maps_.data();
  frame->n_maps = static_cast<uint32_t>(maps_.size());
  frame->maps_of = of == MapsOf::Regions ? WEIR_MAPS_OF_REGIONS : WEIR_MAPS_OF_TENSORS;
}

void set_source_maps(GstBuffer* buffer, std::vector<SourceMap> maps, MapsOf of) {
  TensorMeta* meta = find_tensor_meta(buffer);
  if (maps.empty()) {
    if (meta) gst_buffer_remove_meta(buffer, &meta->meta);
    return;
  }
  if (!meta)
    meta = reinterpret_cast<TensorMeta*>(gst_buffer_add_meta(buffer, tensor_meta_info(), nullptr));
  meta->maps = std::move(maps);
  meta->of = of;
}

}  // namespace weir::gst
