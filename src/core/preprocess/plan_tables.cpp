// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/plan_tables.hpp"

#include <algorithm>

namespace weir::preprocess {
namespace {

double at(const std::vector<double>& numbers, size_t channel, double otherwise) {
  if (numbers.empty()) return otherwise;
  return numbers.size() == 1 ? numbers[0] : numbers[channel];
}

struct LumaWeights {
  double red, blue;
};

// ITU-R BT.601-7 (2.5.1), BT.709-6 (3.2), BT.2020-2 (table 4).
LumaWeights luma_weights(ColorMatrix matrix) noexcept {
  switch (matrix) {
    case ColorMatrix::Bt601:
      break;
    case ColorMatrix::Bt709:
      return {0.2126, 0.0722};
    case ColorMatrix::Bt2020:
      return {0.2627, 0.0593};
  }
  return {0.299, 0.114};
}

// The colour matrix solved for R'G'B', including the range of luma and chroma.
void set_matrix(ColorMatrix matrix, ColorRange range, ColorTransform* out) {
  const auto [kr, kb] = luma_weights(matrix);
  const double kg = 1 - kr - kb;
  const bool full = range == ColorRange::Full;
  const double luma = full ? 1 : 255.0 / 219, chroma = full ? 1 : 255.0 / 224;
  const double black = full ? 0 : 16;
  const double red = 2 * (1 - kr) * chroma, blue = 2 * (1 - kb) * chroma;
  const double rows[3][3] = {
      {luma, 0, red}, {luma, -blue * kb / kg, -red * kr / kg}, {luma, blue, 0}};
  for (size_t r = 0; r < 3; ++r) {
    for (size_t c = 0; c < 3; ++c) out->of[r][c] = static_cast<float>(rows[r][c]);
    out->add[r] = static_cast<float>(-black * luma - 128 * (rows[r][1] + rows[r][2]));
  }
}

void lay_taps(Grid* grid) {
  const Axis& x = grid->columns;
  const size_t last = x.targets() - 1;
  grid->taps = x.max_weights();
  const size_t stride = padded(x.targets());
  grid->index.resize(stride * grid->taps);
  grid->weights.resize(stride * grid->taps);
  for (size_t t = 0; t < stride; ++t) {
    const size_t target = std::min(t, last);
    const auto weights = x.weights(target);
    for (size_t k = 0; k < grid->taps; ++k) {
      const size_t sample = x.first(target) - x.low() + std::min(k, weights.size() - 1);
      grid->index[k * stride + t] = static_cast<int32_t>(sample * grid->sampling.step);
      grid->weights[k * stride + t] = k < weights.size() ? weights[k] : 0.0f;
    }
  }
}

// A rotated region needs the sampling only.
void lay(Grid* grid, const Preparation& p, const Placement& place, const Component& component) {
  grid->sampling = component;
  if (place.rotated) return;
  Axis& x = grid->columns;
  const Sampling columns{component.halved_columns, p.source.cosited_columns};
  x.lay(p.resize, {place.source.x, place.source.width, place.content.width, place.columns},
        columns);
  grid->rows.lay(p.resize, {place.source.y, place.source.height, place.content.height, place.rows},
                 {component.halved_rows, p.source.cosited_rows});
  grid->first_byte = size_t{x.low()} * component.step;
  grid->bytes = size_t{x.high() - x.low()} * component.step;
  lay_taps(grid);
}

template <class Element>
void append(std::vector<std::byte>* out, const Element& element, size_t bytes) {
  const auto* from = reinterpret_cast<const std::byte*>(&element);
  out->insert(out->end(), from, from + bytes);
}

// Padding pixels go through the same conversion as all others.
std::vector<std::byte> padding_rows(const Preparation& p, const std::vector<NumberRule>& numbers) {
  const std::vector<float> row(padded(1), static_cast<float>(p.padding));
  const size_t bytes = element_size(p.type);
  std::vector<uint32_t> elements(numbers.size());
  for (size_t c = 0; c < numbers.size(); ++c) {
    std::vector<uint32_t> written(padded(1));
    write_numbers(numbers[c], p.type, row.data(), 1, written.data());
    elements[c] = written[0];
  }
  std::vector<std::byte> out;
  out.reserve(p.width * numbers.size() * bytes);
  if (p.layout == Layout::Nhwc) {
    for (uint32_t x = 0; x < p.width; ++x)
      for (const uint32_t element : elements) append(&out, element, bytes);
  } else {
    for (const uint32_t element : elements)
      for (uint32_t x = 0; x < p.width; ++x) append(&out, element, bytes);
  }
  return out;
}

}  // namespace

PlanTables::PlanTables(Preparation given)
    : preparation(std::move(given)), placement(place(preparation)) {
  const Preparation& p = preparation;
  lay_plane_grids();
  lay_colors();
  for (size_t c = 0; c < p.channels(); ++c) {
    NumberRule rule{static_cast<float>(at(p.mean, c, 0)), static_cast<float>(at(p.scale, c, 1)), 1,
                    0};
    if (p.quantisation) {
      rule.divisor = static_cast<float>(p.quantisation->scale);
      rule.zero_point = p.quantisation->zero_point;
    }
    numbers.push_back(rule);
  }
  if (p.fit == Fit::Letterbox || p.region) padding = padding_rows(p, numbers);
}

// Rows are in the order of the target's channels. With luma alone, each channel is the gray value.
void PlanTables::lay_colors() {
  const Preparation& p = preparation;
  constexpr float kGrayOfRgb[3] = {0.299f, 0.587f, 0.114f};
  const ColorModel model = p.source.format.model;
  colors.channels = p.channels();
  colors.samples = std::max(colors.channels, components.size());
  if (components.size() == 1) {
    component_of_sample.fill(0);
    colors.computed = p.source.range == ColorRange::Limited;
    const float luma = 255.0f / 219;
    for (size_t r = 0; r < 3; ++r) colors.of[r][0] = luma, colors.add[r] = -16 * luma;
    return;
  }
  const bool reversed = p.order == ChannelOrder::Bgr;
  colors.computed = model == ColorModel::Yuv || p.order == ChannelOrder::Gray;
  if (model == ColorModel::Yuv) {
    set_matrix(p.source.matrix, p.source.range, &colors);
    if (!reversed) return;
    std::swap(colors.of[0], colors.of[2]);
    std::swap(colors.add[0], colors.add[2]);
  } else if (p.order == ChannelOrder::Gray) {
    std::copy_n(kGrayOfRgb, 3, colors.of[0]);
  } else if (reversed) {
    std::swap(component_of_sample[0], component_of_sample[2]);
  }
}

void PlanTables::set_region(const Rect& picture, const Roi& region) {
  preparation.crop = picture;
  preparation.region = region;
  if (padding.empty()) padding = padding_rows(preparation, numbers);
  placement = place(preparation);
  lay_plane_grids();
}

void PlanTables::set_crop(const Rect& crop) {
  preparation.crop = crop;
  preparation.region.reset();
  placement = place(preparation);
  lay_plane_grids();
}

// Returns the matching one of the first `known` grids, or else adds a new one.
size_t PlanTables::find_grid(const Component& component, size_t known) {
  for (size_t i = 0; i < known; ++i)
    if (grids[i].sampling.same_grid(component)) return i;
  if (grids.size() == known) grids.emplace_back();
  lay(&grids[known], preparation, placement, component);
  return known;
}

// The numbers of grids and components stay the same because the format does not change.
void PlanTables::lay_plane_grids() {
  const PictureFormat& format = preparation.source.format;
  const bool luma_is_enough =
      format.model == ColorModel::Yuv && preparation.order == ChannelOrder::Gray;
  const size_t used = luma_is_enough ? 1 : format.component_count();
  size_t known = 0;
  plane_grids.clear();
  components.clear();
  for (size_t i = 0; i < used; ++i) {
    const Component& component = format.components[i];
    const bool shares_grid = i > 0 && format.components[i - 1].plane == component.plane &&
                             format.components[i - 1].same_grid(component);
    if (!shares_grid) {
      plane_grids.push_back({component.plane, find_grid(component, known)});
      known = std::max(known, plane_grids.back().grid + 1);
    }
    components.push_back({plane_grids.size() - 1, component.offset});
  }
}

}  // namespace weir::preprocess
