// Descriptions of tensors and streams as readable text.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <string>

#include "compat/guard.hpp"
#include "compat/spec.hpp"
#include "nnstreamer_plugin_api_util.h"

using namespace weir::compat;

namespace {

// Returns for example "'out' uint8 (3:224:224)".
std::string to_string(const GstTensorInfo& info) {
  const std::string name = info.name && *info.name ? "'" + std::string(info.name) + "' " : "";
  const auto* type = gst_tensor_get_type_string(info.type);
  return name + (type ? type : "(null)") + " (" + to_shape(info.dimension).to_string() + ")";
}

size_t count_tensors(const GstTensorsInfo& info) {
  return std::min<size_t>(info.num_tensors, NNS_TENSOR_SIZE_LIMIT);
}

// Returns the text of a tensor, also without the memory that it would be in.
std::string text_at(const GstTensorsInfo& info, size_t index) {
  const auto* tensor = tensor_at(info, index);
  return tensor ? to_string(*tensor) : "(null) ()";
}

// Returns for example "Format = static, Num_Tensors = 1, Tensors = [{ uint8 (3:4) }]". Programs
// compare this text, also that of too many tensors.
std::string to_string(const GstTensorsInfo& info) {
  const auto* format = gst_tensor_get_format_string(info.format);
  std::string out = "Format = " + std::string(format ? format : "unknown");
  if (info.format != _NNS_TENSOR_FORMAT_STATIC) return out;
  out += ", Num_Tensors = " + std::to_string(info.num_tensors);
  const bool beyond = info.num_tensors > NNS_TENSOR_SIZE_LIMIT;
  if (beyond) out += " (Num_Tensors out of bound, showing " NNS_TENSOR_SIZE_LIMIT_STR " only.)";
  const size_t count = count_tensors(info);
  for (size_t i = 0; i < count; ++i)
    out += (i ? ", { " : ", Tensors = [{ ") + text_at(info, i) + " }";
  if (count > 0) out += beyond ? ", ]" : "]";
  return out;
}

std::string comparison(const GstTensorsInfo& a, const GstTensorsInfo& b) {
  std::string out;
  for (size_t i = 0; i < std::max(count_tensors(a), count_tensors(b)); ++i) {
    const std::string left = i < count_tensors(a) ? text_at(a, i) : "None";
    const std::string right = i < count_tensors(b) ? text_at(b, i) : "None";
    const std::string index = std::to_string(i);
    out += std::string(3 - index.size(), ' ') + index + " : " + left + " | " + right + " " +
           (left == right ? "" : "Not equal") + "\n";
  }
  return out;
}

}  // namespace

gchar* gst_tensor_info_to_string(const GstTensorInfo* info) {
  if (!given(__func__, {info})) return nullptr;
  return or_else<gchar*>(__func__, nullptr, [&] { return text(to_string(*info)); });
}

gchar* gst_tensors_info_to_string(const GstTensorsInfo* info) {
  if (!given(__func__, {info})) return nullptr;
  return or_else<gchar*>(__func__, nullptr, [&] { return text(to_string(*info)); });
}

gchar* gst_tensors_info_compare_to_string(const GstTensorsInfo* a, const GstTensorsInfo* b) {
  if (!given(__func__, {a, b})) return nullptr;
  return or_else<gchar*>(__func__, nullptr, [&] { return text(comparison(*a, *b)); });
}

gchar* gst_tensors_config_to_string(const GstTensorsConfig* config) {
  if (!given(__func__, {config})) return nullptr;
  return or_else<gchar*>(__func__, nullptr, [&] {
    return text(to_string(config->info) + ", Framerate = " + std::to_string(config->rate_n) + "/" +
                std::to_string(config->rate_d));
  });
}
