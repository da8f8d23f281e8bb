// Transform: an option text becomes an Operation, with a tensor's spec a Plan, and the plan runs.
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
std::string_view name_of(Mode mode) noexcept;     // "typecast", ...; "unknown"
Mode parse_mode(std::string_view nick) noexcept;  // case ignored; Unknown when there is none

// ---- Operations: what an option says, before any tensor is known ----------------------------

struct Typecast {
  ElementType to = ElementType::End;
};

enum class Operator : uint8_t { Add, Mul, Div };

struct ArithmeticStep {
  Operator op = Operator::Add;
  std::variant<int64_t, double> operand;  // as written: with '.', 'e' or 'E' it is a double
  std::optional<uint32_t> channel;        // "@CH"; counts only with a channel_dimension
};

struct Arithmetic {
  ElementType to = ElementType::End;        // End: the input's type stays
  std::optional<size_t> channel_dimension;  // "per-channel:true@DIM"
  std::vector<ArithmeticStep> steps;        // in the order of execution, at least one
};

struct Transpose {
  std::vector<uint8_t> order;  // out dimension i is in dimension order[i]; a permutation
};

struct Dimchg {
  uint8_t from = 0, to = 0;  // the dimensions between move up or down by one
};

struct Stand {
  ElementType to = ElementType::End;  // End: the input's type stays
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
  std::vector<std::string> warnings;  // things that work but that the user should know

  Mode mode() const noexcept;
};

// Reads an option. Errors: OPTION_SYNTAX with the place under a caret in `difference`,
// OPTION_VALUE for numbers out of range, MODE_UNKNOWN when no mode is set.
Result<Operation> parse(Mode mode, std::string_view option);

// ---- Negotiation -----------------------------------------------------------------------------

// The output for one tensor. SPEC_MISMATCH when `in` is not valid, LIMIT_EXCEEDED beyond rank 16.
Result<TensorSpec> output_spec(const Operation& operation, const TensorSpec& in);

// A tensor of which parts may be open, for caps queries.
struct TemplateSpec {
  ElementType type = ElementType::End;  // End: any type
  Shape shape;                          // not valid: any shape

  bool type_open() const noexcept { return type == ElementType::End; }
  bool shape_open() const noexcept { return !shape.valid(); }
};

// Which outputs the inputs `in` give.
TemplateSpec output_candidates(const Operation& operation, const TemplateSpec& in);
// Which inputs can give `out`; nullopt when none can (typecast:float32 never gives uint8).
std::optional<TemplateSpec> input_candidates(const Operation& operation, const TemplateSpec& out);

// ---- Plans -----------------------------------------------------------------------------------

// What apply() noticed; the caller adds it to its statistics.
struct Counters {
  uint64_t divisions_by_zero = 0;  // integer elements that a division left unchanged
};

class Kernel;  // one per kind of work, inside core/transform

// An immutable recipe for one tensor. Copies share it.
class Plan {
 public:
  Plan(TensorSpec input, TensorSpec output, std::shared_ptr<const Kernel> kernel) noexcept
      : input_(std::move(input)), output_(std::move(output)), kernel_(std::move(kernel)) {}

  const TensorSpec& input() const noexcept { return input_; }
  const TensorSpec& output() const noexcept { return output_; }
  // apply() may be called with in and out being the same memory (equal, not just overlapping).
  bool in_place_possible() const noexcept;
  // The output bytes are the input bytes: the caller may share the memory instead of applying.
  bool is_copy() const noexcept;
  // Nothing but gather_plan(): the bytes are moved, and not changed.
  bool is_gather() const noexcept;
  // Each element of the output needs only the element of the input at its place.
  bool is_element_wise() const noexcept;
  // Bytes are input().bytes() and output().bytes(); with less, only whole elements that both spans
  // hold are done (a transpose does nothing). Any alignment. Thread-safe, allocates nothing.
  Counters apply(std::span<const std::byte> in, std::span<std::byte> out) const noexcept;

 private:
  friend std::optional<Plan> fused(const Plan& first, const Plan& second);
  TensorSpec input_, output_;
  std::shared_ptr<const Kernel> kernel_;
};

// One plan that does `first` and then `second` in a single pass over memory; nullopt when one of
// them needs more of the tensor at a time than a block in the cache. Steps of arithmetic behind a
// conversion become one chain, as if one option had named them all. Precondition: second.input() is
// first.output().
std::optional<Plan> fused(const Plan& first, const Plan& second);

// The dense tensor from memory where it lies with gaps. Its input is bytes, as many as the layout
// reaches over; fused() with element-wise work, or several such plans, it stays one pass.
// SPEC_MISMATCH when the layout does not fit the tensor, LIMIT_EXCEEDED when it reaches over 4 GiB
// or more.
Result<Plan> gather_plan(const TensorSpec& tensor, const StridedLayout& layout);

// accelerate = false takes the plain scalar path; the results are the same bit for bit, but that a
// signalling NaN of float16 in a channel that no step touches becomes quiet on the vector path.
Result<Plan> plan(const Operation& operation, const TensorSpec& in, bool accelerate);

}  // namespace weir::transform
