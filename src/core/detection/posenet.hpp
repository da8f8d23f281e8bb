// PoseNet: joins the peaks of heat maps to persons.
//
// Papandreou et al., "PersonLab: Person Pose Estimation and Instance Segmentation with a
// Bottom-Up, Part-Based, Geometric Embedding Model", ECCV 2018, with greedy decoding as its
// authors publish it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace weir::detection {

inline constexpr size_t kPoseNetPoints = 17, kPoseNetEdges = 16;

// Vectors from a key point to the next one of the skeleton: for each edge one y and one x.
struct PoseNetVectors {
  std::span<const float> values;
  size_t per_cell = 0;
  size_t y = 0, x = 0;  // index of the first edge's in a cell
};

// The outputs for a picture. Cells are stored row after row, all values of a cell together.
struct PoseNetMaps {
  size_t width = 0, height = 0;      // cells, above 0
  float stride_x = 1, stride_y = 1;  // pixels between cells, above 0
  std::span<const float> heat;       // logits, kPoseNetPoints for each cell
  std::span<const float> offsets;    // pixels: kPoseNetPoints y, then as many x
  PoseNetVectors forward, backward;  // pixels; empty: the maps are of one person
};

struct PoseNetPerson {
  struct Point {
    float x = 0, y = 0, score = 0;  // pixels
  };
  std::array<Point, kPoseNetPoints> points{};
  float score = 0;
};

// The person with the best cell of each key point; the score is the mean of theirs.
PoseNetPerson best_person(const PoseNetMaps& maps);

// All persons whose score is at least `min`, as they are found: best first key point first. A
// person's score is the mean of its key points' scores without those that an earlier person has.
std::vector<PoseNetPerson> find_people(const PoseNetMaps& maps, float min);

}  // namespace weir::detection
