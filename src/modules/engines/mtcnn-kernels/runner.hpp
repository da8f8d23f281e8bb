// Runner: runs pictures or regions through one of the networks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "networks.hpp"

namespace mtcnn::kernels {

enum class Precision { Float32, Int8 };

// Pictures are bytes with interleaved red, green and blue and rows without padding. One thread at a
// time.
class Runner {
 public:
  virtual ~Runner() = default;
  struct MapSize {
    size_t width, height;
  };
  // Size of each output for a picture of this size, which must not be smaller than the plan's side.
  virtual MapSize map_size(size_t width, size_t height) const = 0;
  // Runs `count` pictures of the same size; out[i] is head i of the plan,
  // [count][height][width][outputs]. The first head is the probabilities.
  virtual void run(const uint8_t* pictures, size_t count, size_t width, size_t height,
                   float* const* out) = 0;
};
std::unique_ptr<Runner> make_runner(const Network& network, Precision precision);

}  // namespace mtcnn::kernels
