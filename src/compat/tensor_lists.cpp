// Converts descriptions of several tensors to text and back.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>

#include "compat/guard.hpp"
#include "compat/spec.hpp"
#include "core/text/text.hpp"
#include "nnstreamer_plugin_api_util.h"
#include "weir/join.hpp"

using namespace weir::compat;

namespace {

using weir::Result;

// Applies the entries of a list to tensors; logs a warning for more than the limit.
template <class Put>
guint fill(const char* function, GstTensorsInfo* info, const gchar* text, const char* separators,
           Put put) {
  if (!given(function, {info, text})) return 0;
  return or_else<guint>(function, 0, [&]() -> guint {
    const auto parts = weir::split(text, separators);
    if (parts.size() == 1 && weir::strip(parts[0]).empty()) return 0;
    if (parts.size() > NNS_TENSOR_SIZE_LIMIT)
      warn(function, "the list contains " + std::to_string(parts.size()) +
                         " tensors; only the first 256 are used");
    const size_t count = std::min<size_t>(parts.size(), NNS_TENSOR_SIZE_LIMIT);
    for (size_t i = 0; i < count; ++i) put(weir::strip(parts[i]), room_at(*info, i));
    return static_cast<guint>(count);
  });
}

gchar* joined(const char* function, const GstTensorsInfo* info,
              std::string (*join)(const std::vector<weir::TensorSpec>&)) {
  if (!given(function, {info}) || info->num_tensors == 0) return nullptr;
  return or_else<gchar*>(function, nullptr, [&] { return text(join(to_spec(*info).tensors)); });
}

}  // namespace

guint gst_tensors_info_parse_dimensions_string(GstTensorsInfo* info, const gchar* text) {
  return fill(__func__, info, text, ",.", [](std::string_view part, GstTensorInfo* to) {
    const auto shape = parse_shape(part);
    std::copy(shape.dims().begin(), shape.dims().end(), to->dimension);
  });
}

guint gst_tensors_info_parse_types_string(GstTensorsInfo* info, const gchar* text) {
  return fill(__func__, info, text, ",.", [](std::string_view part, GstTensorInfo* to) {
    to->type = static_cast<tensor_type>(weir::parse_element_type(part));
  });
}

guint gst_tensors_info_parse_names_string(GstTensorsInfo* info, const gchar* text) {
  return fill(__func__, info, text, ",", [](std::string_view part, GstTensorInfo* to) {
    g_free(to->name);
    to->name = part.empty() ? nullptr : g_strndup(part.data(), part.size());
  });
}

gchar* gst_tensors_info_get_dimensions_string(const GstTensorsInfo* info) {
  return joined(__func__, info, [](const auto& tensors) { return weir::join_shapes(tensors); });
}
gchar* gst_tensors_info_get_rank_dimensions_string(const GstTensorsInfo* info, const unsigned rank,
                                                   gboolean padding) {
  if (!given(__func__, {info}) || info->num_tensors == 0) return nullptr;
  return or_else<gchar*>(__func__, nullptr, [&] {
    const std::string out = join(to_spec(*info).tensors, ",", [&](const auto& tensor) {
      return rank_text(tensor.shape, rank, padding);
    });
    return text(out);
  });
}
gchar* gst_tensors_info_get_types_string(const GstTensorsInfo* info) {
  return joined(__func__, info, weir::join_types);
}
gchar* gst_tensors_info_get_names_string(const GstTensorsInfo* info) {
  return joined(__func__, info, weir::join_names);
}
