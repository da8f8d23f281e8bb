// Base of heads whose objects are sets of key points.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <vector>

#include "core/heads/head.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::heads {

// A key point; one that is not finite becomes (0, 0) with score 0.
results::KeyPoint key_point(float x, float y, float score) noexcept;

// find() of a derived class calls begin(), then add() for each object.
class PointsHead : public Head {
 public:
  explicit PointsHead(size_t points_per_object) : points_per_object_(points_per_object) {}
  results::Features features() const override { return {.points_per_object = points_per_object_}; }
  void complete(OutputValues& outputs, std::span<const detection::Candidate> kept, Size input,
                results::FrameResults* results) override;

 protected:
  size_t points_per_object() const noexcept { return points_per_object_; }
  void begin() noexcept;
  // Adds an object whose box is the upright one around its points of at least `min` score, or
  // around all of them if none has it.
  void add(std::span<const results::KeyPoint> points, float min, float score, int32_t class_index);
  // With a box of its own. Left out if it is not finite.
  void add(std::span<const results::KeyPoint> points, const Box& box, float score);
  detection::Candidates take() noexcept { return std::move(found_); }

 private:
  const size_t points_per_object_;
  detection::Candidates found_;
  std::vector<results::KeyPoint> points_;  // of all candidates
};

}  // namespace weir::heads
