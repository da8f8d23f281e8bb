// ModelTable: the models that filters of this process share by a key.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "core/infer/model/shared_model.hpp"

namespace weir::infer {

// Thread-safe. A model stays in the table while it has users.
class ModelTable {
 public:
  static ModelTable& instance();
  ModelTable() = default;  // a separate table, for tests

  struct Found {
    std::shared_ptr<SharedModel> model;
    std::optional<Error> not_shared;  // MODEL_DIFFERS: `model` is exclusive to the caller
  };
  // Returns the model under this key if its source is the same, otherwise an exclusive one; always
  // an exclusive one for the key "". Opens nothing; ModelLease::create does.
  Found find(const std::string& key, const ModelConfig& source);

 private:
  std::mutex mutex_;  // guards models_
  std::map<std::string, std::weak_ptr<SharedModel>> models_;
};

}  // namespace weir::infer
