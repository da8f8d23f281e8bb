// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/model/model_table.hpp"

#include "core/process/process_object.hpp"

namespace weir::infer {

ModelTable& ModelTable::instance() {
  static auto& table = process::object<ModelTable>("model-table");
  return table;
}

ModelTable::Found ModelTable::find(const std::string& key, const ModelConfig& source) {
  if (key.empty()) return {std::make_shared<SharedModel>("", source), std::nullopt};
  std::lock_guard lock(mutex_);
  std::erase_if(models_, [](const auto& entry) { return entry.second.expired(); });
  if (const auto there = models_[key].lock()) {
    const ModelConfig present = there->source();
    if (present.same_as(source)) return {there, std::nullopt};
    return {std::make_shared<SharedModel>("", source),
            Error{.code = Code::MODEL_DIFFERS,
                  .what = "the model with this key is a different one and is not shared",
                  .offered = source.to_string(),
                  .needed = "shared-tensor-filter-key=" + key + ": " + present.to_string(),
                  .fix = "another shared-tensor-filter-key, or the same model"}};
  }
  auto made = std::make_shared<SharedModel>(key, source);
  models_[key] = made;
  return {made, std::nullopt};
}

}  // namespace weir::infer
