// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/frame_spec.hpp"

#include <algorithm>
#include <numeric>

#include "core/text/text.hpp"
#include "weir/join.hpp"

namespace weir {
namespace {

constexpr std::string_view kListSeparators = ",.";

Error too_many(std::string_view what, size_t count) {
  return Error{.code = Code::LIMIT_EXCEEDED,
               .what = "a list of " + std::string(what) + " is too long",
               .offered = std::to_string(count) + " entries",
               .needed = "at most 256"};
}

}  // namespace

std::string_view to_string(Format format) noexcept {
  switch (format) {
    case Format::Static:
      return "static";
    case Format::Flexible:
      return "flexible";
    case Format::Sparse:
      return "sparse";
    case Format::End:
      break;
  }
  return "unknown";
}

Format parse_format(std::string_view text) noexcept {
  for (const Format format : {Format::Static, Format::Flexible, Format::Sparse})
    if (equal_ignoring_case(text, to_string(format))) return format;
  return Format::End;
}

MediaType media_type_of_caps_name(std::string_view name) noexcept {
  if (name.starts_with("video/")) return MediaType::Video;
  if (name.starts_with("audio/")) return MediaType::Audio;
  if (name.starts_with("text/")) return MediaType::Text;
  if (name == "application/octet-stream") return MediaType::Octet;
  if (name == "other/tensor" || name == "other/tensors") return MediaType::Tensor;
  return MediaType::Invalid;
}

std::optional<uint64_t> TensorSpec::bytes() const noexcept {
  if (!valid()) return std::nullopt;
  const auto count = shape.count();
  uint64_t total = 0;
  if (!count || __builtin_mul_overflow(*count, uint64_t{element_size(type)}, &total) ||
      total > INT64_MAX)
    return std::nullopt;
  return total;
}

std::string TensorSpec::to_string() const {
  const std::string dims = shape.to_string();
  return std::string(weir::to_string(type)) + " " + (dims.empty() ? "?" : dims);
}

namespace {

// The first part that is not a number, or empty. Shape::parse() would take it for the end of the
// dimensions and hide a typo.
std::string_view no_number_in(std::string_view shape) {
  for (const auto part : split(shape, ":", kRankLimit)) {
    const auto word = strip(part);
    if (word.empty()) return {};
    if (word.find_first_not_of("0123456789") != std::string_view::npos) return word;
  }
  return {};
}

}  // namespace

Result<std::vector<Shape>> parse_shape_list(std::string_view text) {
  std::vector<Shape> out;
  if (strip(text).empty()) return out;
  const auto parts = split(text, kListSeparators);
  if (parts.size() > kTensorLimit) return too_many("dimensions", parts.size());
  for (const auto part : parts) {
    const auto word = no_number_in(part);
    out.push_back(Shape::parse(part));
    if (!out.back().valid() || !word.empty())
      return Error{
          .code = Code::DIMENSION_SYNTAX,
          .what = "a dimension cannot be read",
          .offered = std::string(text),
          .needed = "whole numbers above 0 from the innermost outwards, separated by ':'",
          .difference = (word.empty() ? "at \"" : "at \"" + std::string(word) + "\" of \"") +
                        std::string(part) + "\"",
          .fix = "3:224:224:1"};
  }
  return out;
}

Result<std::vector<ElementType>> parse_type_list(std::string_view text) {
  std::vector<ElementType> out;
  if (strip(text).empty()) return out;
  const auto parts = split(text, kListSeparators);
  if (parts.size() > kTensorLimit) return too_many("types", parts.size());
  for (const auto part : parts) {
    out.push_back(parse_element_type(part));
    if (out.back() == ElementType::End)
      return Error{
          .code = Code::TYPE_SYNTAX,
          .what = "an element type is unknown",
          .offered = std::string(text),
          .needed = "int8 uint8 int16 uint16 int32 uint32 int64 uint64 float16 float32 float64",
          .difference = "at \"" + std::string(part) + "\"",
          .fix = "float32"};
  }
  return out;
}

std::vector<std::string> parse_name_list(std::string_view text) {
  std::vector<std::string> out;
  if (strip(text).empty()) return out;
  for (const auto part : split(text, ",")) out.emplace_back(strip(part));
  return out;
}

std::string join_shapes(const std::vector<TensorSpec>& tensors, size_t min_entries) {
  return join(tensors, ",", [&](const auto& t) { return t.shape.to_string(min_entries); });
}
std::string join_types(const std::vector<TensorSpec>& tensors) {
  return join(tensors, ",", [](const auto& t) { return std::string(to_string(t.type)); });
}
std::string join_names(const std::vector<TensorSpec>& tensors) {
  return join(tensors, ",", [](const auto& t) { return t.name; });
}

bool Fraction::operator==(const Fraction& other) const noexcept {
  return static_cast<int64_t>(numerator) * other.denominator ==
         static_cast<int64_t>(other.numerator) * denominator;
}

bool FrameSpec::info_valid() const noexcept {
  if (format == Format::Flexible || format == Format::Sparse) return true;
  return format == Format::Static && !tensors.empty() && tensors.size() <= kTensorLimit &&
         std::all_of(tensors.begin(), tensors.end(), [](const auto& t) { return t.valid(); });
}

bool FrameSpec::valid() const noexcept {
  return rate.valid() && info_valid();
}

bool FrameSpec::operator==(const FrameSpec& other) const noexcept {
  if (!valid() || !other.valid() || !(rate == other.rate) || format != other.format) return false;
  if (format != Format::Static) return true;
  return std::equal(tensors.begin(), tensors.end(), other.tensors.begin(), other.tensors.end(),
                    [](const auto& a, const auto& b) { return a.same_layout(b); });
}

std::optional<uint64_t> FrameSpec::bytes() const noexcept {
  uint64_t total = 0;
  for (const auto& tensor : tensors) {
    const auto bytes = tensor.bytes();
    if (!bytes || __builtin_add_overflow(total, *bytes, &total) || total > INT64_MAX)
      return std::nullopt;
  }
  return total;
}

std::string FrameSpec::to_string() const {
  if (format == Format::Flexible || format == Format::Sparse)
    return std::string(weir::to_string(format)) + " tensors";
  return std::to_string(tensors.size()) + (tensors.size() == 1 ? " tensor: " : " tensors: ") +
         join(tensors, ", ", [](const TensorSpec& tensor) { return tensor.to_string(); });
}

std::string first_difference(const std::vector<TensorSpec>& offered,
                             const std::vector<TensorSpec>& needed) {
  if (offered.size() != needed.size())
    return "number of tensors is " + std::to_string(offered.size()) + ", needed is " +
           std::to_string(needed.size());
  for (size_t i = 0; i < offered.size(); ++i) {
    const std::string who = "tensor " + std::to_string(i) + ": ";
    if (offered[i].type != needed[i].type)
      return who + "type is " + std::string(to_string(offered[i].type)) + ", needed is " +
             std::string(to_string(needed[i].type));
    if (!(offered[i].shape == needed[i].shape))
      return who + "dimension is " + offered[i].shape.to_string() + ", needed is " +
             needed[i].shape.to_string();
  }
  return "";
}

}  // namespace weir
