// Option: values of a program by name.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "capi-nnstreamer/ml-api-common.h"
#include "handles.hpp"

namespace weir::application {

// Thread-safe.
class Option : public Object {
 public:
  static constexpr const char* kKind = "option";
  struct Value {
    void* pointer = nullptr;
    ml_data_destroy_cb destroy = nullptr;
    void release() const {
      if (destroy && pointer) destroy(pointer);
    }
  };
  Option() = default;
  ~Option() override;
  const char* kind() const noexcept override { return kKind; }

  void set(const std::string& key, Value value);  // releases the value before
  void* get(const std::string& key) const;        // null: no such key
  std::vector<std::string> keys() const;

 private:
  mutable std::mutex mutex_;  // guards the rest
  std::map<std::string, Value> values_;
};

}  // namespace weir::application
