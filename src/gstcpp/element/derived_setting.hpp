// DerivedSetting<T>: a value computed from an element's settings and cached until they change.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <mutex>

namespace weir::gst {

// Any thread may call get(), and reset() after changing the settings. `compute` reads the settings
// itself, under a lock that reset() also takes, so that a value from older settings is never kept.
// Lock order: this lock, then the settings lock.
//
//   Result<Request> current() const {
//     return *request_.get([this] { return make_request(settings()); });
//   }
//   void property_changed(const char*) { request_.reset(); }
template <class T>
class DerivedSetting {
 public:
  template <class Compute>
  std::shared_ptr<const T> get(Compute&& compute) const {
    std::lock_guard lock(mutex_);
    if (!value_) value_ = std::make_shared<const T>(compute());
    return value_;
  }
  void reset() {
    std::lock_guard lock(mutex_);
    value_.reset();
  }

 private:
  mutable std::mutex mutex_;  // guards value_
  mutable std::shared_ptr<const T> value_;
};

}  // namespace weir::gst
