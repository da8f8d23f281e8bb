// Fuzz target: reads detections of any shape and value, maps them with source maps and draws them
// into a picture of any format; also the boxes of tensor_preprocess. Every row is counted once, and
// nothing is drawn outside.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <array>
#include <memory>
#include <vector>

#include "core/draw/overlay.hpp"
#include "core/preprocess/boxes.hpp"
#include "core/tensor/geometry.hpp"
#include "fuzz_input.hpp"

namespace {

using namespace weir;
using fuzz::FuzzInput;
using fuzz::require;

constexpr uint32_t kMaxBytes = 1 << 16;  // per plane

class BoxPainter : public draw::TextPainter {
 public:
  draw::Mask paint(const std::string& text) override {
    draw::Mask mask{static_cast<uint32_t>(3 * text.size()), 5, {}};
    mask.coverage.assign(size_t{mask.width} * mask.height, 200);
    return mask;
  }
};

SourceMap map_from(FuzzInput* input) {
  SourceMap map;
  for (double* number : {&map.xx, &map.xy, &map.x0, &map.yx, &map.yy, &map.y0})
    *number = input->take<float>();
  map.source_width = input->take<uint16_t>();
  map.source_height = input->take<uint16_t>();
  return map;
}

void draw_on_picture(const draw::Detections& detections, FuzzInput* input) {
  preprocess::Picture picture;
  const auto formats = preprocess::picture_formats();
  picture.format = formats[input->below(static_cast<uint32_t>(formats.size()))];
  picture.width = input->byte();
  picture.height = input->byte();
  std::array<std::vector<std::byte>, 3> memories;
  draw::Planes planes;
  for (size_t i = 0; i < planes.size(); ++i) {
    memories[i].resize(input->take<uint16_t>());
    planes[i] = {memories[i], input->take<uint16_t>(), input->take<int16_t>()};
  }
  auto canvas = draw::Canvas::make(picture, planes);
  if (!canvas) {
    require(!canvas.error().what.empty(), "an error has a text");
    return;
  }
  draw::Style style{input->below(12), input->below(12), input->take<float>()};
  draw::Labels labels({{"cat", "a dog", ""}}, input->flag(), std::make_shared<BoxPainter>(),
                      picture.format);
  const auto drawn = draw::draw(detections, style, input->flag() ? &labels : nullptr, &*canvas);
  require(drawn.boxes + drawn.outside + drawn.below_score == detections.rows.size(),
          "every row is drawn, outside or below the score");
}

void read_boxes(const TensorSpec& spec, std::span<const std::byte> bytes) {
  if (!preprocess::check_boxes(spec)) return;
  std::vector<preprocess::PictureBox> boxes;
  preprocess::read_boxes(spec, bytes, &boxes);
  for (const auto& box : boxes) {
    const Rect whole{7, 9, 640, 480};
    const auto part = preprocess::common_part(whole, preprocess::make_region(box, {}));
    require(part.x >= 7 && uint64_t{part.x} + part.width <= 647 && part.y >= 9 &&
                uint64_t{part.y} + part.height <= 489,
            "a part of a picture lies inside");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzInput input(data, size);
  const auto type = static_cast<ElementType>(input.below(11));
  const TensorSpec spec{type, Shape{input.take<uint16_t>(), input.take<uint16_t>(), 1u}, ""};
  const uint32_t n_maps = input.below(4);
  std::vector<SourceMap> maps;
  for (uint32_t i = 0; i < n_maps; ++i) maps.push_back(map_from(&input));
  const auto bytes = input.bytes(kMaxBytes);
  const auto status = draw::check_detections(spec);
  read_boxes(spec, bytes);
  if (!status) return 0;
  const auto detections = draw::read_detections(spec, bytes, maps);
  if (!detections) return 0;
  const auto& out = detections->left_out;
  require(detections->rows.size() + out.background + out.not_finite + out.without_area +
                  out.beyond_limit ==
              bytes.size() / (spec.shape[0] * sizeof(float)),
          "every row is counted once");
  require(detections->points.size() == detections->rows.size() * detections->points_per_row,
          "every row has its key points");
  FuzzInput again(data, size);  // the same bytes select the picture
  draw_on_picture(*detections, &again);
  return 0;
}
