// Stretch, letterbox and centred crop.
#include "core/preprocess/placement.hpp"

#include <algorithm>

namespace weir::preprocess {
namespace {

// a * b / c to the nearest, at least 1 and at most `limit`.
uint32_t in_proportion(uint32_t a, uint32_t b, uint32_t c, uint32_t limit) noexcept {
  const uint64_t rounded = (uint64_t{2} * a * b + c) / (uint64_t{2} * c);
  return static_cast<uint32_t>(std::clamp<uint64_t>(rounded, 1, limit));
}

// The biggest part of `whole` with the proportions of `shape`, in its middle.
Rect middle(const Rect& whole, const Rect& shape) noexcept {
  Rect out = whole;
  const bool too_wide = uint64_t{whole.width} * shape.height > uint64_t{whole.height} * shape.width;
  if (too_wide)
    out.width = in_proportion(whole.height, shape.width, shape.height, whole.width);
  else
    out.height = in_proportion(whole.width, shape.height, shape.width, whole.height);
  out.x += (whole.width - out.width) / 2;
  out.y += (whole.height - out.height) / 2;
  return out;
}

}  // namespace

Placement place(const Preparation& p) noexcept {
  Placement out{p.crop.value_or(Rect{0, 0, p.source.width, p.source.height}),
                Rect{0, 0, p.width, p.height}};
  if (p.fit == Fit::Letterbox) out.content = middle(out.content, out.source);
  if (p.fit == Fit::CentreCrop) out.source = middle(out.source, out.content);
  return out;
}

PictureMap way_back(const Preparation& p) noexcept {
  const auto [source, content] = place(p);
  const double scale_x = static_cast<double>(source.width) / content.width;
  const double scale_y = static_cast<double>(source.height) / content.height;
  return picture_as_it_is(p.source.width, p.source.height, p.layout == Layout::Nchw)
      .of_part(scale_x, source.x - scale_x * content.x, scale_y, source.y - scale_y * content.y,
               p.width, p.height);
}

}  // namespace weir::preprocess
