// Fuzz target: preprocesses planes of any size, offset and stride. Rejections have a text; accepted
// plans stay within their memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <vector>

#include "core/preprocess/plan.hpp"
#include "core/preprocess/request.hpp"
#include "fuzz_input.hpp"

namespace {

using namespace weir::preprocess;
using weir::fuzz::FuzzInput;
using weir::fuzz::require;

double number(FuzzInput* in) {
  return (static_cast<double>(in->take<uint16_t>()) - 32768) / 64;
}

// Usually small; any 32 bits after a byte of 255.
uint32_t side(FuzzInput* in) {
  const uint8_t small = in->byte();
  return small == 255 ? in->take<uint32_t>() : small;
}

int64_t edge(FuzzInput* in) {
  const auto near = in->take<int8_t>();
  return near == -128 ? in->take<int64_t>() : near;
}

Preparation preparation_from(FuzzInput* in) {
  Preparation p;
  p.source.format = picture_formats()[in->byte() % picture_formats().size()];
  p.source.width = side(in);
  p.source.height = side(in);
  p.source.matrix = static_cast<ColorMatrix>(in->byte() % 3);
  p.source.range = static_cast<ColorRange>(in->byte() % 2);
  p.source.cosited_columns = in->byte() % 2;
  p.source.cosited_rows = in->byte() % 2;
  if (in->byte() % 2) p.crop = weir::Rect{side(in), side(in), side(in), side(in)};
  p.width = side(in);
  p.height = side(in);
  p.resize = static_cast<Resize>(in->byte() % 3);
  p.fit = static_cast<Fit>(in->byte() % 3);
  p.padding = in->byte();
  p.order = static_cast<ChannelOrder>(in->byte() % 3);
  p.layout = static_cast<Layout>(in->byte() % 2);
  p.type = static_cast<weir::ElementType>(in->byte() % 11);
  for (uint32_t i = in->byte() % 5; i > 0; --i) p.mean.push_back(number(in));
  for (uint32_t i = in->byte() % 5; i > 0; --i) p.scale.push_back(number(in));
  if (in->byte() % 2)
    p.quantisation = Quantisation{number(in), static_cast<int32_t>(in->byte()) - 128};
  return p;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzInput in(data, size);
  Preparation p = preparation_from(&in);
  Planes planes;
  std::vector<std::vector<std::byte>> memories;
  for (auto& plane : planes) {
    memories.emplace_back(in.take<uint16_t>());
    plane = {memories.back(), in.take<uint16_t>(),
             static_cast<ptrdiff_t>(in.take<uint16_t>()) - 4096};
  }
  if (in.byte() % 2) p.region = Roi{edge(&in), edge(&in), edge(&in), edge(&in)};
  const auto numbers = parse_numbers("mean", in.text());
  const auto quantisation = parse_quantisation(in.text());
  const auto plan = PreprocessPlan::make(p);
  if (!plan) {
    require(!plan.error().what.empty(), "an error has a text");
    return 0;
  }
  constexpr uint64_t kMax = 1 << 22;  // limit of bytes written here; plans are made for any size
  if (*p.tensor().bytes() > kMax) return 0;
  std::vector<std::byte> out(*p.tensor().bytes());
  auto workspace = plan->workspace();
  const auto status = plan->run(planes, out, &workspace);
  require(status || !status.error().what.empty(), "an error has a text");
  return 0;
}
