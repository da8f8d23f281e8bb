// Functions for the tensors of a frame and for stream configurations.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "compat/guard.hpp"
#include "compat/spec.hpp"
#include "nnstreamer_plugin_api_util.h"

using namespace weir::compat;

void gst_tensors_info_init(GstTensorsInfo* info) {
  if (!given(__func__, {info})) return;
  *info = GstTensorsInfo{};
  for (auto& tensor : info->info) gst_tensor_info_init(&tensor);
}

void gst_tensors_info_free(GstTensorsInfo* info) {
  if (!given(__func__, {info})) return;
  for (size_t i = 0; i < NNS_TENSOR_SIZE_LIMIT; ++i)
    if (auto* tensor = tensor_at(*info, i)) g_free(tensor->name);
  g_free(info->extra);
  gst_tensors_info_init(info);
}

GstTensorInfo* gst_tensors_info_get_nth_info(GstTensorsInfo* info, guint index) {
  return given(__func__, {info}) ? room_at(*info, index) : nullptr;
}

gboolean gst_tensors_info_validate(const GstTensorsInfo* info) {
  if (!given(__func__, {info}) || info->num_tensors > NNS_TENSOR_SIZE_LIMIT) return FALSE;
  return or_else(__func__, FALSE, [&]() -> gboolean { return to_spec(*info).info_valid(); });
}

gsize gst_tensors_info_get_size(const GstTensorsInfo* info, gint index) {
  if (!given(__func__, {info})) return 0;
  if (index < 0)
    return or_else<gsize>(__func__, 0, [&] { return to_spec(*info).bytes().value_or(0); });
  const auto* tensor =
      static_cast<guint>(index) < info->num_tensors ? tensor_at(*info, index) : nullptr;
  return tensor ? gst_tensor_info_get_size(tensor) : 0;
}

gboolean gst_tensors_info_is_equal(const GstTensorsInfo* a, const GstTensorsInfo* b) {
  if (!given(__func__, {a, b}) || !gst_tensors_info_validate(a) || !gst_tensors_info_validate(b))
    return FALSE;
  return or_else(__func__, FALSE, [&]() -> gboolean {
    auto left = to_spec(*a), right = to_spec(*b);
    left.rate = right.rate = {0, 1};
    return left == right;
  });
}

void gst_tensors_info_copy(GstTensorsInfo* to, const GstTensorsInfo* from) {
  if (!given(__func__, {to, from})) return;
  gst_tensors_info_init(to);
  to->num_tensors = from->num_tensors;
  to->format = from->format;
  for (size_t i = 0; i < NNS_TENSOR_SIZE_LIMIT && i < from->num_tensors; ++i)
    if (const auto* tensor = tensor_at(*from, i)) gst_tensor_info_copy(room_at(*to, i), tensor);
}

void gst_tensors_config_init(GstTensorsConfig* config) {
  if (!given(__func__, {config})) return;
  gst_tensors_info_init(&config->info);
  config->rate_n = config->rate_d = -1;
}

void gst_tensors_config_free(GstTensorsConfig* config) {
  if (!given(__func__, {config})) return;
  gst_tensors_info_free(&config->info);
  config->rate_n = config->rate_d = -1;
}

gboolean gst_tensors_config_validate(const GstTensorsConfig* config) {
  return given(__func__, {config}) && config->rate_n >= 0 && config->rate_d > 0 &&
         gst_tensors_info_validate(&config->info);
}

gboolean gst_tensors_config_is_equal(const GstTensorsConfig* a, const GstTensorsConfig* b) {
  if (!given(__func__, {a, b}) || !gst_tensors_config_validate(a) ||
      !gst_tensors_config_validate(b))
    return FALSE;
  return or_else(__func__, FALSE, [&]() -> gboolean { return to_spec(*a) == to_spec(*b); });
}

void gst_tensors_config_copy(GstTensorsConfig* to, const GstTensorsConfig* from) {
  if (!given(__func__, {to, from})) return;
  gst_tensors_info_copy(&to->info, &from->info);
  to->rate_n = from->rate_n;
  to->rate_d = from->rate_d;
}
