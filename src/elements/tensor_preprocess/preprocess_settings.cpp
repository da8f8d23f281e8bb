// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_preprocess/preprocess_settings.hpp"
#include "core/tensor/geometry.hpp"

namespace weir {
namespace {

template <class Value, class Choice>
std::optional<Value> chosen(Choice choice) {
  if (choice == Choice::Auto) return std::nullopt;
  return static_cast<Value>(choice);
}

}  // namespace

Result<std::optional<Rect>> parse_crop(const PreprocessSettings& s) {
  if (s.crop.empty()) return std::optional<Rect>();
  const auto crop = preprocess::parse_crop(s.crop);
  if (!crop) return crop.error();
  return std::optional(*crop);
}

namespace {

Status read_sizes(const PreprocessSettings& s, preprocess::Request* request) {
  if (!s.sizes.empty()) {
    if (s.width != 0 || s.height != 0)
      return Error{.code = Code::OPTION_VALUE,
                   .what = "sizes cannot be combined with width and height",
                   .offered = "width=" + std::to_string(s.width) +
                              " height=" + std::to_string(s.height) + " sizes=" + s.sizes,
                   .needed = "either width and height, or sizes",
                   .fix = "tensor_preprocess sizes=" + s.sizes};
    auto sizes = preprocess::parse_sizes(s.sizes);
    if (!sizes) return sizes.error();
    request->sizes = *std::move(sizes);
  }
  return ok();
}

Status check_regions(const PreprocessSettings& s) {
  const bool has_regions = s.regions != RegionsChoice::None;
  if (has_regions && !s.sizes.empty())
    return Error{.code = Code::OPTION_VALUE,
                 .what = "regions have one size, a pyramid has several",
                 .offered = "regions and sizes=" + s.sizes,
                 .needed = "either regions, width and height, or sizes",
                 .fix = "tensor_preprocess regions=meta width=48 height=48"};
  if (!has_regions && s.max_regions > 0)
    return Error{
        .code = Code::OPTION_VALUE,
        .what = "max-regions without regions has no effect",
        .offered = "max-regions=" + std::to_string(s.max_regions),
        .needed = "regions=meta, regions=pad, or no max-regions",
        .fix = "tensor_preprocess regions=meta max-regions=" + std::to_string(s.max_regions)};
  if (!has_regions && !s.clip_regions)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "clip-regions without regions has no effect",
                 .offered = "clip-regions=false",
                 .needed = "regions=meta, regions=pad, or no clip-regions",
                 .fix = "tensor_preprocess regions=meta clip-regions=false"};
  return ok();
}

Status read_region_shape(const PreprocessSettings& s, preprocess::Request* request) {
  preprocess::RegionShape& shape = request->region_shape;
  shape.scale = double{s.region_scale};
  shape.is_square = s.square_regions;
  shape.follows_rotation = s.rotate_regions;
  if (!s.region_shift.empty()) {
    const auto shift = preprocess::parse_shift(s.region_shift);
    if (!shift) return shift.error();
    shape.shift_x = shift->x, shape.shift_y = shift->y;
  }
  if (s.regions == RegionsChoice::None && !(shape == preprocess::RegionShape{}))
    return Error{.code = Code::OPTION_VALUE,
                 .what = "the shape of regions without regions has no effect",
                 .offered = "region-scale, region-shift, square-regions or rotate-regions",
                 .needed = "regions=meta or regions=pad",
                 .fix = "tensor_preprocess regions=meta"};
  if (s.rotate_regions && s.regions == RegionsChoice::Meta)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "the regions of metadata have no rotation",
                 .offered = "regions=meta rotate-regions=true",
                 .needed = "regions=pad, or no rotate-regions",
                 .fix = "tensor_preprocess regions=meta"};
  if (s.rotate_regions && s.clip_regions)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "rotated regions cannot be clipped to the picture",
                 .offered = "rotate-regions=true clip-regions=true",
                 .needed = "clip-regions=false",
                 .fix = "tensor_preprocess regions=pad rotate-regions=true clip-regions=false"};
  return ok();
}

// What is set instead of what the model's card says.
Status read_numbers(const PreprocessSettings& s, preprocess::Request* request) {
  if (!s.mean.empty()) {
    auto mean = preprocess::parse_numbers("mean", s.mean);
    if (!mean) return mean.error();
    request->mean = *std::move(mean);
  }
  if (!s.scale.empty()) {
    auto scale = preprocess::parse_numbers("scale", s.scale);
    if (!scale) return scale.error();
    request->scale = *std::move(scale);
  }
  if (!s.quantisation.empty()) {
    auto quantisation = preprocess::parse_quantisation(s.quantisation);
    if (!quantisation) return quantisation.error();
    request->quantisation = *quantisation;
  }
  if (!s.type.empty()) {
    auto type = preprocess::parse_type(s.type);
    if (!type) return type.error();
    request->type = *type;
  }
  return ok();
}

}  // namespace

Result<preprocess::Request> make_request(const PreprocessSettings& s) {
  preprocess::Request request;
  request.width = s.width;
  request.height = s.height;
  if (auto status = read_sizes(s, &request); !status) return status.error();
  request.regions = s.regions != RegionsChoice::None;
  request.max_regions = s.max_regions;
  if (auto status = check_regions(s); !status) return status.error();
  request.clip_regions = s.clip_regions;
  if (auto status = read_region_shape(s, &request); !status) return status.error();
  request.resize = s.method;
  request.padding = s.padding_value;
  request.fit = chosen<preprocess::Fit>(s.fit);
  request.order = chosen<preprocess::ChannelOrder>(s.channel_order);
  request.layout = chosen<preprocess::Layout>(s.layout);
  if (auto status = read_numbers(s, &request); !status) return status.error();
  if (s.card.empty() && !s.card_input.empty())
    return Error{.code = Code::OPTION_VALUE,
                 .what = "card-input without a card has no effect",
                 .offered = "card-input=" + s.card_input,
                 .needed = "card and card-input, or neither",
                 .fix = "tensor_preprocess card=model.card.json card-input=" + s.card_input};
  if (s.card.empty()) return request;
  const auto card = card::read(s.card);
  if (!card) return card.error();
  return preprocess::with_card(std::move(request), *card, s.card_input);
}

}  // namespace weir
