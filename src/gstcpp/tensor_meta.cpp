// The GstMeta: copied with a buffer whatever becomes of its memory.
#include "gstcpp/tensor_meta.hpp"

#include <algorithm>
#include <new>

namespace weir::gst {
namespace {

struct TensorMeta {
  GstMeta meta;
  std::vector<PictureMap> maps;
  MapsOf of;
};

// Another copy of this file in the process may have registered both already.
GType api_type() {
  static const GType type = [] {
    static const gchar* tags[] = {nullptr};
    if (const GType known = g_type_from_name("WeirTensorMetaAPI")) return known;
    return gst_meta_api_type_register("WeirTensorMetaAPI", tags);
  }();
  return type;
}

gboolean init(GstMeta* meta, gpointer, GstBuffer*) {
  new (&reinterpret_cast<TensorMeta*>(meta)->maps) std::vector<PictureMap>();
  reinterpret_cast<TensorMeta*>(meta)->of = MapsOf::Tensors;
  return TRUE;
}

void release(GstMeta* meta, GstBuffer*) {
  reinterpret_cast<TensorMeta*>(meta)->maps.~vector();
}

gboolean copy(GstBuffer* target, GstMeta* meta, GstBuffer*, GQuark type, gpointer) {
  if (!GST_META_TRANSFORM_IS_COPY(type)) return FALSE;
  const auto* from = reinterpret_cast<TensorMeta*>(meta);
  set_picture_maps(target, from->maps, from->of);
  return TRUE;
}

const GstMetaInfo* info() {
  static const GstMetaInfo* const registered = [] {
    if (const auto* known = gst_meta_get_info("WeirTensorMeta")) return known;
    return gst_meta_register(api_type(), "WeirTensorMeta", sizeof(TensorMeta), init, release, copy);
  }();
  return registered;
}

TensorMeta* meta_of(GstBuffer* buffer) noexcept {
  return reinterpret_cast<TensorMeta*>(gst_buffer_get_meta(buffer, api_type()));
}

}  // namespace

std::span<const PictureMap> picture_maps(GstBuffer* buffer) noexcept {
  const TensorMeta* meta = meta_of(buffer);
  return meta ? std::span<const PictureMap>(meta->maps) : std::span<const PictureMap>();
}

MapsOf maps_of(GstBuffer* buffer) noexcept {
  const TensorMeta* meta = meta_of(buffer);
  return meta ? meta->of : MapsOf::Tensors;
}

const float* to_source(GstBuffer* buffer, size_t tensor, std::array<float, 6>* values) noexcept {
  const auto maps = picture_maps(buffer);
  if (maps.empty()) return nullptr;
  const bool own = maps_of(buffer) == MapsOf::Tensors && tensor < maps.size();
  const PictureMap& map = maps[own ? tensor : 0];
  const double exact[] = {map.xx, map.xy, map.x0, map.yx, map.yy, map.y0};
  std::transform(std::begin(exact), std::end(exact), values->begin(),
                 [](double x) { return static_cast<float>(x); });
  return values->data();
}

void set_picture_maps(GstBuffer* buffer, std::vector<PictureMap> maps, MapsOf of) {
  TensorMeta* meta = meta_of(buffer);
  if (maps.empty()) {
    if (meta) gst_buffer_remove_meta(buffer, &meta->meta);
    return;
  }
  if (!meta) meta = reinterpret_cast<TensorMeta*>(gst_buffer_add_meta(buffer, info(), nullptr));
  meta->maps = std::move(maps);
  meta->of = of;
}

}  // namespace weir::gst
