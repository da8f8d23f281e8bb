// What the networks were asked for the pictures of a clip: mtcnn-control writes it, mtcnn-floor
// repeats it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "../cascade.hpp"

namespace control {

// For one picture.
struct Asked {
  mtcnn::Size picture;
  size_t refined = 0, marked = 0;  // regions of R-Net and of O-Net
};

// What P-, R- and O-Net saw of one picture each: bytes, colours beside each other, red first; of
// P-Net the layers one behind the other, of the others the regions.
using Seen = std::array<std::vector<uint8_t>, 3>;

// `count` bytes of `seen`, which begins anew where it ends: an engine's time hangs on the numbers,
// where its loops branch on them. Bytes of one value where nothing was seen.
std::vector<uint8_t> bytes_of(const std::vector<uint8_t>& seen, size_t count);

// The same as each network's input for `most`: of P-Net the layers one behind the other.
Seen inputs_of(const Asked& most, uint32_t min_face, const Seen& seen);

class AskedFile {
 public:
  explicit AskedFile(std::string path) : path_(std::move(path)) {}  // "": nothing is written
  // Where the bytes of network 0, 1 or 2 go: of the first picture that has any. Else null.
  std::vector<uint8_t>* wanted(size_t network);
  void add(const Asked& asked);
  // `path`: a line for each picture; `path`.p, .r and .o: what was seen.
  bool write() const;

 private:
  std::string path_;
  std::vector<Asked> pictures_;
  Seen seen_;
  std::array<bool, 3> begun_{};
};

// Of a file that was written so; no pictures where it cannot be read or says nothing.
std::vector<Asked> read_asked(const std::string& path);
Seen read_seen(const std::string& path);

}  // namespace control
