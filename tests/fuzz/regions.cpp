// Fuzz target: parses the regions of tensor_crop. For any values each region is inside the cropped
// tensor, and every group of four values is counted once.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <vector>

#include "core/crop/regions.hpp"
#include "fuzz_input.hpp"

namespace {

// Crops each region out of a tensor whose bytes are all 5.
void cut_all(const weir::TensorSpec& whole, const weir::Regions& regions) {
  const std::vector<std::byte> in(static_cast<size_t>(*whole.bytes()), std::byte{5});
  for (const auto& region : regions.inside) {
    const auto layout = weir::make_layout(whole, region);
    const auto part = weir::make_part_spec(whole, region);
    const auto extent = weir::find_extent(part, layout);
    weir::fuzz::require(extent && *extent <= in.size(), "a region lies inside the memory");
    std::vector<std::byte> out(static_cast<size_t>(*part.bytes()));
    weir::cut(whole, in, region, out);
    weir::fuzz::require(out.front() == std::byte{5} && out.back() == std::byte{5},
                        "a cut copies the tensor's bytes");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  weir::fuzz::FuzzInput input(data, size);
  const weir::TensorSpec numbers{static_cast<weir::ElementType>(input.below(11)), weir::Shape{4, 1},
                                 ""};
  const bool large = input.flag();
  const auto type = static_cast<weir::ElementType>(input.below(11));
  // A large tensor exists only as a shape: no region of it is copied.
  const auto side = [&] { return large ? input.take<uint32_t>() : input.below(40) + 1; };
  const uint32_t channels = input.below(5) + 1, width = side(), height = side();
  const weir::TensorSpec whole{type, weir::Shape{channels, width, height}, ""};
  const auto payload = input.rest();
  const auto regions = weir::read_regions(numbers, payload, width, height);
  weir::fuzz::require(regions.inside.size() <= weir::kTensorLimit,
                      "a frame has at most 256 tensors");
  const uint64_t groups = payload.size() / weir::element_size(numbers.type) / 4;
  weir::fuzz::require(regions.inside.size() + regions.empty + regions.beyond_limit == groups,
                      "every group of four numbers is counted once");
  for (const auto& region : regions.inside)
    weir::fuzz::require(region.width > 0 && region.height > 0 &&
                            uint64_t{region.x} + region.width <= width &&
                            uint64_t{region.y} + region.height <= height,
                        "a region lies inside the tensor");
  if (!large) cut_all(whole, regions);
  return 0;
}
