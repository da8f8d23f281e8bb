// A pool without free buffers: a buffer released to it drops its memories first and then its
// owners.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/sharing_buffer.hpp"

#include <algorithm>
#include <vector>

namespace weir::gst {
namespace {

using Owners = std::vector<Ref<GstBuffer>>;

GQuark owners_quark() {
  static const GQuark quark = g_quark_from_static_string("weir-owners-of-memories");
  return quark;
}

GstFlowReturn acquire_buffer(GstBufferPool*, GstBuffer** out, GstBufferPoolAcquireParams*) {
  *out = gst_buffer_new();
  return GST_FLOW_OK;
}
void reset_buffer(GstBufferPool*, GstBuffer*) {}
void release_buffer(GstBufferPool*, GstBuffer* buffer) {
  gst_buffer_remove_all_memory(buffer);
  gst_buffer_unref(buffer);
}
gboolean start_or_stop(GstBufferPool*) {
  return TRUE;
}

void buffer_class_init(gpointer k, gpointer) {
  auto* pool_class = static_cast<GstBufferPoolClass*>(k);
  pool_class->acquire_buffer = acquire_buffer;
  pool_class->reset_buffer = reset_buffer;
  pool_class->release_buffer = release_buffer;
  pool_class->start = start_or_stop;
  pool_class->stop = start_or_stop;
}

// One for the process; it has no state and is never freed.
GstBufferPool* pool() {
  static GstBufferPool* const made = [] {
    const GType type = g_type_register_static_simple(GST_TYPE_BUFFER_POOL, "WeirSharingPool",
                                                     sizeof(GstBufferPoolClass), buffer_class_init,
                                                     sizeof(GstBufferPool), nullptr, GTypeFlags(0));
    auto* pool = static_cast<GstBufferPool*>(gst_object_ref_sink(g_object_new(type, nullptr)));
    GST_OBJECT_FLAG_SET(pool, GST_OBJECT_FLAG_MAY_BE_LEAKED);
    GstStructure* config = gst_buffer_pool_get_config(pool);
    gst_buffer_pool_config_set_params(config, nullptr, 0, 0, 0);
    gst_buffer_pool_set_config(pool, config);
    gst_buffer_pool_set_active(pool, TRUE);
    return pool;
  }();
  return made;
}

}  // namespace

Ref<GstBuffer> sharing_buffer(std::span<GstBuffer* const> owners) {
  const auto pooled = [](GstBuffer* owner) { return owner->pool != nullptr; };
  GstBuffer* out = nullptr;
  if (std::none_of(owners.begin(), owners.end(), pooled) ||
      gst_buffer_pool_acquire_buffer(pool(), &out, nullptr) != GST_FLOW_OK)
    return Ref<GstBuffer>::adopt(gst_buffer_new());
  auto held = std::make_unique<Owners>();
  for (GstBuffer* owner : owners)
    if (pooled(owner)) held->push_back(Ref<GstBuffer>::share(owner));
  gst_mini_object_set_qdata(GST_MINI_OBJECT_CAST(out), owners_quark(), held.release(),
                            [](gpointer data) { delete static_cast<Owners*>(data); });
  return Ref<GstBuffer>::adopt(out);
}

}  // namespace weir::gst
