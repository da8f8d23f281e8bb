// Records the requests to the networks for the pictures of a clip: mtcnn-control writes them,
// mtcnn-floor repeats them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "cascade.hpp"

namespace control {

// The requests for one picture.
struct Requests {
  mtcnn::Size picture;
  size_t refined = 0, marked = 0;  // numbers of regions for R-Net and O-Net
};

// The inputs of P-, R- and O-Net for one picture each: bytes with interleaved RGB; all layers in a
// row for P-Net, the regions for the others.
using Seen = std::array<std::vector<uint8_t>, 3>;

// Returns `count` bytes by repeating `seen`: engines whose loops branch on values need realistic
// ones. A constant value if `seen` is empty.
std::vector<uint8_t> repeat_bytes(const std::vector<uint8_t>& seen, size_t count);

// The same as each network's input for `max`; all layers in a row for P-Net.
Seen make_inputs(const Requests& max, uint32_t min_face, const Seen& seen);

class RequestFile {
 public:
  explicit RequestFile(std::string path) : path_(std::move(path)) {}  // "": writes no file
  // Where to store the input of network 0, 1 or 2: for the first picture that has one; otherwise
  // null.
  std::vector<uint8_t>* wanted(size_t network);
  void add(const Requests& requests);
  // `path`: a line per picture; `path`.p, .r and .o: the inputs.
  bool write() const;

 private:
  std::string path_;
  std::vector<Requests> pictures_;
  Seen seen_;
  std::array<bool, 3> begun_{};
};

// Reads such a file; returns no pictures when it is unreadable or empty.
std::vector<Requests> read_requests(const std::string& path);
Seen read_seen(const std::string& path);

}  // namespace control
