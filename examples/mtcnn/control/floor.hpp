// What floor.cpp repeats, and the engine that does it.
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "../cascade.hpp"

namespace control {

// What the networks were asked for one picture.
struct Asked {
  mtcnn::Size picture;
  size_t refined = 0, marked = 0;  // regions of R-Net and of O-Net
};

// One network of each kind, for one thread at a time. Errors are exceptions.
class Invokes {
 public:
  virtual ~Invokes() = default;
  virtual void p(const Asked& asked) = 0;  // P-Net on each layer of the pyramid
  virtual void r(const Asked& asked) = 0;
  virtual void o(const Asked& asked) = 0;
};
// Of the engine that the program is built with; the networks' files lie in `models`.
std::unique_ptr<Invokes> make_invokes(const std::string& models, uint32_t min_face);

}  // namespace control
