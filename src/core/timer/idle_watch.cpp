// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/timer/idle_watch.hpp"

#include <utility>

namespace weir {

IdleWatch::IdleWatch(TimerQueue& queue, std::chrono::milliseconds limit,
                     std::function<bool()> on_idle)
    : queue_(queue),
      limit_(limit),
      on_idle_(std::move(on_idle)),
      last_(queue.now().time_since_epoch()),
      timer_(queue, [this] { check(); }) {
  timer_.start(limit_);
}

void IdleWatch::touch() {
  last_ = queue_.now().time_since_epoch();
  if (!watching_ && !watching_.exchange(true)) timer_.start(limit_);
}

void IdleWatch::check() {
  const auto last = last_.load();
  const auto idle = queue_.now().time_since_epoch() - last;
  if (idle < limit_) {
    timer_.start(limit_ - idle);
  } else if (!on_idle_()) {
    timer_.start(limit_);
  } else {
    watching_ = false;
    // A touch() in between saw watching_ set and left the restart to this thread.
    if (last_.load() != last && !watching_.exchange(true)) timer_.start(limit_);
  }
}

}  // namespace weir
