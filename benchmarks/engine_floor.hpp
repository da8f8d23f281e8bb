// A model of an engine in a bare loop, on memory made once: what tensor_filter is measured against.
// One file for each engine fills make_floor().
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

// `models`: the files, comma-separated; `shape`: of the only input, outermost-first, zeros of
// uint8 or float32. On one thread.
std::unique_ptr<EngineFloor> make_floor(const std::string& models,
                                        const std::vector<int64_t>& shape, bool uint8);

}  // namespace weir::bench
