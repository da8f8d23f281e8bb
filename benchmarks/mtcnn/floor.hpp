// Invokes: what floor.cpp repeats, and the engine that does it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>

#include "floor_requests.hpp"

namespace control {

// One network of each kind. One thread at a time; errors are exceptions.
class Invokes {
 public:
  virtual ~Invokes() = default;
  virtual void p(const Requests& requests) = 0;  // P-Net on each layer of the pyramid
  virtual void r(const Requests& requests) = 0;
  virtual void o(const Requests& requests) = 0;
};
// Uses the engine with which the program is built; `models` has the network files. `max`: the
// largest picture of the clip and the highest numbers of regions.
std::unique_ptr<Invokes> make_invokes(const std::string& models, uint32_t min_face,
                                      const Requests& max, const Seen& seen);

}  // namespace control
