// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/query_meta.hpp"

namespace weir::gst {
namespace {

struct QueryMeta {
  GstMeta meta;
  gint64 client;
};

GType api_type() {
  static const GType type = [] {
    static const gchar* tags[] = {nullptr};
    if (const GType known = g_type_from_name("GstMetaQueryAPI")) return known;
    return gst_meta_api_type_register("GstMetaQueryAPI", tags);
  }();
  return type;
}

gboolean init(GstMeta* meta, gpointer, GstBuffer*) {
  reinterpret_cast<QueryMeta*>(meta)->client = 0;
  return TRUE;
}

gboolean copy(GstBuffer* target, GstMeta* meta, GstBuffer*, GQuark type, gpointer) {
  return GST_META_TRANSFORM_IS_COPY(type) &&
         set_client(target, reinterpret_cast<QueryMeta*>(meta)->client);
}

// Null when another plug-in registered the names for a different structure.
const GstMetaInfo* info() {
  static const GstMetaInfo* const registered = []() -> const GstMetaInfo* {
    const GstMetaInfo* known = gst_meta_get_info("GstMetaQuery");
    if (!known)
      known = gst_meta_register(api_type(), "GstMetaQuery", sizeof(QueryMeta), init, nullptr, copy);
    return known && known->api == api_type() && known->size == sizeof(QueryMeta) ? known : nullptr;
  }();
  return registered;
}

QueryMeta* find_meta(GstBuffer* buffer) noexcept {
  GstMeta* meta = info() ? gst_buffer_get_meta(buffer, api_type()) : nullptr;
  return meta && meta->info == info() ? reinterpret_cast<QueryMeta*>(meta) : nullptr;
}

}  // namespace

std::optional<gint64> get_client_id(GstBuffer* buffer) noexcept {
  const QueryMeta* meta = find_meta(buffer);
  return meta ? std::optional(meta->client) : std::nullopt;
}

bool set_client(GstBuffer* buffer, gint64 client) noexcept {
  if (!info()) return false;
  QueryMeta* meta = find_meta(buffer);
  if (!meta) meta = reinterpret_cast<QueryMeta*>(gst_buffer_add_meta(buffer, info(), nullptr));
  if (!meta) return false;
  meta->client = client;
  return true;
}

}  // namespace weir::gst
