// CentroidTracker: gives objects the same number from frame to frame by the distance of centres.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/detection/pixel_box.hpp"

namespace weir::detection {

// Each object keeps the centre at which it was first seen. The nearest pair of an object and a box
// match first; boxes without an object become new ones. Used by one thread at a time.
class CentroidTracker {
 public:
  // Returns the number of each box, in their order; 0 for boxes beyond the limit of 100 objects.
  std::vector<uint64_t> follow(std::span<const PixelBox> boxes);
  // Forgets all objects; numbers begin at 1 again.
  void reset() noexcept;

 private:
  struct Object {
    uint64_t number = 0;
    int64_t x = 0, y = 0;  // centre, in half pixels
    uint32_t missing = 0;  // frames in a row without a box
  };
  struct Pair;
  Pair nearest_box(const Object& object, std::span<const PixelBox> boxes,
                   std::span<const uint64_t> numbers) const;
  static std::optional<size_t> closest(const std::vector<Pair>& nearest,
                                       const std::vector<bool>& is_matched);
  // Sets the numbers of the boxes that continue an object, closest pairs first.
  void match(std::span<const PixelBox> boxes, std::vector<uint64_t>* numbers);

  std::vector<Object> objects_;
  uint64_t last_ = 0;
};

}  // namespace weir::detection
