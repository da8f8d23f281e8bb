// Makes the shapes and data with which a model is measured.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "inspect/synthetic_inputs.hpp"

#include <type_traits>

#include "core/tensor/frame_spec.hpp"
#include "inspect/launch_line.hpp"
#include "report.hpp"
#include "weir/join.hpp"
#include "weir/module.hpp"

namespace weir::app {
namespace {

void set_shape(const Shape& shape, weir_tensor_info* info) {
  if (info->rank == WEIR_RANK_UNKNOWN) {
    info->rank = static_cast<uint32_t>(shape.rank());
    std::fill_n(info->shape, info->rank, -1);
  }
  for (uint32_t i = 0; i < info->rank; ++i) {
    int64_t& extent = info->shape[info->rank - 1 - i];
    if (extent < 0) extent = std::max<int64_t>(shape[i], 1);
  }
}

template <class T>
void fill(void* data, uint64_t bytes, std::mt19937& random) {
  auto* values = static_cast<T*>(data);
  for (uint64_t i = 0; i < bytes / sizeof(T); ++i) {
    if constexpr (std::is_floating_point_v<T>)
      values[i] = std::uniform_real_distribution<T>(0, 1)(random);
    else  // integers wider than a byte may be indices
      values[i] = static_cast<T>(random() % (sizeof(T) == 1 ? 256 : 2));
  }
}

}  // namespace

Result<std::vector<weir_tensor_info>> inputs_of_frame(std::vector<weir_tensor_info> model,
                                                      const TensorOptions& tensors) {
  auto shapes = tensors.input.empty() ? std::vector<Shape>{} : parse_shape_list(tensors.input);
  if (!shapes) return shapes.error();
  auto types =
      tensors.inputtype.empty() ? std::vector<ElementType>{} : parse_type_list(tensors.inputtype);
  if (!types) return types.error();
  if (model.empty()) {
    weir_tensor_info open{};
    open.type = WEIR_TYPE_END;
    open.rank = WEIR_RANK_UNKNOWN;
    open.batch_axis = WEIR_NO_BATCH_AXIS;
    model.assign(shapes->size(), open);
  }
  if (model.empty())
    return Error{
        .code = Code::SPEC_MISMATCH,
        .what = "the model takes its input sizes from a stream, and weir inspect has no stream",
        .offered = "no --input",
        .needed = "the dimensions and types of its inputs",
        .fix = "--input 3:224:224:1 --inputtype uint8"};
  for (size_t i = 0; i < model.size(); ++i) {
    if (i < shapes->size()) set_shape((*shapes)[i], &model[i]);
    if (i < types->size() && model[i].type >= WEIR_TYPE_END)
      model[i].type = static_cast<uint32_t>((*types)[i]);
  }
  return chosen_inputs(std::move(model));
}

std::string property_text(const TensorOptions& tensors) {
  return join(tensors.pairs(), " ",
              [](const auto& pair) { return pair.first + "=" + launch_value(pair.second); });
}

uint64_t count_bytes(const weir_tensor_info& info) {
  uint64_t bytes = element_bytes(info.type);
  for (uint32_t i = 0; i < info.rank; ++i) bytes *= static_cast<uint64_t>(info.shape[i]);
  return bytes;
}

void fill_with_random_data(const weir_tensor_info& info, void* data, std::mt19937& random) {
  const uint64_t bytes = count_bytes(info);
  switch (info.type) {
    case WEIR_FLOAT32:
      return fill<float>(data, bytes, random);
    case WEIR_FLOAT64:
      return fill<double>(data, bytes, random);
    case WEIR_FLOAT16:  // fills half of the elements with 1.0
      fill<uint16_t>(data, bytes, random);
      for (uint64_t i = 0; i < bytes / 2; ++i) static_cast<uint16_t*>(data)[i] *= 0x3C00;
      return;
    default:
      break;
  }
  switch (element_bytes(info.type)) {
    case 1:
      return fill<uint8_t>(data, bytes, random);
    case 2:
      return fill<uint16_t>(data, bytes, random);
    case 4:
      return fill<uint32_t>(data, bytes, random);
    default:
      return fill<uint64_t>(data, bytes, random);
  }
}

}  // namespace weir::app
