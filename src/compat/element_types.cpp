// Converts element types and dimensions between text and numbers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <array>
#include <string>

#include "compat/guard.hpp"
#include "compat/spec.hpp"
#include "core/text/text.hpp"
#include "nnstreamer_plugin_api_util.h"

using namespace weir::compat;

tensor_type gst_tensor_get_type(const gchar* text) {
  if (!given(__func__, {text})) return _NNS_END;
  return static_cast<tensor_type>(weir::parse_element_type(text));
}

const gchar* gst_tensor_get_type_string(tensor_type type) {
  static const auto names = [] {
    std::array<std::string, _NNS_END> all;
    for (int i = 0; i < _NNS_END; ++i)
      all[static_cast<size_t>(i)] = weir::to_string(element_type(i));
    return all;
  }();
  const auto known = element_type(type);
  return known == weir::ElementType::End ? nullptr : names[static_cast<size_t>(type)].c_str();
}

gsize gst_tensor_get_element_size(tensor_type type) {
  return weir::element_size(element_type(type));
}

tensor_format gst_tensor_get_format(const gchar* text) {
  if (!given(__func__, {text})) return _NNS_TENSOR_FORMAT_END;
  return static_cast<tensor_format>(weir::parse_format(text));
}

const gchar* gst_tensor_get_format_string(tensor_format format) {
  static constexpr const gchar* kNames[] = {"static", "flexible", "sparse"};
  return format >= 0 && format < _NNS_TENSOR_FORMAT_END ? kNames[format] : nullptr;
}

guint gst_tensor_parse_dimension(const gchar* text, tensor_dim dim) {
  if (!given(__func__, {dim})) return 0;
  std::fill_n(dim, NNS_TENSOR_RANK_LIMIT, 0);
  if (!given(__func__, {text})) return 0;
  const auto shape = or_else(__func__, weir::Shape(), [&] { return parse_shape(text); });
  std::copy(shape.dims().begin(), shape.dims().end(), dim);
  return static_cast<guint>(shape.rank());
}

gchar* gst_tensor_get_dimension_string(const tensor_dim dim) {
  if (!given(__func__, {dim})) return nullptr;
  return or_else<gchar*>(__func__, nullptr, [&] { return text(to_shape(dim).to_string()); });
}

gchar* gst_tensor_get_rank_dimension_string(const tensor_dim dim, const unsigned rank,
                                            gboolean padding) {
  if (!given(__func__, {dim})) return nullptr;
  return or_else<gchar*>(__func__, nullptr,
                         [&] { return text(rank_text(to_shape(dim), rank, padding)); });
}

guint gst_tensor_dimension_get_min_rank(const tensor_dim dim) {
  if (!given(__func__, {dim}) || !to_shape(dim).valid()) return 0;
  return static_cast<guint>(to_shape(dim).min_rank());
}

gboolean gst_tensor_dimension_string_is_equal(const gchar* a, const gchar* b) {
  if (!given(__func__, {a, b})) return FALSE;
  return or_else(__func__, FALSE, [&]() -> gboolean {
    const auto left = weir::split(a, ",."), right = weir::split(b, ",.");
    return std::equal(left.begin(), left.end(), right.begin(), right.end(),
                      [](std::string_view one, std::string_view other) {
                        return parse_shape(one) == parse_shape(other);
                      });
  });
}

guint gst_tensor_dimension_get_rank(const tensor_dim dim) {
  return given(__func__, {dim}) ? static_cast<guint>(to_shape(dim).rank()) : 0;
}

gboolean gst_tensor_dimension_is_valid(const tensor_dim dim) {
  return given(__func__, {dim}) && to_shape(dim).valid();
}

gboolean gst_tensor_dimension_is_equal(const tensor_dim a, const tensor_dim b) {
  return given(__func__, {a, b}) && to_shape(a) == to_shape(b);
}

guint64 gst_tensor_get_element_count(const tensor_dim dim) {
  return given(__func__, {dim}) ? to_shape(dim).count().value_or(0) : 0;
}
