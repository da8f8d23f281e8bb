// Head: reads the outputs of one family of models as results (core/results).
//
// A frame is read in two steps, so that what is expensive is done for objects that are kept only:
// find() returns candidates, the caller removes those that overlap better ones, and complete()
// adds key points, masks, maps and texts.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/detection/candidate.hpp"
#include "core/heads/output_values.hpp"
#include "core/results/frame_results.hpp"
#include "core/tensor/frame_spec.hpp"
#include "core/tensor/geometry.hpp"
#include "weir/module.hpp"

namespace weir::heads {

// One output of a model.
struct OutputSignature : TensorSpec {
  bool is_quantised = false;
};

// What is known of a model before its first frame.
struct ModelSignature {
  std::vector<OutputSignature> outputs;         // in the order of the stream
  Size input;                                   // of its input picture; 0 x 0 = unknown
  std::map<std::string, std::string> metadata;  // of the model file
  size_t labels = 0;                            // names of classes that are given; 0 = none

  // "float32 84:8400, ...", for errors.
  std::string describe_outputs() const;
};

// What a decoder is set to, as far as heads need it.
struct HeadOptions {
  float threshold = 0;  // least score of a candidate
  // Settings that a family declares: key and value of custom=.
  std::map<std::string, std::string> custom{};
  std::vector<std::string> labels{};  // of the user, or else of the model
};

// How candidates that overlap are removed.
enum class Suppression {
  None,      // the model has done it
  ByClass,   // candidates of the same class
  AnyClass,  // of any class
  Rotated    // of the same class, by the overlap of rotated boxes
};

// Used by one thread at a time.
class Head {
 public:
  virtual ~Head() = default;
  virtual results::Features features() const = 0;
  virtual Suppression suppression() const noexcept { return Suppression::None; }
  // The number of classes that the model tells apart; 0 = not known.
  virtual size_t classes() const noexcept { return 0; }
  // Whether objects have a rotation: their boxes turn with the picture.
  virtual bool has_rotation() const noexcept { return suppression() == Suppression::Rotated; }
  // Reads the outputs of a frame. Returns the candidates with at least the threshold's score, in
  // pixels of the model's input, with `row` set so that complete() finds their other values.
  // Candidates that are not finite are left out. Throws Failure (SPEC_MISMATCH) when shapes differ
  // from those it was opened for. Heads whose results are not objects return none.
  virtual detection::Candidates find(OutputValues& outputs, Size input) = 0;
  // Adds what belongs to the candidates that were kept, in their order: key points (pixels of the
  // model's input), masks, class scores, texts; and maps. `results->objects` stand already.
  virtual void complete(OutputValues& outputs, std::span<const detection::Candidate> kept,
                        Size input, results::FrameResults* results) {
    (void)outputs, (void)kept, (void)input, (void)results;
  }
  // What the values of the last frame contradict in how they are read. At most one for a head.
  std::optional<Error> next_warning() { return std::exchange(warning_, std::nullopt); }

 protected:
  void warn_once(std::optional<Error> warning) {
    if (warning && !std::exchange(has_warned_, true)) warning_ = std::move(warning);
  }

 private:
  std::optional<Error> warning_;
  bool has_warned_ = false;
};

// The modes of tensor_decoder, as bits.
enum Task : uint32_t {
  kDetection = 1,
  kClassification = 2,
  kSegmentation = 4,
  kPose = 8,
  kDepth = 16,
  kText = 32
};

enum class Match {
  No,
  Possible,  // shapes and types fit
  Certain    // names or metadata of the model say so too
};

// One family of models. Objects of this type are constants.
struct Family {
  std::string_view name;     // the word that selects it: custom=head:NAME
  std::string_view aliases;  // further words, separated by commas
  uint32_t tasks;            // Task bits: the modes that can show its results
  std::string_view outputs;  // of models of this family, for people
  std::string_view custom;   // settings that it declares, separated by commas
  float threshold;           // default of the least score
  Match (*fit)(const ModelSignature&);
  // Throws Failure (SPEC_MISMATCH, OPTION_VALUE) for outputs or settings that it cannot use.
  std::unique_ptr<Head> (*open)(const ModelSignature&, const HeadOptions&);
};

}  // namespace weir::heads
