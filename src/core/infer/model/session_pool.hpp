// SessionPool: the sessions of one open model, up to the limit of its engine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <mutex>
#include <vector>

#include "core/infer/model/model.hpp"

namespace weir::infer {

// Thread-safe. Different sessions may be invoked concurrently. At the engine's limit (max_sessions)
// sessions get several users, whose calls are serialised unless several threads may invoke a
// session (WEIR_MODEL_THREAD_SAFE).
class SessionPool {
 public:
  // `options`: those that opened the model.
  SessionPool(std::shared_ptr<Model> model, OpenOptions options)
      : model_(std::move(model)), options_(std::move(options)) {}
  const std::shared_ptr<Model>& model() const noexcept { return model_; }

  // A new session, or at the limit the one with the fewest users.
  Result<std::shared_ptr<Session>> session();
  // A new session; null at the limit.
  Result<std::shared_ptr<Session>> own_session();
  // Opens the same model again, for sessions beyond the limit of this one.
  Result<std::shared_ptr<Model>> open_again() const {
    return Model::open(model_->engine(), options_);
  }
  // The number of sessions in use.
  size_t sessions() const;

 private:
  Result<std::shared_ptr<Session>> make();  // mutex_ is held; null at the limit

  const std::shared_ptr<Model> model_;
  const OpenOptions options_;
  mutable std::mutex mutex_;  // guards made_
  std::vector<std::weak_ptr<Session>> made_;
};

}  // namespace weir::infer
