// Pictures or regions through one of the networks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "networks.hpp"

namespace mtcnn::kernels {

enum class Precision { Float32, Int8 };

// Pictures: bytes, red, green and blue beside each other, rows without gaps. Used by one thread at
// a time.
class Runner {
 public:
  virtual ~Runner() = default;
  struct MapSize {
    size_t width, height;
  };
  // Of each output for a picture of that size, which is not smaller than the plan's side.
  virtual MapSize map_size(size_t width, size_t height) const = 0;
  // `count` pictures of the same size; out[i]: head i of the plan, [count][height][width][outputs].
  // The first is the probabilities.
  virtual void run(const uint8_t* pictures, size_t count, size_t width, size_t height,
                   float* const* out) = 0;
};
std::unique_ptr<Runner> make_runner(const Network& network, Precision precision);

}  // namespace mtcnn::kernels
