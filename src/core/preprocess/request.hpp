// Request: a preparation of which parts may be open, to be filled in by a model card and by the
// tensor that is wanted behind.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/card/card.hpp"
#include "core/preprocess/preparation.hpp"

namespace weir::preprocess {

struct Size {
  uint32_t width = 0, height = 0;
  bool operator==(const Size&) const = default;
};
inline constexpr size_t kLayerLimit = 16;  // of a pyramid

struct Request {
  uint32_t width = 0, height = 0;  // 0 = open
  std::vector<Size> sizes;         // of a pyramid's layers, instead of width and height
  Resize resize = Resize::Bilinear;
  double padding = 0;
  bool regions = false;       // a batch of parts of the picture, outermost dimension
  uint32_t most_regions = 0;  // of a static batch; 0 = flexible
  bool clip_regions = true;   // else padding stands for what is outside of the picture
  std::optional<Fit> fit;
  std::optional<ChannelOrder> order;
  std::optional<std::vector<double>> mean, scale;
  std::optional<Quantisation> quantisation;
  std::optional<ElementType> type;
  std::optional<Layout> layout;
};

// "127.5" or "123.675,116.28,103.53". OPTION_SYNTAX with the place; `name` is the option's.
Result<std::vector<double>> parse_numbers(std::string_view name, std::string_view text);
// "SCALE:ZERO_POINT". OPTION_SYNTAX with the place.
Result<Quantisation> parse_quantisation(std::string_view text);
// "WIDTHxHEIGHT,WIDTHxHEIGHT". OPTION_SYNTAX with the place; LIMIT_EXCEEDED beyond kLayerLimit.
Result<std::vector<Size>> parse_sizes(std::string_view text);
// "X:Y:WIDTH:HEIGHT", in pixels; sides above 0. OPTION_SYNTAX with the place.
Result<Rect> parse_crop(std::string_view text);
// TYPE_SYNTAX.
Result<ElementType> parse_type(std::string_view text);

// What is open becomes what the card says of its only input, or of the one with this name or, where
// none has it, this number from 0 on. CARD_INVALID when there are several and `input` is empty,
// OPTION_VALUE when there is none of them.
Result<Request> with_card(Request request, const card::Card& card, std::string_view input = "");

// A tensor of which type and shape may be open (End, not valid).
// What each frame of the request can be, the preferred ones first: one tensor, or one for each
// layer. Without width and height the shape is open.
std::vector<std::vector<TensorSpec>> possible_frames(const Request& request);

// What is open becomes what `wanted` says, and where that is open too: stretch, RGB, NHWC, float32
// with mean or scale and uint8 without. The source is left for the caller. Errors: check_target().
// The tensor of the result may be another than `wanted` where the request is not open.
Result<Preparation> resolve(Request request, const TensorSpec& wanted);
// The same for each tensor of a frame. Tensors that are not in `wanted` are open there.
Result<std::vector<Preparation>> resolve_frame(const Request& request,
                                               std::span<const TensorSpec> wanted);
// The tensors of a static frame of these.
std::vector<TensorSpec> tensors_of(const Request& request,
                                   std::span<const Preparation> preparations);

}  // namespace weir::preprocess
