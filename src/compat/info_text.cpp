// Descriptions of tensors and streams as readable text.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <string>

#include "compat/guard.hpp"
#include "compat/spec.hpp"
#include "nnstreamer_plugin_api_util.h"

using namespace weir::compat;

namespace {

// Returns for example "out uint8 3:224:224".
std::string to_string(const GstTensorInfo& info) {
  const auto spec = to_spec(info);
  const std::string name = spec.name.empty() ? "" : spec.name + " ";
  if (spec.type == weir::ElementType::End && spec.shape.rank() == 0) return name + "unknown";
  const auto* type = gst_tensor_get_type_string(info.type);
  const auto shape = spec.shape.to_string();
  return name + (type ? type : "unknown type") + " " + (shape.empty() ? "no dimension" : shape);
}

std::string text_at(const GstTensorsInfo& info, size_t index) {
  const auto* tensor = index < info.num_tensors ? tensor_at(info, index) : nullptr;
  return tensor ? to_string(*tensor) : "none";
}

std::string get_format(const GstTensorsInfo& info) {
  const auto* format = gst_tensor_get_format_string(info.format);
  return format ? format : "unknown";
}

size_t count_tensors(const GstTensorsInfo& info) {
  return std::min<size_t>(info.num_tensors, NNS_TENSOR_SIZE_LIMIT);
}

// Returns for example "static, 2 tensors: [0] uint8 3:4, [1] float32 5".
std::string to_string(const GstTensorsInfo& info) {
  const size_t count = count_tensors(info);
  std::string out = get_format(info);
  if (count == 0 && info.format != _NNS_TENSOR_FORMAT_STATIC) return out;
  out += ", " + std::to_string(count) + (count == 1 ? " tensor" : " tensors");
  for (size_t i = 0; i < count; ++i)
    out += (i ? ", [" : ": [") + std::to_string(i) + "] " + text_at(info, i);
  return out;
}

std::string comparison(const GstTensorsInfo& a, const GstTensorsInfo& b) {
  std::string out = "format: " + get_format(a) + " | " + get_format(b) + " | " +
                    (a.format == b.format ? "equal" : "not equal") + "\n";
  out += "tensors: " + std::to_string(a.num_tensors) + " | " + std::to_string(b.num_tensors) +
         " | " + (a.num_tensors == b.num_tensors ? "equal" : "not equal") + "\n";
  for (size_t i = 0; i < std::max(count_tensors(a), count_tensors(b)); ++i) {
    const auto* left = i < count_tensors(a) ? tensor_at(a, i) : nullptr;
    const auto* right = i < count_tensors(b) ? tensor_at(b, i) : nullptr;
    const bool equal = left && right && gst_tensor_info_is_equal(left, right);
    out += "tensor " + std::to_string(i) + ": " + text_at(a, i) + " | " + text_at(b, i) + " | " +
           (equal ? "equal" : "not equal") + "\n";
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
    return text(to_string(config->info) + ", framerate " + std::to_string(config->rate_n) + "/" +
                std::to_string(config->rate_d));
  });
}
