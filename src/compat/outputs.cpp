// SPDX-License-Identifier: LGPL-2.1-or-later
#include "compat/outputs.hpp"

#include <algorithm>

namespace weir::compat {
namespace {

struct Given {
  std::shared_ptr<OpenFilter> filter;
  GstTensorMemory memory;
  static void release(void* owner) {
    const std::unique_ptr<Given> given(static_cast<Given*>(owner));
    destroy(*given->filter, &given->memory);
  }
};

}  // namespace

uint64_t count_bytes(const weir_tensor_info& info) noexcept {
  uint64_t bytes = element_bytes(info.type);
  for (uint32_t i = 0; i < info.rank && i < WEIR_RANK_LIMIT; ++i)
    bytes *= static_cast<uint64_t>(std::max<int64_t>(info.shape[i], 0));
  return bytes;
}

void give(std::shared_ptr<OpenFilter> filter, GstTensorMemory* memory, const weir_tensor_info& info,
          weir_tensor* out) {
  auto owner = std::make_unique<Given>(Given{std::move(filter), *memory});
  out->info = info;
  out->info.name = nullptr;
  out->data = std::exchange(memory->data, nullptr);
  out->bytes = out->capacity = memory->size;
  out->release = Given::release;
  out->owner = owner.release();
}

void leave_out(weir_tensor* out) noexcept {
  out->info.type = WEIR_TYPE_END;
  out->info.rank = WEIR_RANK_UNKNOWN;
  out->bytes = 0;
}

void destroy(OpenFilter& filter, GstTensorMemory* memory) noexcept {
  void* data = std::exchange(memory->data, nullptr);
  if (!data) return;
  try {
    filter.destroy(data);
  } catch (...) {
    nns_logw("the filter %s threw an exception while it freed an output", filter.name().c_str());
  }
}

Failure broke(const std::string& name, const std::string& what, std::string offered,
              std::string needed, std::string fix) {
  return Failure({.code = Code::CALLBACK_FAILED,
                  .what = "the filter " + name + " " + what,
                  .offered = std::move(offered),
                  .needed = std::move(needed),
                  .fix = std::move(fix)});
}

std::string which(size_t index, const GstTensorMemory& memory) {
  return "output " + std::to_string(index) + ": " +
         (memory.data ? std::to_string(memory.size) + " bytes" : "NULL");
}

Failure too_many(const std::string& name, size_t count, size_t max) {
  return broke(name, "returned more outputs than expected", std::to_string(count),
               "at most " + std::to_string(max),
               "declare " + std::to_string(count) +
                   " tensors with output= and outputtype=; only their number matters");
}

Failure other_size(const std::string& name, size_t index, const GstTensorMemory& memory,
                   const weir_tensor_info& info) {
  return broke(name, "returned an output whose size differs from its description",
               which(index, memory),
               std::to_string(count_bytes(info)) + " bytes: " + weir::describe(info),
               "set output[].data and output[].size to match output_meta");
}

}  // namespace weir::compat
