// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/batch/batch_group.hpp"

namespace weir::infer {
namespace {

std::string make_key(size_t batch_size, const std::vector<weir_tensor_info>& frame) {
  std::string out = std::to_string(batch_size);
  for (const auto& info : frame) {
    out += ';' + std::to_string(info.type);
    for (uint32_t i = 0; i < info.rank; ++i) out += ',' + std::to_string(info.shape[i]);
  }
  return out;
}

}  // namespace

Result<std::shared_ptr<BatchGroup>> BatchGroups::find(size_t batch_size,
                                                      const std::vector<weir_tensor_info>& frame,
                                                      const Make& make) {
  std::lock_guard lock(mutex_);
  std::erase_if(groups_, [](const auto& entry) { return entry.second.expired(); });
  auto& slot = groups_[make_key(batch_size, frame)];
  if (auto there = slot.lock()) return there;
  auto made = make();
  if (made) slot = *made;
  return made;
}

}  // namespace weir::infer
