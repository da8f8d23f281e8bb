// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/request_meta.hpp"

#include <new>

#include "gstcpp/buffer/request_expiry.hpp"

namespace weir {
namespace {

using Request = std::shared_ptr<QueryRequest>;

struct RequestMeta {
  gst::RequestMetaHead head;
  Request* request;
};

bool end_if_expired(gst::RequestMetaHead* head) {
  const auto* request = reinterpret_cast<RequestMeta*>(head)->request;
  return request && (*request)->end_if_expired();
}

GType api_type() {
  static const GType type = [] {
    static const gchar* tags[] = {nullptr};
    return gst_meta_api_type_register(gst::kRequestMetaApi, tags);
  }();
  return type;
}

gboolean init(GstMeta* meta, gpointer, GstBuffer*) {
  auto* request = reinterpret_cast<RequestMeta*>(meta);
  request->head.end_if_expired = end_if_expired;
  new (&request->head.may_drop) std::atomic<bool>(false);
  request->request = nullptr;
  return TRUE;
}

void release(GstMeta* meta, GstBuffer*) {
  delete std::exchange(reinterpret_cast<RequestMeta*>(meta)->request, nullptr);
}

gboolean copy(GstBuffer* target, GstMeta* meta, GstBuffer*, GQuark type, gpointer) {
  const auto* source = reinterpret_cast<RequestMeta*>(meta);
  if (!GST_META_TRANSFORM_IS_COPY(type) || !source->request) return FALSE;
  // An element that copies the metadata of several buffers answers the first one's request.
  return get_request(target) || set_request(target, *source->request);
}

const GstMetaInfo* info() {
  static const GstMetaInfo* const registered =
      gst_meta_register(api_type(), "WeirRequestMeta", sizeof(RequestMeta), init, release, copy);
  return registered;
}

}  // namespace

bool set_request(GstBuffer* buffer, std::shared_ptr<QueryRequest> request) {
  auto* meta = reinterpret_cast<RequestMeta*>(gst_buffer_add_meta(buffer, info(), nullptr));
  if (!meta) return false;
  meta->request = new Request(std::move(request));
  return true;
}

std::shared_ptr<QueryRequest> get_request(GstBuffer* buffer) {
  const auto* meta = reinterpret_cast<RequestMeta*>(gst_buffer_get_meta(buffer, api_type()));
  return meta && meta->request ? *meta->request : nullptr;
}

void allow_drop(GstBuffer* buffer, bool allowed) {
  auto* meta = reinterpret_cast<RequestMeta*>(gst_buffer_get_meta(buffer, api_type()));
  if (meta) meta->head.may_drop = allowed;
}

}  // namespace weir
