// SessionPool: the sessions of one opened model, as many as its engine allows.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <mutex>
#include <vector>

#include "core/infer/model.hpp"

namespace weir::infer {

// Thread-safe. Different sessions may be invoked at the same time. Where an engine allows only so
// many (max_sessions), they have more than one user, who take turns unless a session may be invoked
// by several threads at once (WEIR_MODEL_THREAD_SAFE).
class SessionPool {
 public:
  // `options`: what the model was opened with.
  SessionPool(std::shared_ptr<Model> model, OpenOptions options)
      : model_(std::move(model)), options_(std::move(options)) {}
  const std::shared_ptr<Model>& model() const noexcept { return model_; }

  // A new session, or where no more are allowed the one with the fewest users.
  Result<std::shared_ptr<Session>> session();
  // A new session, null when no more are allowed.
  Result<std::shared_ptr<Session>> own_session();
  // The same model once more, for sessions that this one does not allow.
  Result<std::shared_ptr<Model>> open_again() const {
    return Model::open(model_->engine(), options_);
  }
  // That have a user.
  size_t sessions() const;

 private:
  Result<std::shared_ptr<Session>> make();  // mutex_ is held; null when no more are allowed

  const std::shared_ptr<Model> model_;
  const OpenOptions options_;
  mutable std::mutex mutex_;  // guards made_
  std::vector<std::weak_ptr<Session>> made_;
};

}  // namespace weir::infer
