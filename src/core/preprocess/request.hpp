// Request: a preparation with open fields, which a model card and the tensor wanted downstream fill
// in.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/card/card.hpp"
#include "core/preprocess/boxes.hpp"
#include "core/preprocess/preparation.hpp"
#include "core/tensor/geometry.hpp"
#include "weir/source_map.hpp"

namespace weir::preprocess {

inline constexpr size_t kLayerLimit = 16;  // layers of a pyramid

struct Request {
  uint32_t width = 0, height = 0;  // 0 = open
  std::vector<Size> sizes;         // a pyramid's layers, instead of width and height
  Resize resize = Resize::Bilinear;
  double padding = 0;
  bool regions = false;      // make a batch of parts of the picture (outermost dimension)
  uint32_t max_regions = 0;  // size of a static batch; 0 = flexible
  bool clip_regions = true;  // false: padding fills what is outside the picture
  RegionShape region_shape;
  std::optional<Fit> fit;
  std::optional<ChannelOrder> order;
  std::optional<std::vector<double>> mean, scale;
  std::optional<Quantisation> quantisation;
  std::optional<ElementType> type;
  std::optional<Layout> layout;
};

// "127.5" or "123.675,116.28,103.53". OPTION_SYNTAX with the position; `name` is the option's.
Result<std::vector<double>> parse_numbers(std::string_view name, std::string_view text);
// "SCALE:ZERO_POINT". OPTION_SYNTAX with the position.
Result<Quantisation> parse_quantisation(std::string_view text);
// "WIDTHxHEIGHT,WIDTHxHEIGHT". OPTION_SYNTAX with the position; LIMIT_EXCEEDED above kLayerLimit.
Result<std::vector<Size>> parse_sizes(std::string_view text);
// "X:Y:WIDTH:HEIGHT", in pixels; sides above 0. OPTION_SYNTAX with the position.
Result<Rect> parse_crop(std::string_view text);
// "X:Y", parts of the sides of a box. OPTION_SYNTAX with the position.
Result<Point> parse_shift(std::string_view text);
// TYPE_SYNTAX if the type is unknown.
Result<ElementType> parse_type(std::string_view text);

// Fills open fields from the card's only input or, if `input` is given, from the input with this
// name or, if none has it, with this number (from 0). CARD_INVALID if there are several inputs and
// `input` is empty, OPTION_VALUE if no input matches.
Result<Request> with_card(Request request, const card::Card& card, std::string_view input = "");

// The tensors that each frame of the request can have, preferred ones first: one tensor, or one for
// each layer of a pyramid. An open type is End; an open shape is not valid(). Without width and
// height the shape is open.
std::vector<std::vector<TensorSpec>> possible_frames(const Request& request);

// Fills open fields from `wanted`. Fields that are open there too become stretch, RGB, NHWC, and
// float32 with mean or scale or uint8 without. The caller sets the source. Errors: check_target().
// The result's tensor may differ from `wanted` if the request fixes it.
Result<Preparation> resolve(Request request, const TensorSpec& wanted);
// The same for each tensor of a frame. Tensors missing in `wanted` count as open.
Result<std::vector<Preparation>> resolve_frame(const Request& request,
                                               std::span<const TensorSpec> wanted);
// The tensors of a static frame that these preparations make.
std::vector<TensorSpec> make_output_specs(const Request& request,
                                          std::span<const Preparation> preparations);

}  // namespace weir::preprocess
