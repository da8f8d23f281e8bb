// EngineFloor: an engine in a plain loop on preallocated memory, the baseline for tensor_filter.
// Each engine has a file that implements make_floor().
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace weir::bench {

class EngineFloor {
 public:
  virtual ~EngineFloor() = default;
  virtual void run(int frames) = 0;
};

// `models`: comma-separated files; `shape`: that of the only input, outermost-first; zeros of uint8
// or float32. Runs on one thread.
std::unique_ptr<EngineFloor> make_floor(const std::string& models,
                                        const std::vector<int64_t>& shape, bool uint8);

}  // namespace weir::bench
