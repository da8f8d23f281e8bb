// Transform: parses an option to an Operation, plans it for a tensor's spec, and runs the plan.
//
//   auto operation = transform::parse(Mode::Arithmetic, "typecast:float32,add:-127.5,div:127.5");
//   auto plan = transform::plan(*operation, {ElementType::UInt8, {3, 224, 224}}, true);
//   plan->apply(input_bytes, output_bytes);
//
// Grammars and number rules: docs/elements/tensor_transform.md. Dimensions are innermost-first.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "core/tensor/strided_layout.hpp"
#include "weir/result.hpp"

namespace weir::transform {

// The values are those of the element's `mode` property.
enum class Mode : int32_t {
  Unknown = -1,
  Dimchg = 0,
  Typecast,
  Arithmetic,
  Transpose,
  Stand,
  Clamp,
  Padding
};
std::string_view to_string(Mode mode) noexcept;   // "typecast", ...; "unknown"
Mode parse_mode(std::string_view nick) noexcept;  // ignores case; Unknown if there is none

// ---- Operations: a parsed option, independent of any tensor ---------------------------------

struct Typecast {
  ElementType to = ElementType::End;
};

enum class Operator : uint8_t { Add, Mul, Div };

struct ArithmeticStep {
  Operator op = Operator::Add;
  std::variant<int64_t, double> operand;  // as written: with '.', 'e' or 'E' it is a double
  std::optional<uint32_t> channel;        // "@CH"; used only with a channel_dimension
};

struct Arithmetic {
  ElementType to = ElementType::End;        // End: keep the input's type
  std::optional<size_t> channel_dimension;  // "per-channel:true@DIM"
  std::vector<ArithmeticStep> steps;        // in the order of execution, at least one
};

struct Transpose {
  std::vector<uint8_t> order;  // output dimension i is input dimension order[i]; a permutation
};

struct Dimchg {
  uint8_t from = 0, to = 0;  // the dimensions in between move up or down by one
};

struct Stand {
  ElementType to = ElementType::End;  // End: keep the input's type
  bool only_mean = false;             // dc-average: x - mean; else |x - mean| / deviation
  bool per_channel = false;           // statistics for each index of dimension 0
};

struct Clamp {
  double low = 0, high = 0;
};

struct Padding {
  std::array<uint32_t, 3> before{}, after{};  // zeros at both ends of dimensions 0 to 2
};

struct Operation {
  std::variant<Dimchg, Typecast, Arithmetic, Transpose, Stand, Clamp, Padding> what;
  std::vector<std::string> warnings;  // valid settings that the user should know about

  Mode mode() const noexcept;
};

// Parses an option. Errors: OPTION_SYNTAX with a caret below the position in `difference`,
// OPTION_VALUE for numbers out of range, MODE_UNKNOWN if no mode is set.
Result<Operation> parse(Mode mode, std::string_view option);

// ---- Negotiation -----------------------------------------------------------------------------

// The output for one tensor. SPEC_MISMATCH if `in` is invalid, LIMIT_EXCEEDED above rank 16.
Result<TensorSpec> output_spec(const Operation& operation, const TensorSpec& in);

// A tensor with parts that may be open, for caps queries.
struct TemplateSpec {
  ElementType type = ElementType::End;  // End: any type
  Shape shape;                          // not valid: any shape

  bool type_open() const noexcept { return type == ElementType::End; }
  bool shape_open() const noexcept { return !shape.valid(); }
};

// The outputs that the inputs `in` can produce.
TemplateSpec output_candidates(const Operation& operation, const TemplateSpec& in);
// The inputs that can produce `out`; nullopt if none can (typecast:float32 never produces uint8).
std::optional<TemplateSpec> input_candidates(const Operation& operation, const TemplateSpec& out);

// ---- Plans -----------------------------------------------------------------------------------

// Events that apply() counts; the caller adds them to its statistics.
struct Counters {
  uint64_t divisions_by_zero = 0;  // integer elements that a division by zero left unchanged
};

class Kernel;  // one subclass per kind of work, inside core/transform

// An immutable recipe for one tensor. Copies share it.
class TransformPlan {
 public:
  TransformPlan(TensorSpec input, TensorSpec output, std::shared_ptr<const Kernel> kernel) noexcept
      : input_(std::move(input)), output_(std::move(output)), kernel_(std::move(kernel)) {}

  const TensorSpec& input() const noexcept { return input_; }
  const TensorSpec& output() const noexcept { return output_; }
  // Whether in and out of apply() may be the same memory (equal, not just overlapping).
  bool in_place_possible() const noexcept;
  // The output equals the input: the caller may share the memory instead of calling apply().
  bool is_copy() const noexcept;
  // A gather_plan() without further work: moves bytes without changing them.
  bool is_gather() const noexcept;
  // Each output element depends only on the input element at the same place.
  bool is_element_wise() const noexcept;
  // The spans have input().bytes() and output().bytes(). With shorter spans, only whole elements
  // that fit both spans are processed (a transpose does nothing). Any alignment. Thread-safe,
  // allocates nothing.
  Counters apply(std::span<const std::byte> in, std::span<std::byte> out) const noexcept;

 private:
  friend std::optional<TransformPlan> fused(const TransformPlan& first,
                                            const TransformPlan& second);
  TensorSpec input_, output_;
  std::shared_ptr<const Kernel> kernel_;
};

// One plan that does `first` and then `second` in a single pass over memory; nullopt if one of them
// needs more of the tensor at a time than a block in the cache. Arithmetic steps after a conversion
// become one chain, as if they were one option. Precondition: second.input() is first.output().
std::optional<TransformPlan> fused(const TransformPlan& first, const TransformPlan& second);

// Copies a tensor with gaps to dense memory. The plan's input is bytes, as many as the layout
// spans. fused() with element-wise work, or with several such plans, it remains one pass.
// SPEC_MISMATCH if the layout does not fit the tensor, LIMIT_EXCEEDED if it spans 4 GiB or more.
Result<TransformPlan> gather_plan(const TensorSpec& tensor, const StridedLayout& layout);

// accelerate = false uses the plain scalar path. The results are bit-identical, except that the
// vector path quiets a signalling float16 NaN in a channel without steps.
Result<TransformPlan> plan(const Operation& operation, const TensorSpec& in, bool accelerate);

}  // namespace weir::transform
