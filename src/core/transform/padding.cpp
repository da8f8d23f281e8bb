// mode=padding: its grammar, shapes and kernel.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/modes.hpp"

#include <algorithm>
#include <cstring>

#include "core/text/text.hpp"
#include "core/transform/option_reader.hpp"

namespace weir::transform {
namespace {

constexpr const char* kPaddingExample = "option=left:1,right:1,top:2,bottom:2";
constexpr uint32_t kMax = 1 << 16;  // zeros on one side

struct Side {
  std::string_view name;
  size_t dimension;
  bool before;
};
constexpr Side kSides[] = {{"left", 0, true},    {"right", 0, false}, {"top", 1, true},
                           {"bottom", 1, false}, {"front", 2, true},  {"back", 2, false}};

Status take_side(OptionReader& reader, Padding& padding) {
  const auto side = std::find_if(std::begin(kSides), std::end(kSides),
                                 [&](const Side& s) { return reader.take(s.name); });
  if (side == std::end(kSides))
    return reader.syntax_error("left, right, top, bottom, front, back or layout", kPaddingExample);
  if (!reader.take(":")) return reader.syntax_error("':' and how many zeros", kPaddingExample);
  const size_t begin = reader.position();
  const auto digits = reader.take_digits();
  if (digits.empty()) return reader.syntax_error("how many zeros", kPaddingExample);
  const auto value = parse_unsigned(digits);
  if (!value || *value > kMax) {
    reader.go_to(begin);
    return reader.value_error("a side of the padding is too large",
                              "at most " + std::to_string(kMax), kPaddingExample);
  }
  (side->before ? padding.before : padding.after)[side->dimension] = static_cast<uint32_t>(*value);
  return ok();
}

Status take_layout(OptionReader& reader, Padding& padding) {
  if (reader.take("NHWC")) {
    std::swap(padding.before[0], padding.before[2]);
    std::swap(padding.after[0], padding.after[2]);
  } else if (!reader.take("NCHW")) {
    return reader.syntax_error("NCHW or NHWC", kPaddingExample);
  }
  return reader.at_end() ? ok() : reader.syntax_error("the end after the layout", kPaddingExample);
}

// Missing dimensions count as 1.
size_t extent(const Shape& shape, size_t dimension) noexcept {
  return dimension < shape.rank() ? shape[dimension] : 1;
}

// Copies the input's rows to their places and zeroes the gaps, so that each output byte is written
// once.
class PaddingKernel final : public Kernel {
 public:
  PaddingKernel(const Padding& padding, const Shape& in, size_t element_bytes) noexcept
      : row_(extent(in, 0) * element_bytes),
        rows_(extent(in, 1)),
        planes_(extent(in, 2)),
        left_(padding.before[0] * element_bytes),
        right_(padding.after[0] * element_bytes) {
    const size_t out_row = left_ + row_ + right_;
    top_ = padding.before[1] * out_row;
    bottom_ = padding.after[1] * out_row;
    const size_t out_plane = top_ + rows_ * out_row + bottom_;
    front_ = padding.before[2] * out_plane;
    back_ = padding.after[2] * out_plane;
    for (size_t i = 3; i < in.rank(); ++i) blocks_ *= in[i];
    in_bytes_ = row_ * rows_ * planes_ * blocks_;
    out_bytes_ = (front_ + planes_ * out_plane + back_) * blocks_;
  }

  Counters run(std::span<const std::byte> in, std::span<std::byte> out) const noexcept override {
    if (in.size() < in_bytes_ || out.size() < out_bytes_) return {};
    const std::byte* from = in.data();
    std::byte* to = out.data();
    size_t zeros = 0;  // zeros to write before the next row
    for (size_t block = 0; block < blocks_; ++block) {
      zeros += front_;
      for (size_t plane = 0; plane < planes_; ++plane) {
        zeros += top_;
        for (size_t row = 0; row < rows_; ++row) {
          zeros += left_;
          std::memset(to, 0, zeros);
          std::memcpy(to + zeros, from, row_);
          to += zeros + row_;
          from += row_;
          zeros = right_;
        }
        zeros += bottom_;
      }
      zeros += back_;
    }
    std::memset(to, 0, zeros);
    return {};
  }

 private:
  // In bytes, except the counts rows_, planes_ and blocks_.
  size_t row_, rows_, planes_, blocks_ = 1;
  size_t left_, right_, top_ = 0, bottom_ = 0, front_ = 0, back_ = 0;
  size_t in_bytes_ = 0, out_bytes_ = 0;
};

}  // namespace

Result<Operation> parse_padding(std::string_view option) {
  OptionReader reader("padding", option);
  Padding padding;
  do {
    if (auto status = take_side(reader, padding); !status) return std::move(status).error();
    reader.take(",");  // optional, also at the end
    if (!reader.take("layout:")) continue;
    if (auto status = take_layout(reader, padding); !status) return std::move(status).error();
  } while (!reader.at_end());
  Operation operation{padding, {}};
  if (padding.before == Padding{}.before && padding.after == Padding{}.after)
    operation.warnings.push_back("the padding " + std::string(option) +
                                 " adds nothing: each frame is passed on as it is");
  return operation;
}

TemplateSpec get_output(const Padding& padding, const TemplateSpec& in) {
  if (in.shape_open()) return in;
  TemplateSpec out = in;
  for (size_t i = 0; i < padding.before.size(); ++i) {
    const uint64_t size = uint64_t{extent(in.shape, i)} + padding.before[i] + padding.after[i];
    if (size > UINT32_MAX) return {in.type, {}};
    if (size > 1 || i < in.shape.rank()) {
      for (size_t before = in.shape.rank(); before < i; ++before)
        if (out.shape[before] == 0) out.shape[before] = 1;
      out.shape[i] = static_cast<uint32_t>(size);
    }
  }
  return out;
}

std::optional<TemplateSpec> find_input(const Padding&, const TemplateSpec& out) {
  return TemplateSpec{out.type, {}};
}

std::shared_ptr<const Kernel> make_kernel(const Padding& padding, const TensorSpec& in, bool) {
  if (padding.before == Padding{}.before && padding.after == Padding{}.after)
    return std::make_shared<CopyKernel>(static_cast<size_t>(in.bytes().value_or(0)),
                                        element_size(in.type));
  return std::make_shared<PaddingKernel>(padding, in.shape, element_size(in.type));
}

}  // namespace weir::transform
