// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tensors_data.hpp"

#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

#include "ml_error.hpp"

namespace weir::application {
namespace {

constexpr size_t kAlignment = 64;  // of each tensor, for engines that require it

struct DeleteAligned {
  void operator()(std::byte* memory) const noexcept {
    ::operator delete (memory, std::align_val_t{kAlignment});
  }
};

}  // namespace

std::shared_ptr<TensorsData> TensorsData::create(TensorSpecs tensors) {
  std::vector<size_t> offsets;
  size_t total = 0;
  for (const auto& tensor : tensors) {
    offsets.push_back(total);
    total += (*tensor.bytes() + kAlignment - 1) / kAlignment * kAlignment;
  }
  std::shared_ptr<std::byte> block(
      static_cast<std::byte*>(::operator new (total, std::align_val_t{kAlignment}, std::nothrow)),
      DeleteAligned());
  if (!block) throw std::bad_alloc();
  std::memset(block.get(), 0, total);
  std::vector<std::span<std::byte>> memory;
  for (size_t i = 0; i < tensors.size(); ++i)
    memory.emplace_back(block.get() + offsets[i], *tensors[i].bytes());
  return std::make_shared<TensorsData>(std::move(tensors), std::move(memory), std::move(block),
                                       Access::ReadWrite);
}

std::vector<weir_tensor> TensorsData::c_tensors() const {
  std::vector<weir_tensor> out;
  for (size_t i = 0; i < tensors_.size(); ++i) {
    weir_tensor tensor{};
    tensor.data = memory_[i].data();
    tensor.bytes = tensor.capacity = memory_[i].size();
    tensor.flags = writable() ? 0 : WEIR_TENSOR_READONLY;
    tensor.fence_fd = -1;
    tensor.info = c_info(tensors_[i]);
    out.push_back(tensor);
  }
  return out;
}

std::shared_ptr<TensorsData> make_data(std::span<const weir_tensor> tensors,
                                       std::shared_ptr<const void> owner,
                                       TensorsData::Access access) {
  TensorSpecs specs;
  std::vector<std::span<std::byte>> memory;
  for (const auto& tensor : tensors) {
    specs.push_back(to_spec(tensor.info));
    memory.emplace_back(static_cast<std::byte*>(tensor.data), tensor.bytes);
  }
  return std::make_shared<TensorsData>(std::move(specs), std::move(memory), std::move(owner),
                                       access);
}

}  // namespace weir::application

namespace {

using namespace weir;
using namespace weir::application;

Result<std::shared_ptr<TensorsData>> find(void* data, unsigned index) {
  auto found = Handles::all().find<TensorsData>(data, "data");
  if (found && index >= (*found)->tensors().size())
    return no_such_tensor(std::to_string(index), (*found)->tensors().size());
  return found;
}

}  // namespace

int ml_tensors_data_create(const ml_tensors_info_h info, ml_tensors_data_h* data) {
  return guarded([&] {
    if (!data) return fail(null_pointer("data"));
    if (!info) return fail(null_pointer("info"));
    auto tensors = tensors_or_none(info, "info");
    if (!tensors) return fail(tensors.error());
    *data = Handles::all().add(TensorsData::create(*std::move(tensors)));
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_tensors_data_destroy(ml_tensors_data_h data) {
  return guarded([&] {
    const auto taken = Handles::all().take<TensorsData>(data, "data");
    return taken ? static_cast<int>(ML_ERROR_NONE) : fail(taken.error());
  });
}

int ml_tensors_data_clone(const ml_tensors_data_h in, ml_tensors_data_h* out) {
  return guarded([&] {
    if (!out) return fail(null_pointer("out"));
    const auto from = Handles::all().find<TensorsData>(in, "in");
    if (!from) return fail(from.error());
    auto copy = TensorsData::create((*from)->tensors());
    for (size_t i = 0; i < copy->memory().size(); ++i) {
      const auto bytes = (*from)->memory()[i], to = copy->memory()[i];
      std::memcpy(to.data(), bytes.data(), std::min(to.size(), bytes.size()));
    }
    *out = Handles::all().add(std::move(copy));
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_tensors_data_get_info(const ml_tensors_data_h data, ml_tensors_info_h* info) {
  return guarded([&] {
    if (!info) return fail(null_pointer("info"));
    const auto found = Handles::all().find<TensorsData>(data, "data");
    if (!found) return fail(found.error());
    *info = new_info((*found)->tensors());
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_tensors_data_get_tensor_data(ml_tensors_data_h data, unsigned int index, void** raw_data,
                                    size_t* data_size) {
  return guarded([&] {
    if (!raw_data || !data_size) return fail(null_pointer("raw_data or data_size"));
    const auto found = find(data, index);
    if (!found) return fail(found.error());
    const auto memory = (*found)->memory()[index];
    *raw_data = memory.data();
    *data_size = memory.size();
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_tensors_data_set_tensor_data(ml_tensors_data_h data, unsigned int index,
                                    const void* raw_data, size_t data_size) {
  return guarded([&] {
    if (!raw_data) return fail(null_pointer("raw_data"));
    const auto found = find(data, index);
    if (!found) return fail(found.error());
    const auto memory = (*found)->memory()[index];
    if (data_size < 1 || data_size > memory.size())
      return fail(Error{.code = Code::FRAME_SIZE,
                        .what = "data_size is out of range for tensor " + std::to_string(index),
                        .offered = std::to_string(data_size) + " bytes",
                        .needed = "1 to " + std::to_string(memory.size()) +
                                  " bytes: " + describe({(*found)->tensors()[index]})});
    if (!(*found)->writable())
      return fail(Refusal{ML_ERROR_PERMISSION_DENIED,
                          {.code = Code::OPTION_VALUE,
                           .what = "this data is read-only",
                           .offered = "outputs of a model, or a frame passed to a callback",
                           .needed = "data created with ml_tensors_data_create()",
                           .fix = "ml_tensors_data_create(info, &data)"}});
    std::memcpy(memory.data(), raw_data, data_size);
    return static_cast<int>(ML_ERROR_NONE);
  });
}
