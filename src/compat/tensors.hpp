// Converts tensor descriptions between Weir's engines and C structs; validates those of callbacks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <deque>
#include <span>
#include <string>
#include <vector>

#include "compat/spec.hpp"
#include "weir/abi.h"
#include "weir/module.hpp"

namespace weir::compat {

// Owns a GstTensorsInfo. Names that a callback writes are copied and not freed, because their
// ownership is unknown.
class OwnedTensorsInfo {
 public:
  OwnedTensorsInfo() noexcept;
  ~OwnedTensorsInfo();
  OwnedTensorsInfo(const OwnedTensorsInfo&) = delete;
  OwnedTensorsInfo& operator=(const OwnedTensorsInfo&) = delete;

  GstTensorsInfo* get() noexcept { return &info_; }
  const GstTensorsInfo& operator*() const noexcept { return info_; }
  void assign(std::span<const weir_tensor_info> tensors);

 private:
  GstTensorsInfo info_;
};

// Writes `tensors` to `to`; gst_tensors_info_free() frees its names and `extra`. An unknown type is
// _NNS_END; unknown dimensions are 0.
void assign(std::span<const weir_tensor_info> tensors, GstTensorsInfo* to);

// Descriptions for an engine, with storage for their names.
struct Described {
  std::vector<weir_tensor_info> infos;
  std::deque<std::string> names;
};

// Reads what `filter` gave for its inputs or outputs (`role`: "input" or "output"). Throws
// CALLBACK_FAILED for an invalid result: no tensors, more than 256, a type out of range, invalid
// dimensions, 4 GiB or more.
Described described(const GstTensorsInfo& info, const std::string& filter, const char* role);

// Describes `count` tensors whose specs are unknown.
Described open_tensors(size_t count);

}  // namespace weir::compat
