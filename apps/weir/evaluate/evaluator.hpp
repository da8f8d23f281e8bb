// Evaluator: collects the results of one pipeline on a labelled folder and computes its scores.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/evaluate/scores.hpp"
#include "evaluate/labelled_folder.hpp"
#include "evaluate/picture_file.hpp"
#include "report.hpp"
#include "weir/result.hpp"

namespace weir::app {

// A box or key points on a picture of the page.
struct PictureMark {
  enum class Kind { Truth, Missed, Right, False };
  Kind kind = Kind::Truth;
  evaluate::Rectangle box{};
  std::vector<evaluate::LabelledPoint> points{};
  std::string label{};
};

// A picture with many errors.
struct Example {
  std::string path{}, caption{};
  double errors = 0;
  std::vector<PictureMark> shapes{};
  std::vector<bool> wrong_pixels{};  // of class maps
};

// The examples with the most errors, the worst first.
class WorstExamples {
 public:
  // Whether an example with so many errors would be kept.
  bool would_keep(double errors) const;
  void add(Example example);
  std::vector<Example> take() { return std::move(examples_); }

 private:
  std::vector<Example> examples_;
};

struct Evaluation {
  std::string metric{};  // the value of --metric
  evaluate::Scores scores{};
  size_t headline = 0;                    // the first scores, which have intervals
  evaluate::Scores parts{};               // a score of each category, class or sequence
  std::string part_name{}, part_score{};  // "category", "AP"
  std::vector<std::vector<uint64_t>> confusion{};
  std::vector<std::array<double, 101>> curves{};  // precision over recall of each category
  std::vector<Example> worst{};
  // The headline scores of a draw of units.
  std::function<std::vector<double>(evaluate::Times)> measure{};
  size_t units = 0;
  std::string unit_name{};  // "pictures", "sequences"
};

class Evaluator {
 public:
  virtual ~Evaluator() = default;
  // Whether the picture fits its truth. An error leaves it out.
  virtual Status accept(const LabelledPicture& picture, const DecodedPicture& decoded);
  // The pictures of a sequence come in their order.
  virtual Status add(size_t sequence, const LabelledPicture& picture, const Json& frame) = 0;
  // SPEC_MISMATCH or LABELS_INVALID when the results are not what the truth is of.
  virtual Result<Evaluation> finish() = 0;
  virtual std::vector<Error> warnings() const { return {}; }
};

// For the kind of the folder, which must stay. `model_labels`: the names of the model's classes, if
// they are known. OPTION_VALUE for a metric that the folder has no truth for.
Result<std::unique_ptr<Evaluator>> make_evaluator(const LabelledFolder& folder,
                                                  const EvaluateOptions& options,
                                                  const std::vector<std::string>& model_labels);

std::unique_ptr<Evaluator> make_object_evaluator(const LabelledFolder& folder,
                                                 const EvaluateOptions& options,
                                                 const std::vector<std::string>& model_labels);
std::unique_ptr<Evaluator> make_class_evaluator(const LabelledFolder& folder,
                                                const std::vector<std::string>& model_labels);
std::unique_ptr<Evaluator> make_map_evaluator(const LabelledFolder& folder);
std::unique_ptr<Evaluator> make_track_evaluator(const LabelledFolder& folder,
                                                const EvaluateOptions& options);

}  // namespace weir::app
