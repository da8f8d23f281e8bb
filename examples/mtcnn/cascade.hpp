// What is MTCNN's own: the pyramid, and what its three networks' numbers mean (Zhang et al.,
// arXiv:1604.02878; constants as everybody uses them). Boxes are in pixels of the picture.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "weir/detection.hpp"

namespace mtcnn {

inline constexpr uint32_t kCell = 12, kStride = 2;  // pixels of a layer that P-Net sees at a place
inline constexpr uint32_t kRefineSide = 24, kLandmarkSide = 48;
inline constexpr size_t kPoints = 5;
inline constexpr size_t kMostCandidates = 1024;  // of a frame, the best

struct Size {
  uint32_t width = 0, height = 0;
};
// The layers in which a face of `min_face` pixels and larger ones fill P-Net's cell, the largest
// layer first. Empty when the picture is smaller than a face.
std::vector<Size> pyramid(Size picture, uint32_t min_face);

struct Candidate {
  weir::Box box;    // where a network looked
  weir::Box moved;  // where it says that the face is
  float score = 0;
};

// Numbers from one place of a map to the next, from one row, from one channel.
struct Steps {
  size_t x, y, channel;
};
// P-Net's maps of one layer: `face` has two channels, the second the face's probability, `box`
// four.
struct ProposalMap {
  Size size;
  std::span<const float> face, box;
  Steps face_step, box_step;
};
// The places of one layer that may be faces, without doubles.
std::vector<Candidate> propose(const ProposalMap& map, Size layer, Size picture);
// Those of all layers without doubles, as squares for R-Net.
std::vector<weir::Box> join(std::vector<Candidate> of_all_layers, Size picture);

// `regions`: what R-Net saw, one row of `face` (2) and `box` (4) for each. Squares for O-Net.
std::vector<weir::Box> refine(std::span<const weir::Box> regions, std::span<const float> face,
                              std::span<const float> box, Size picture);

struct Face {
  weir::Box box;
  float score = 0;
  std::array<float, 2 * kPoints> points{};  // x, y of left eye, right eye, nose, mouth's corners
};
// The same of O-Net with `points` (10: five x, five y).
std::vector<Face> faces(std::span<const weir::Box> regions, std::span<const float> face,
                        std::span<const float> box, std::span<const float> points);

}  // namespace mtcnn
