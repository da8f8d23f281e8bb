// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/request.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "core/text/error_text.hpp"
#include "core/text/text.hpp"
#include "weir/join.hpp"

namespace weir::preprocess {
namespace {

Error unreadable(std::string_view name, std::string_view text, size_t position, const char* needed,
                 const char* fix) {
  return Error{.code = Code::OPTION_SYNTAX,
               .what = std::string(name) + " cannot be read",
               .offered = std::string(name) + "=" + std::string(text),
               .needed = needed,
               .difference = place_in(text, position),
               .fix = fix};
}

size_t position_in(std::string_view text, std::string_view part) noexcept {
  return static_cast<size_t>(part.data() - text.data());
}

bool fits_channels(const Request& request, uint32_t channels) noexcept {
  if (!request.order) return channels == 3 || channels == 1;
  return channels == (*request.order == ChannelOrder::Gray ? 1 : 3);
}

// Fills the open ones of layout, size and channel order from the shape.
void take_shape(Request* request, const Shape& shape) noexcept {
  const auto extent = [&](size_t i) { return std::max(shape[i], 1u); };
  if (!request->layout) {
    const bool inside = fits_channels(*request, extent(0));
    const bool outside = fits_channels(*request, extent(2));
    request->layout = !inside && outside ? Layout::Nchw : Layout::Nhwc;
  }
  const size_t columns = *request->layout == Layout::Nhwc ? 1 : 0;
  if (request->width == 0) request->width = extent(columns);
  if (request->height == 0) request->height = extent(columns + 1);
  if (!request->order)
    request->order = extent(columns == 1 ? 0 : 2) == 1 ? ChannelOrder::Gray : ChannelOrder::Rgb;
}

std::vector<Size> layers(const Request& request) {
  if (!request.sizes.empty()) return request.sizes;
  return {{request.width, request.height}};
}

Shape batched(const Request& request, Shape shape) {
  if (request.max_regions > 0) shape[3] = request.max_regions;
  return shape;
}

// Returns the index of one of the card's inputs.
Result<size_t> find_input(const card::Card& card, std::string_view wanted) {
  if (wanted.empty() && card.inputs.size() == 1) return size_t{0};
  std::vector<std::string> choices;
  for (size_t i = 0; i < card.inputs.size(); ++i) {
    const std::string& name = card.inputs[i].name;
    if (!wanted.empty() && name == wanted) return i;
    choices.push_back(std::to_string(i) + (name.empty() ? "" : " or " + name));
  }
  const std::string names = join(choices, ", ");
  if (wanted.empty())
    return Error{.code = Code::CARD_INVALID,
                 .what = "the model card does not state which input this picture is for",
                 .offered = card.path + ": " + std::to_string(card.inputs.size()) + " inputs",
                 .needed = "the name or number of one of them: " + names,
                 .fix = "card-input=0"};
  const auto number = parse_unsigned(wanted);
  if (number && *number < card.inputs.size()) return static_cast<size_t>(*number);
  return Error{.code = Code::OPTION_VALUE,
               .what = "the model card has no such input",
               .offered = "card-input=" + std::string(wanted),
               .needed = names,
               .fix = "card-input=0"};
}

ChannelOrder to_order(card::Color color) noexcept {
  switch (color) {
    case card::Color::Gray:
      return ChannelOrder::Gray;
    case card::Color::Bgr:
      return ChannelOrder::Bgr;
    case card::Color::Rgb:
      break;
  }
  return ChannelOrder::Rgb;
}

Fit to_fit(card::Fit resize) noexcept {
  switch (resize) {
    case card::Fit::Crop:
      return Fit::CentreCrop;
    case card::Fit::Letterbox:
      return Fit::Letterbox;
    case card::Fit::Stretch:
      break;
  }
  return Fit::Stretch;
}

}  // namespace

Result<std::vector<double>> parse_numbers(std::string_view name, std::string_view text) {
  std::vector<double> out;
  for (const auto part : split(text, ",")) {
    const auto word = strip(part);
    const auto number = parse_double(word);
    if (!number)
      return unreadable(name, text, position_in(text, word.empty() ? part : word),
                        "one number, or one for each channel, separated by commas",
                        "mean=123.675,116.28,103.53 scale=0.0171,0.0175,0.0174");
    out.push_back(*number);
  }
  return out;
}

Result<Quantisation> parse_quantisation(std::string_view text) {
  constexpr const char* kNeeded = "SCALE:ZERO_POINT";
  constexpr const char* kFix = "quantisation=0.0078125:128";
  const auto parts = split(text, ":", 2);
  const auto scale = parse_double(strip(parts[0]));
  if (!scale) return unreadable("quantisation", text, 0, kNeeded, kFix);
  if (parts.size() < 2) return unreadable("quantisation", text, text.size(), kNeeded, kFix);
  const auto zero_point = parse_signed(strip(parts[1]));
  if (!zero_point || *zero_point != static_cast<int32_t>(*zero_point))
    return unreadable("quantisation", text, position_in(text, parts[1]), kNeeded, kFix);
  return Quantisation{*scale, static_cast<int32_t>(*zero_point)};
}

Result<Point> parse_shift(std::string_view text) {
  constexpr const char* kNeeded = "X:Y, parts of the sides of a box";
  constexpr const char* kFix = "region-shift=0:-0.5";
  const auto parts = split(text, ":", 2);
  const auto x = parse_double(strip(parts[0]));
  if (!x) return unreadable("region-shift", text, 0, kNeeded, kFix);
  if (parts.size() < 2) return unreadable("region-shift", text, text.size(), kNeeded, kFix);
  const auto y = parse_double(strip(parts[1]));
  if (!y) return unreadable("region-shift", text, position_in(text, parts[1]), kNeeded, kFix);
  return Point{*x, *y};
}

Result<std::vector<Size>> parse_sizes(std::string_view text) {
  std::vector<Size> out;
  for (const auto part : split(text, ",")) {
    const auto sides = split(part, "x", 2);
    uint32_t values[2] = {};
    for (size_t i = 0; i < 2; ++i) {
      const auto word = i < sides.size() ? strip(sides[i]) : std::string_view();
      const auto value = parse_unsigned(word);
      if (value && *value > 0 && *value <= kSideLimit) {
        values[i] = static_cast<uint32_t>(*value);
        continue;
      }
      const size_t end = position_in(text, part) + part.size();
      return unreadable("sizes", text, word.empty() ? end : position_in(text, word),
                        "WIDTHxHEIGHT for each layer, separated by commas, sides of 1 to 65536",
                        "sizes=640x640,320x320,160x160");
    }
    out.push_back({values[0], values[1]});
  }
  if (out.size() <= kLayerLimit) return out;
  return Error{.code = Code::LIMIT_EXCEEDED,
               .what = "a pyramid has too many layers",
               .offered = "sizes of " + std::to_string(out.size()) + " layers",
               .needed = "at most " + std::to_string(kLayerLimit)};
}

Result<Rect> parse_crop(std::string_view text) {
  const auto words = split(text, ":", 5);
  uint32_t values[4] = {};
  for (size_t i = 0; i < 4 || i < words.size(); ++i) {
    const auto word = i < words.size() ? strip(words[i]) : std::string_view();
    const auto value = parse_unsigned(word);
    const bool side = i >= 2;
    if (i < 4 && value && *value <= kSideLimit && !(side && *value == 0)) {
      values[i] = static_cast<uint32_t>(*value);
      continue;
    }
    return unreadable("crop", text, word.empty() ? text.size() : position_in(text, word),
                      "X:Y:WIDTH:HEIGHT in pixels, sides of 1 to 65536", "crop=0:0:640:480");
  }
  return Rect{values[0], values[1], values[2], values[3]};
}

Result<ElementType> parse_type(std::string_view text) {
  const ElementType type = parse_element_type(text);
  if (type != ElementType::End) return type;
  return Error{.code = Code::TYPE_SYNTAX,
               .what = "the element type is not known",
               .offered = "type=" + std::string(text),
               .needed = "uint8, int8, float16 or float32",
               .fix = "type=float32"};
}

Result<Request> with_card(Request r, const card::Card& card, std::string_view name) {
  const auto chosen = find_input(card, name);
  if (!chosen) return chosen.error();
  const card::ImageInput& input = card.inputs[*chosen];
  if (r.sizes.empty() && r.width == 0) r.width = static_cast<uint32_t>(input.width());
  if (r.sizes.empty() && r.height == 0) r.height = static_cast<uint32_t>(input.height());
  // The border belongs to the card's letterbox.
  if (!r.fit && r.padding == 0) r.padding = input.padding;
  r.fit = r.fit.value_or(to_fit(input.resize));
  r.order = r.order.value_or(to_order(input.color));
  r.mean = r.mean.value_or(input.mean);
  r.scale = r.scale.value_or(input.scale);
  r.type = r.type.value_or(input.type);
  r.layout = r.layout.value_or(input.layout == card::Layout::Nchw ? Layout::Nchw : Layout::Nhwc);
  return r;
}

namespace {

std::vector<TensorSpec> make_frame_specs(const Request& r, ChannelOrder order, Layout layout) {
  std::vector<TensorSpec> out;
  Preparation p;
  p.order = order;
  p.layout = layout;
  for (const Size& size : layers(r)) {
    p.width = size.width;
    p.height = size.height;
    out.push_back({r.type.value_or(ElementType::End), batched(r, p.tensor().shape), ""});
  }
  return out;
}

}  // namespace

std::vector<std::vector<TensorSpec>> possible_frames(const Request& r) {
  if (r.sizes.empty() && (r.width == 0 || r.height == 0))
    return {{TensorSpec{r.type.value_or(ElementType::End), Shape(), ""}}};
  std::vector<std::vector<TensorSpec>> out;
  for (const auto order : {ChannelOrder::Rgb, ChannelOrder::Gray})
    for (const auto layout : {Layout::Nhwc, Layout::Nchw}) {
      if (r.layout && layout != *r.layout) continue;
      if (r.order && order != ChannelOrder::Rgb) continue;
      out.push_back(make_frame_specs(r, r.order.value_or(order), layout));
    }
  return out;
}

Result<Preparation> resolve(Request r, const TensorSpec& wanted) {
  if (wanted.shape.valid()) take_shape(&r, wanted.shape);
  if (!r.type && wanted.type != ElementType::End) r.type = wanted.type;
  const bool numbers = (r.mean && !r.mean->empty()) || (r.scale && !r.scale->empty());
  Preparation p;
  p.width = r.width;
  p.height = r.height;
  p.resize = r.resize;
  p.fit = r.fit.value_or(Fit::Stretch);
  p.padding = r.padding;
  p.order = r.order.value_or(ChannelOrder::Rgb);
  p.mean = r.mean.value_or(std::vector<double>());
  p.scale = r.scale.value_or(std::vector<double>());
  p.quantisation = r.quantisation;
  p.type = r.type.value_or(numbers && !r.quantisation ? ElementType::Float32 : ElementType::UInt8);
  p.layout = r.layout.value_or(Layout::Nhwc);
  if (auto status = check_target(p); !status) return status.error();
  return p;
}

Result<std::vector<Preparation>> resolve_frame(const Request& request,
                                               std::span<const TensorSpec> wanted) {
  std::vector<Preparation> out;
  for (const Size& size : layers(request)) {
    Request layer = request;
    layer.width = size.width;
    layer.height = size.height;
    const size_t index = out.size();
    auto preparation =
        resolve(std::move(layer), index < wanted.size() ? wanted[index] : TensorSpec{});
    if (!preparation) return preparation.error();
    out.push_back(*std::move(preparation));
  }
  return out;
}

std::vector<TensorSpec> make_output_specs(const Request& request,
                                          std::span<const Preparation> preparations) {
  std::vector<TensorSpec> out;
  for (const Preparation& preparation : preparations) {
    out.push_back(preparation.tensor());
    out.back().shape = batched(request, out.back().shape);
  }
  return out;
}

}  // namespace weir::preprocess
