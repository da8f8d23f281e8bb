// ml_tensors_info_*.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <span>
#include <utility>

#include "ml_error.hpp"
#include "tensors_info.hpp"
#include "weir/join.hpp"

namespace {

using namespace weir;
using namespace weir::application;

Result<std::shared_ptr<TensorsInfo>> find(void* info, const char* what = "info") {
  return Handles::all().find<TensorsInfo>(info, what);
}

// Runs `body` with tensor `index` of `info`.
template <class Body>
int with(void* info, size_t index, Body&& body) {
  const auto found = find(info);
  return found ? to_ml_error((*found)->with(index, body)) : fail(found.error());
}

Error bad_type(int type) {
  return Error{.code = Code::TYPE_SYNTAX,
               .what = "type is not a tensor type",
               .offered = std::to_string(type),
               .needed = "ML_TENSOR_TYPE_INT32 to ML_TENSOR_TYPE_FLOAT16"};
}

// A plain info ignores entries that programs for four dimensions do not set.
Result<Shape> to_shape(const unsigned* dimension, TensorsInfo::Reads reads) {
  const std::span<const uint32_t> entries(dimension, reads == TensorsInfo::Reads::AllDimensions
                                                         ? ML_TENSOR_RANK_LIMIT
                                                         : TensorsInfo::kPlainRank);
  const Shape shape(entries);
  if (shape.valid()) return shape;
  return Error{
      .code = Code::DIMENSION_SYNTAX,
      .what = "dimension is not a valid tensor dimension",
      .offered = join(entries, ":", [](unsigned extent) { return std::to_string(extent); }),
      .needed = "one or more non-zero entries, followed by zeros only",
      .fix = "ml_tensor_dimension dimension = {3, 224, 224};"};
}

int create(ml_tensors_info_h* info, TensorsInfo::Reads reads) {
  return guarded([&] {
    if (!info) return fail(null_pointer("info"));
    *info = Handles::all().add(std::make_shared<TensorsInfo>(reads));
    return static_cast<int>(ML_ERROR_NONE);
  });
}

}  // namespace

int ml_tensors_info_create(ml_tensors_info_h* info) {
  return create(info, TensorsInfo::Reads::FourDimensions);
}

int ml_tensors_info_create_extended(ml_tensors_info_h* info) {
  return create(info, TensorsInfo::Reads::AllDimensions);
}

int ml_tensors_info_destroy(ml_tensors_info_h info) {
  return guarded([&] {
    const auto taken = Handles::all().take<TensorsInfo>(info, "info");
    return taken ? static_cast<int>(ML_ERROR_NONE) : fail(taken.error());
  });
}

int ml_tensors_info_validate(const ml_tensors_info_h info, bool* valid) {
  return guarded([&] {
    if (!valid) return fail(null_pointer("valid"));
    const auto found = find(info);
    if (!found) return fail(found.error());
    *valid = static_cast<bool>(check_complete((*found)->tensors(), "info"));
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_tensors_info_clone(ml_tensors_info_h dest, const ml_tensors_info_h src) {
  return guarded([&] {
    const auto to = find(dest, "dest"), from = find(src, "src");
    if (!to) return fail(to.error());
    if (!from) return fail(from.error());
    auto tensors = (*from)->tensors();
    if (auto status = check_complete(tensors, "src"); !status) return fail(status.error());
    (*to)->set(std::move(tensors), (*from)->reads());
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_tensors_info_set_count(ml_tensors_info_h info, unsigned int count) {
  return guarded([&] {
    const auto found = find(info);
    if (!found) return fail(found.error());
    if (count < 1 || count > kTensorLimit)
      return fail(Error{.code = Code::LIMIT_EXCEEDED,
                        .what = "count is out of range",
                        .offered = std::to_string(count),
                        .needed = "1 to 256, the number of tensors in a frame"});
    (*found)->set_count(count);
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_tensors_info_get_count(ml_tensors_info_h info, unsigned int* count) {
  return guarded([&] {
    if (!count) return fail(null_pointer("count"));
    const auto found = find(info);
    if (!found) return fail(found.error());
    *count = static_cast<unsigned>((*found)->tensors().size());
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_tensors_info_set_tensor_name(ml_tensors_info_h info, unsigned int index, const char* name) {
  return guarded(
      [&] { return with(info, index, [&](TensorSpec& t) { t.name = name ? name : ""; }); });
}

int ml_tensors_info_get_tensor_name(ml_tensors_info_h info, unsigned int index, char** name) {
  return guarded([&] {
    if (!name) return fail(null_pointer("name"));
    return with(info, index, [&](const TensorSpec& t) {
      char* copy = t.name.empty() ? nullptr : strdup(t.name.c_str());
      if (!copy && !t.name.empty()) throw std::bad_alloc();
      *name = copy;
    });
  });
}

int ml_tensors_info_set_tensor_type(ml_tensors_info_h info, unsigned int index,
                                    ml_tensor_type_e type) {
  return guarded([&] {
    const auto number = static_cast<unsigned>(type);
    if (number >= ML_TENSOR_TYPE_UNKNOWN) return fail(bad_type(static_cast<int>(type)));
    return with(info, index, [&](TensorSpec& t) { t.type = static_cast<ElementType>(number); });
  });
}

int ml_tensors_info_get_tensor_type(ml_tensors_info_h info, unsigned int index,
                                    ml_tensor_type_e* type) {
  return guarded([&] {
    if (!type) return fail(null_pointer("type"));
    return with(info, index,
                [&](const TensorSpec& t) { *type = static_cast<ml_tensor_type_e>(t.type); });
  });
}

int ml_tensors_info_set_tensor_dimension(ml_tensors_info_h info, unsigned int index,
                                         const ml_tensor_dimension dimension) {
  return guarded([&] {
    if (!dimension) return fail(null_pointer("dimension"));
    const auto found = find(info);
    if (!found) return fail(found.error());
    const auto shape = to_shape(dimension, (*found)->reads());
    if (!shape) return fail(shape.error());
    return with(info, index, [&](TensorSpec& t) { t.shape = *shape; });
  });
}

int ml_tensors_info_get_tensor_dimension(ml_tensors_info_h info, unsigned int index,
                                         ml_tensor_dimension dimension) {
  return guarded([&] {
    if (!dimension) return fail(null_pointer("dimension"));
    return with(info, index, [&](const TensorSpec& t) {
      std::copy(t.shape.dims().begin(), t.shape.dims().end(), dimension);
    });
  });
}

int ml_tensors_info_get_tensor_size(ml_tensors_info_h info, int index, size_t* data_size) {
  return guarded([&] {
    if (!data_size) return fail(null_pointer("data_size"));
    const auto found = find(info);
    if (!found) return fail(found.error());
    auto tensors = (*found)->tensors();
    const auto at = static_cast<size_t>(index);
    if (index >= 0 && at >= tensors.size())
      return fail(no_such_tensor(std::to_string(index), tensors.size()));
    if (index >= 0) tensors = {tensors[at]};
    std::erase_if(tensors, [](const TensorSpec& tensor) { return !tensor.valid(); });
    if (!tensors.empty())
      if (auto status = check_complete(tensors, "info"); !status) return fail(status.error());
    size_t sum = 0;
    for (const auto& tensor : tensors) sum += *tensor.bytes();
    *data_size = sum;
    return static_cast<int>(ML_ERROR_NONE);
  });
}
