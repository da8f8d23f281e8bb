// ModelTable: the models that filters of this process share by a key.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "core/infer/shared_model.hpp"

namespace weir::infer {

// Thread-safe. A model stays in the table as long as somebody holds it.
class ModelTable {
 public:
  static ModelTable& instance();
  ModelTable() = default;  // a separate one, for tests

  struct Found {
    std::shared_ptr<SharedModel> model;
    std::optional<Error> not_shared;  // MODEL_DIFFERS: `model` is one for the caller alone
  };
  // The model under this key where its source is the same; else one of the caller's own. With
  // key "" always one of its own. Nothing is opened here: ModelUse::create does.
  Found find(const std::string& key, const ModelSource& source);

 private:
  std::mutex mutex_;  // guards models_
  std::map<std::string, std::weak_ptr<SharedModel>> models_;
};

}  // namespace weir::infer
