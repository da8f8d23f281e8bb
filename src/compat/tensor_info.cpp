// Functions for the description of one tensor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>

#include "compat/guard.hpp"
#include "compat/spec.hpp"
#include "nnstreamer_plugin_api_util.h"

using namespace weir::compat;

void gst_tensor_info_init(GstTensorInfo* info) {
  if (!given(__func__, {info})) return;
  *info = GstTensorInfo{};
  info->type = _NNS_END;
}

void gst_tensor_info_free(GstTensorInfo* info) {
  if (!given(__func__, {info})) return;
  g_free(info->name);
  gst_tensor_info_init(info);
}

gboolean gst_tensor_info_validate(const GstTensorInfo* info) {
  return given(__func__, {info}) && element_type(info->type) != weir::ElementType::End &&
         to_shape(info->dimension).valid();
}

gsize gst_tensor_info_get_size(const GstTensorInfo* info) {
  if (!given(__func__, {info})) return 0;
  return weir::TensorSpec{element_type(info->type), to_shape(info->dimension), {}}.bytes().value_or(
      0);
}

guint gst_tensor_info_get_rank(const GstTensorInfo* info) {
  return given(__func__, {info}) ? gst_tensor_dimension_get_rank(info->dimension) : 0;
}

gboolean gst_tensor_info_is_equal(const GstTensorInfo* a, const GstTensorInfo* b) {
  return given(__func__, {a, b}) && gst_tensor_info_validate(a) && gst_tensor_info_validate(b) &&
         a->type == b->type && to_shape(a->dimension) == to_shape(b->dimension);
}

void gst_tensor_info_copy(GstTensorInfo* to, const GstTensorInfo* from) {
  gst_tensor_info_copy_n(to, from, NNS_TENSOR_RANK_LIMIT);
}

void gst_tensor_info_copy_n(GstTensorInfo* to, const GstTensorInfo* from, const guint n) {
  if (!given(__func__, {to, from})) return;
  *to = *from;
  to->name = g_strdup(from->name);
  std::fill(to->dimension + std::min<guint>(n, NNS_TENSOR_RANK_LIMIT), std::end(to->dimension), 0);
}
