// Implements the arithmetic of the cascade.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "cascade.hpp"

#include <cmath>

namespace mtcnn {
namespace {

using weir::Box;
using weir::Overlap;

constexpr double kPyramidFactor = 0.709;  // roughly the square root of one half
constexpr float kProposalScore = 0.6f, kRefineScore = 0.7f, kFaceScore = 0.7f;
constexpr float kLayerOverlap = 0.5f, kOverlap = 0.7f;

// Suppresses overlapping candidates, best first.
void thin(std::vector<Candidate>* candidates, float threshold) {
  std::vector<Box> boxes;
  std::vector<float> scores;
  for (const auto& one : *candidates) boxes.push_back(one.box), scores.push_back(one.score);
  std::vector<Candidate> kept;
  for (const uint32_t i : weir::suppress(boxes, scores, threshold))
    kept.push_back((*candidates)[i]);
  *candidates = std::move(kept);
}

// Squares around the regressed boxes in whole pixels. Keeps a square only if its part within the
// picture covers at least one pixel of R-Net's input in each direction.
std::vector<Box> squares(std::span<const Candidate> candidates, Size picture) {
  const Box all{0, 0, static_cast<float>(picture.width), static_cast<float>(picture.height)};
  std::vector<Box> out;
  for (const auto& one : candidates) {
    const Box square = weir::square_around(one.moved);
    const Box whole{std::round(square.x1), std::round(square.y1), std::round(square.x2),
                    std::round(square.y2)};
    const Box part = weir::common_part(whole, all);
    constexpr auto kSide = static_cast<float>(kRefineSide);
    if (part.area() > 0 && std::min(part.width(), part.height()) * kSide >= whole.width())
      out.push_back(whole);
    if (out.size() == kMaxCandidates) break;
  }
  return out;
}

Box regressed(const Box& box, const float* moves) {
  return weir::moved(box, moves[0], moves[1], moves[2], moves[3]);
}

}  // namespace

std::vector<Size> pyramid(Size picture, uint32_t min_face) {
  std::vector<Size> out;
  const double shorter = std::min(picture.width, picture.height);
  for (double scale = double{kCell} / min_face; shorter * scale >= kCell; scale *= kPyramidFactor)
    out.push_back({static_cast<uint32_t>(std::ceil(picture.width * scale)),
                   static_cast<uint32_t>(std::ceil(picture.height * scale))});
  return out;
}

std::vector<Candidate> propose(const ProposalMap& map, Size layer, Size picture) {
  const float x_scale = static_cast<float>(picture.width) / static_cast<float>(layer.width);
  const float y_scale = static_cast<float>(picture.height) / static_cast<float>(layer.height);
  std::vector<Candidate> out;
  for (uint32_t y = 0; y < map.size.height; ++y) {
    for (uint32_t x = 0; x < map.size.width; ++x) {
      const float score =
          map.face[x * map.face_step.x + y * map.face_step.y + map.face_step.channel];
      if (!(score >= kProposalScore)) continue;
      const auto left = static_cast<float>(x * kStride), top = static_cast<float>(y * kStride);
      const Box cell{left * x_scale, top * y_scale, (left + kCell) * x_scale,
                     (top + kCell) * y_scale};
      float moves[4];
      for (size_t m = 0; m < 4; ++m)
        moves[m] = map.box[x * map.box_step.x + y * map.box_step.y + m * map.box_step.channel];
      out.push_back({cell, regressed(cell, moves), score});
    }
  }
  thin(&out, kLayerOverlap);
  return out;
}

std::vector<Box> join(std::vector<Candidate> of_all_layers, Size picture) {
  thin(&of_all_layers, kOverlap);
  return squares(of_all_layers, picture);
}

std::vector<Box> refine(std::span<const Box> regions, std::span<const float> face,
                        std::span<const float> box, Size picture) {
  std::vector<Candidate> all;
  for (size_t i = 0; i < regions.size(); ++i)
    if (face[2 * i + 1] > kRefineScore)
      all.push_back({regions[i], regressed(regions[i], &box[4 * i]), face[2 * i + 1]});
  thin(&all, kOverlap);
  return squares(all, picture);
}

std::vector<Face> faces(std::span<const Box> regions, std::span<const float> face,
                        std::span<const float> box, std::span<const float> points) {
  std::vector<Face> found, out;
  std::vector<Box> boxes;
  std::vector<float> scores;
  for (size_t i = 0; i < regions.size(); ++i) {
    const Box& region = regions[i];
    if (!(face[2 * i + 1] > kFaceScore)) continue;
    Face one{regressed(region, &box[4 * i]), face[2 * i + 1], {}};
    for (size_t p = 0; p < kPoints; ++p) {
      one.points[2 * p] = region.x1 + points[2 * kPoints * i + p] * region.width();
      one.points[2 * p + 1] = region.y1 + points[2 * kPoints * i + kPoints + p] * region.height();
    }
    found.push_back(one);
    boxes.push_back(one.box), scores.push_back(one.score);
  }
  for (const uint32_t i : weir::suppress(boxes, scores, kOverlap, Overlap::OfSmaller))
    out.push_back(found[i]);
  return out;
}

}  // namespace mtcnn
