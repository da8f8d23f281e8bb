// SPDX-License-Identifier: LGPL-2.1-or-later
#include "declared_tensors.hpp"

#include <array>
#include <charconv>

#include "weir/engine_tools.hpp"

namespace weir::engine {
namespace {

std::string_view stripped(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

std::vector<std::string_view> parts(std::string_view text, std::string_view separators) {
  std::vector<std::string_view> out;
  for (size_t at = 0;;) {
    const size_t end = text.find_first_of(separators, at);
    out.push_back(stripped(text.substr(at, end - at)));
    if (end == std::string_view::npos) return out;
    at = end + 1;
  }
}

Result<std::vector<int64_t>> shape_in(std::string_view text) {
  std::vector<int64_t> shape;
  for (const auto part : parts(text, ":")) {
    int64_t extent = 0;
    const auto [end, bad] = std::from_chars(part.data(), part.data() + part.size(), extent);
    const bool whole = bad == std::errc{} && end == part.data() + part.size();
    if (!whole || extent < 1 || extent > INT32_MAX || shape.size() == WEIR_RANK_LIMIT)
      return Error{.code = Code::DIMENSION_SYNTAX,
                   .what = "dimensions of a model's tensor cannot be read",
                   .offered = std::string(text),
                   .needed = "up to 16 integers of at least 1, innermost first",
                   .fix = "input=3:224:224:1"};
    shape.insert(shape.begin(), extent);
  }
  return shape;
}

Status take_into(std::vector<DeclaredTensor>* tensors, std::string_view kind,
                 std::string_view value) {
  const auto list = parts(value, kind == "name" ? "," : ",.");
  if (list.size() > WEIR_TENSOR_LIMIT)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "more tensors are declared than a stream can have",
                 .offered = std::to_string(list.size()),
                 .needed = "at most 256"};
  if (tensors->size() < list.size()) tensors->resize(list.size());
  for (size_t i = 0; i < list.size(); ++i) {
    DeclaredTensor& tensor = (*tensors)[i];
    if (kind == "name") {
      tensor.name = list[i];
    } else if (list[i].empty()) {
      continue;
    } else if (kind == "type") {
      const auto type = parse_type(list[i]);
      if (!type)
        return Error{.code = Code::TYPE_SYNTAX,
                     .what = "the element type of a model's tensor is unknown",
                     .offered = std::string(list[i]),
                     .needed = "uint8, int8 ... int64, float16, float32 or float64",
                     .fix = "inputtype=float32"};
      tensor.type = *type;
    } else {
      auto shape = shape_in(list[i]);
      if (!shape) return shape.error();
      tensor.shape = *std::move(shape);
      tensor.has_shape = true;
    }
  }
  return ok();
}

}  // namespace

std::optional<uint32_t> parse_type(std::string_view name) {
  for (uint32_t type = 0; type < WEIR_TYPE_END; ++type)
    if (equals_ignoring_case(name, type_name(type))) return type;
  return std::nullopt;
}

Result<bool> DeclaredTensors::take(std::string_view key, std::string_view value) {
  for (const auto side : {"input", "output"})
    for (const auto kind : {"", "type", "name"}) {
      if (!equals_ignoring_case(key, std::string(side) + kind)) continue;
      if (stripped(value).empty()) return true;
      auto* tensors = std::string_view(side) == "input" ? &inputs_ : &outputs_;
      if (auto status = take_into(tensors, kind, value); !status) return status.error();
      return true;
    }
  return false;
}

std::string dimension_text(const std::vector<int64_t>& shape) {
  std::string out;
  for (auto extent = shape.rbegin(); extent != shape.rend(); ++extent)
    out += (out.empty() ? "" : ":") + std::to_string(*extent);
  return out.empty() ? "1" : out;
}

}  // namespace weir::engine
