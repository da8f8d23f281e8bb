// The parts specific to MTCNN: the image pyramid, and decoding the outputs of its three networks
// (Zhang et al., arXiv:1604.02878; with the customary constants). Boxes are in pixels of the
// picture.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "weir/detection.hpp"

namespace mtcnn {

inline constexpr uint32_t kCell = 12,
                          kStride = 2;  // receptive field and stride of P-Net in pixels of a layer
inline constexpr uint32_t kRefineSide = 24, kLandmarkSide = 48;
inline constexpr size_t kPoints = 5;
inline constexpr size_t kMaxCandidates = 1024;  // per frame, the best

struct Size {
  uint32_t width = 0, height = 0;
};
// The layers in which faces of `min_face` pixels and more fill P-Net's cell, largest layer first.
// Empty when the picture is smaller than a face.
std::vector<Size> pyramid(Size picture, uint32_t min_face);

struct Candidate {
  weir::Box box;    // the network's input region
  weir::Box moved;  // the regressed face box
  float score = 0;
};

// The number of elements between two columns, rows and channels.
struct Steps {
  size_t x, y, channel;
};
// P-Net's output maps for one layer: `face` has two channels, the second is the face's probability;
// `box` has four.
struct ProposalMap {
  Size size;
  std::span<const float> face, box;
  Steps face_step, box_step;
};
// Returns the candidates of one layer after suppression.
std::vector<Candidate> propose(const ProposalMap& map, Size layer, Size picture);
// Merges the candidates of all layers, suppresses again, and returns squares for R-Net.
std::vector<weir::Box> join(std::vector<Candidate> of_all_layers, Size picture);

// `regions`: the inputs of R-Net, with one row of `face` (2) and `box` (4) each. Returns squares
// for O-Net.
std::vector<weir::Box> refine(std::span<const weir::Box> regions, std::span<const float> face,
                              std::span<const float> box, Size picture);

struct Face {
  weir::Box box;
  float score = 0;
  std::array<float, 2 * kPoints>
      points{};  // x, y of left eye, right eye, nose, corners of the mouth
};
// The same for O-Net, with `points` (10: five x, five y).
std::vector<Face> faces(std::span<const weir::Box> regions, std::span<const float> face,
                        std::span<const float> box, std::span<const float> points);

}  // namespace mtcnn
