// Helpers of tests of modes that write results: outputs of a YOLOv8 for pictures of 32 x 32, the
// event that describes the model, and the rows of a frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstring>

#include "core/tensor/tensor_header.hpp"
#include "elements/tensor_decoder/decoder_test_support.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"
#include "gstcpp/element/model_event.hpp"
#include "weir/results.hpp"

namespace weir::testing_tensor_decoder {

constexpr size_t kCells = 21;  // 16 + 4 + 1
constexpr size_t kValues = 7;  // the box, 3 classes

struct Seen {
  size_t cell;
  float x, y, width, height;  // centre and size
  size_t class_index;
  float score;
};
inline std::vector<float> yolo(const std::vector<Seen>& objects) {
  std::vector<float> out(kCells * kValues, 0.0f);
  for (const Seen& o : objects) {
    const float box[] = {o.x, o.y, o.width, o.height};
    for (size_t i = 0; i < 4; ++i) out[i * kCells + o.cell] = box[i];
    out[(4 + o.class_index) * kCells + o.cell] = o.score;
  }
  return out;
}
const std::vector<Seen> kTwo{{3, 16, 8, 4, 6, 1, 0.9f}, {20, 10, 20, 8, 2, 0, 0.5f}};

inline DescribedModel yolo_model(const std::string& name = "shapes") {
  DescribedModel model;
  model.inputs.push_back(
      {.type = ElementType::UInt8, .rank_known = true, .shape = {1, 32, 32, 3}, .name = {}});
  model.outputs.push_back(
      {.type = ElementType::Float32, .rank_known = true, .shape = {1, 7, 21}, .name = "output0"});
  model.path = "/models/" + name + ".onnx";
  return model;
}
const std::string kYoloCaps = tensor("float32", "21:7:1");
inline const std::string kFlexible = "other/tensors,format=flexible,framerate=30/1";

// A frame of a flexible stream.
inline GstBuffer* with_header(const std::vector<float>& values, const Shape& shape) {
  TensorHeader header;
  header.format = Format::Flexible;
  header.spec = {.type = ElementType::Float32, .shape = shape, .name = {}};
  Bytes bytes(kTensorHeaderBytes + values.size() * sizeof(float));
  write_tensor_header(header, std::as_writable_bytes(std::span(bytes)).first<kTensorHeaderBytes>());
  std::memcpy(bytes.data() + kTensorHeaderBytes, values.data(), values.size() * sizeof(float));
  return frame(bytes);
}

// The rows of tensor `index` of a frame of results; "class:score@x1,y1,x2,y2^parent" of each.
inline std::vector<std::string> read_rows(GstBuffer* buffer, GstCaps* caps, size_t index = 0) {
  std::vector<std::string> out;
  const auto roles = gst::roles_from_caps(caps);
  gst::FrameLayout reader;
  const auto read = reader.read(buffer, {Format::Flexible, {}, {}});
  if (!read) return {read.error().message()};
  if (index >= roles.size() || index >= reader.tensors().size()) return {"no such tensor"};
  const auto columns = result_columns(roles[index].columns, 0);
  if (!columns || columns->kind != WEIR_RESULT_ROWS) return {"no rows"};
  const auto& payload = reader.tensors()[index].payload;
  std::vector<float> numbers(payload.size() / sizeof(float));
  std::memcpy(numbers.data(), payload.data(), payload.size());
  for (size_t at = 0; at + columns->length <= numbers.size(); at += columns->length) {
    const ResultRow row(*columns, numbers.data() + at);
    if (row.is_background()) {
      out.push_back("background");
      continue;
    }
    char text[160];
    std::snprintf(text, sizeof text, "%d:%g@%g,%g,%g,%g^%d", row.class_index(), row.score(),
                  row.box().x1, row.box().y1, row.box().x2, row.box().y2, row.parent());
    out.push_back(text);
  }
  return out;
}
inline std::vector<std::string> read_rows(const Harness& h, GstBuffer* buffer, size_t index = 0) {
  const auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(h->sinkpad));
  return read_rows(buffer, caps.get(), index);
}
using Rows = std::vector<std::string>;

}  // namespace weir::testing_tensor_decoder
