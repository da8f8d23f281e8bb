// DenseHead: reads detectors that give a box and the scores of all classes for each cell.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "core/detection/dense_scores.hpp"
#include "core/detection/instance_masks.hpp"
#include "core/heads/coordinates.hpp"
#include "core/heads/dense_layout.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::heads {

// Where prototype masks are.
struct PrototypeFacts {
  size_t output = 0;
  size_t width = 0, height = 0, count = 0;
  bool are_packed = false;  // all values of a cell together
};

// The numbers of a row: centre x, centre y, width, height, [objectness], scores of classes, then
// key points, weights of prototypes or an angle.
struct DenseSpec {
  DenseLayout layout{};
  size_t output = 0;
  bool has_objectness = false;
  size_t classes = 0;
  size_t points = 0, point_length = 3;  // numbers of a key point: x, y, [score]
  bool has_angle = false;
  std::optional<PrototypeFacts> prototypes{};
  Unit unit = Unit::Automatic;
  bool may_be_cells = false;  // coordinates may be Unit::Cells
};

class DenseHead final : public Head {
 public:
  DenseHead(DenseSpec spec, float threshold);
  results::Features features() const override;
  Suppression suppression() const noexcept override;
  size_t classes() const noexcept override { return spec_.classes; }
  detection::Candidates find(OutputValues& outputs, Size input) override;
  void complete(OutputValues& outputs, std::span<const detection::Candidate> kept, Size input,
                results::FrameResults* results) override;

 private:
  struct Scale {
    float x = 1, y = 1;
  };
  Size known(Size input) const noexcept;
  Unit choose_unit(std::span<const float> numbers, Size input);
  Unit unit_of_grid(std::span<const float> numbers, Size input);
  void add_points(std::span<const float> numbers, std::span<const detection::Candidate> kept,
                  results::FrameResults* results) const;
  void add_masks(OutputValues& outputs, std::span<const float> numbers,
                 std::span<const detection::Candidate> kept, Size input,
                 results::FrameResults* results);
  std::span<const float> read(OutputValues& outputs) const;
  std::span<const CellPlace> places(Size input);
  // `where` is empty unless the numbers are relative to cells.
  detection::Candidate make_candidate(const detection::ScoredCell& found,
                                      std::span<const float> numbers,
                                      std::span<const CellPlace> where) const;

  DenseSpec spec_;
  detection::DenseScores scores_;
  float threshold_;
  UnitOfNumbers numbers_;  // unless they may be relative to cells
  std::vector<detection::ScoredCell> found_;
  std::vector<CellPlace> places_;
  Size placed_{};  // the input that places_ are of
  Scale scale_;    // of the coordinates of the last frame, to pixels
  detection::InstanceMasks masks_;
};

}  // namespace weir::heads
