// The outcome of `weir evaluate`: one or two evaluations and their intervals.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "core/evaluate/bootstrap.hpp"
#include "evaluate/evaluator.hpp"
#include "report.hpp"

namespace weir::app {

struct Evaluated {
  std::string name{};      // of the model, or the pipeline
  std::string pipeline{};  // that was played
  Evaluation evaluation{};
  std::vector<evaluate::Interval> intervals{};  // of the headline scores; empty: too few units
};

struct EvaluationComparison {
  std::string folder{};
  size_t pictures = 0;
  uint64_t draws = 0, seed = 0;
  std::vector<Evaluated> evaluated{};             // one or two
  std::vector<evaluate::Interval> differences{};  // second - first, of the headline scores
  std::vector<Error> warnings{};
};

// Fills in the intervals, with the same draws for both. They need at least two units.
void add_intervals(EvaluationComparison* comparison);

Json to_json(const EvaluationComparison& comparison);
std::string to_text(const EvaluationComparison& comparison);
// "-" for scores that are not defined; counts without decimals.
std::string number_text(double value);
// "0.412 to 0.455"
std::string interval_text(const evaluate::Interval& interval);
std::string pictures_text(size_t pictures);  // "3 pictures"
// What the difference of the first score shows. Precondition: two evaluations.
std::string verdict(const EvaluationComparison& comparison);

// The page of `weir evaluate --page`: one self-contained HTML file with the worst pictures. Decodes
// the pictures of the worst examples again. One that cannot be shown is left out.
std::string evaluation_page(const EvaluationComparison& comparison);

}  // namespace weir::app
