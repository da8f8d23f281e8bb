// What floor.cpp repeats, and the engine that does it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>

#include "floor_asked.hpp"

namespace control {

// One network of each kind, for one thread at a time. Errors are exceptions.
class Invokes {
 public:
  virtual ~Invokes() = default;
  virtual void p(const Asked& asked) = 0;  // P-Net on each layer of the pyramid
  virtual void r(const Asked& asked) = 0;
  virtual void o(const Asked& asked) = 0;
};
// Of the engine that the program is built with; the networks' files lie in `models`. `most`: of
// the clip's pictures the largest, and of regions the most.
std::unique_ptr<Invokes> make_invokes(const std::string& models, uint32_t min_face,
                                      const Asked& most, const Seen& seen);

}  // namespace control
