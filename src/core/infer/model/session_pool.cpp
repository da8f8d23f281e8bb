// Creates sessions and shares them at the engine's limit.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/model/session_pool.hpp"

#include <algorithm>

namespace weir::infer {

Result<std::shared_ptr<Session>> SessionPool::make() {
  std::erase_if(made_, [](const auto& session) { return session.expired(); });
  const auto& info = model_->info();
  if (info.max_sessions > 0 && made_.size() >= info.max_sessions) return std::shared_ptr<Session>();
  std::shared_ptr<std::mutex> turn;
  if (info.max_sessions > 0 && !(info.flags & WEIR_MODEL_THREAD_SAFE))
    turn = std::make_shared<std::mutex>();
  auto made = Session::create(model_, turn);
  if (!made) return made.error();
  std::shared_ptr<Session> session = *std::move(made);
  made_.push_back(session);
  return session;
}

Result<std::shared_ptr<Session>> SessionPool::own_session() {
  std::lock_guard lock(mutex_);
  return make();
}

Result<std::shared_ptr<Session>> SessionPool::session() {
  std::lock_guard lock(mutex_);
  for (;;) {
    auto made = make();
    if (!made || *made) return made;
    const auto least = std::min_element(
        made_.begin(), made_.end(),
        [](const auto& a, const auto& b) { return a.use_count() < b.use_count(); });
    if (auto session = least->lock()) return session;
  }
}

size_t SessionPool::sessions() const {
  std::lock_guard lock(mutex_);
  return static_cast<size_t>(
      std::count_if(made_.begin(), made_.end(), [](const auto& made) { return !made.expired(); }));
}

}  // namespace weir::infer
