// Average precision as COCO defines it: the area under the curve of precision over recall, sampled
// at 101 recalls and averaged over ten thresholds of similarity, .50 to .95, and over categories.
// https://cocodataset.org/#detection-eval
//
//   AveragePrecision precision(pictures, categories, {});
//   for (const Score& score : precision.scores()) print(score.name, score.value);
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/evaluate/objects.hpp"
#include "core/evaluate/scores.hpp"

namespace weir::evaluate {

inline constexpr size_t kSimilarityThresholds = 10, kRecalls = 101;

struct PrecisionSettings {
  // Deviations of key points: objects are compared by OKS. Empty: boxes, by their overlap.
  std::vector<double> deviations;
};

class AveragePrecision {
 public:
  // Matches the found objects with the truth. `categories`: one more than the largest category.
  AveragePrecision(std::span<const PictureObjects> pictures, size_t categories,
                   const PrecisionSettings& settings);

  // COCO's twelve numbers for boxes, or ten for key points.
  Scores scores() const;
  // The first three of them, for pictures that count several times or not at all.
  Scores headline(Times times) const;
  // Average precision of one category; undefined without objects that count.
  double of_category(size_t category) const;
  // Precision at the recalls 0, 0.01 ... 1 at a similarity of 0.5.
  std::array<double, kRecalls> curve_of_category(size_t category) const;

 private:
  struct Candidate {
    uint32_t picture = 0, rank = 0;  // rank: place among the picture's, by score
    double score = 0;
    uint16_t matched = 0, ignored = 0;  // a bit for each threshold
  };
  struct Positives {
    uint32_t picture = 0, count = 0;
  };
  struct Slice {  // of a category and a range of areas
    std::vector<Candidate> candidates;
    std::vector<Positives> positives;
  };
  struct Curve {
    std::array<double, kRecalls> precision{};
    double recall = 0;
    bool is_defined = false;
  };
  struct Mean {
    double precision = kUndefined, recall = kUndefined;
  };
  struct Matcher;

  static double count_positives(const Slice& slice, Times times);
  Curve curve(const Slice& slice, size_t threshold, uint32_t max, Times times) const;
  static void set_precisions(const std::vector<double>& recalls, std::vector<double> precisions,
                             Curve* curve);
  Mean mean(size_t range, size_t first_threshold, size_t end_threshold, uint32_t max,
            Times times) const;

  bool has_key_points_ = false;
  uint32_t max_found_ = 100;                // of a category in a picture
  std::vector<std::vector<Slice>> slices_;  // by range of areas, then by category
};

}  // namespace weir::evaluate
