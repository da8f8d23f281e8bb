// Parses the two files of a Caffe network.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <limits>

#include "opencv-dnn/dnn_description.hpp"
#include "opencv-dnn/text_message.hpp"
#include "protobuf_reader.hpp"

namespace weir::engine {
namespace {

Error damaged(const std::string& offered) {
  return Error{.code = Code::MODEL_INVALID,
               .what = "the weights file is truncated, damaged or not a Caffe file",
               .offered = offered,
               .needed = "a complete .caffemodel",
               .fix = "download the .caffemodel again"};
}

DeclaredTensor make_input(std::string name, std::vector<int64_t> shape) {
  DeclaredTensor out;
  out.name = std::move(name);
  out.type = WEIR_FLOAT32;
  out.has_shape = !shape.empty() && shape.size() <= WEIR_RANK_LIMIT;
  for (auto& extent : shape)
    if (extent < 1 || extent > INT32_MAX) out.has_shape = false;
  if (out.has_shape) out.shape = std::move(shape);
  return out;
}

// Reads `input: "data"` with input_shape { dim: ... } or four input_dim each.
void old_inputs(const TextMessage& net, DnnDescription* out) {
  const auto shapes = net.messages("input_shape");
  const auto dims = net.numbers("input_dim");
  size_t index = 0;
  for (const auto& field : net.fields) {
    if (field.name != "input" || field.message) continue;
    std::vector<int64_t> shape;
    if (index < shapes.size())
      shape = shapes[index]->numbers("dim");
    else if (dims.size() >= 4 * index + 4)
      shape.assign(dims.begin() + static_cast<ptrdiff_t>(4 * index),
                   dims.begin() + static_cast<ptrdiff_t>(4 * index + 4));
    out->inputs.push_back(make_input(field.value, std::move(shape)));
    ++index;
  }
}

// Reads a layer of type Input: a shape for each `top`; the last one is for all that follow.
void layer_inputs(const TextMessage& layer, DnnDescription* out) {
  std::vector<std::vector<int64_t>> shapes;
  for (const auto* parameters : layer.messages("input_param"))
    for (const auto* shape : parameters->messages("shape")) shapes.push_back(shape->numbers("dim"));
  if (shapes.empty()) shapes.emplace_back();
  size_t index = 0;
  for (const auto& field : layer.fields) {
    if (field.name != "top") continue;
    out->inputs.push_back(make_input(field.value, shapes[std::min(index, shapes.size() - 1)]));
    ++index;
  }
}

// The shape of a blob, from shape { dim } or from num, channels, height, width; -1 = not given.
class Blob {
 public:
  Status read(std::span<const std::byte> bytes) {
    ProtobufReader reader(bytes);
    for (ProtobufReader::Field field; reader.next(&field);) {
      if (field.number >= 1 && field.number <= 4 && !field.delimited)
        multiply(static_cast<int64_t>(field.value));
      if (field.number == 5) values_ += floats_in(field);
      if (field.number == 7 && field.delimited)
        if (auto status = shape(field.bytes); !status) return status;
    }
    return reader.good() ? check() : damaged("a blob that is not a sequence of fields");
  }

 private:
  // Packed or separate.
  static uint64_t floats_in(const ProtobufReader::Field& field) {
    return field.delimited ? field.bytes.size() / sizeof(float) : 1;
  }
  Status check() const {
    if (has_shape_ && values_ > 0 && product_ != static_cast<int64_t>(values_))
      return damaged("a blob of " + std::to_string(values_) + " values whose shape requires " +
                     std::to_string(product_));
    return ok();
  }
  void multiply(int64_t extent) {
    constexpr int64_t kMax = int64_t{1} << 31;
    has_shape_ = true;
    product_ =
        extent < 0 || extent > kMax || product_ * extent > kMax ? kMax + 1 : product_ * extent;
    if (product_ > kMax) product_ = kMax;  // stays larger than any file
  }
  Status shape(std::span<const std::byte> bytes) {
    ProtobufReader reader(bytes);
    for (ProtobufReader::Field field; reader.next(&field);) {
      if (field.number != 1) continue;
      if (!field.delimited) {
        multiply(static_cast<int64_t>(field.value));
        continue;
      }
      uint64_t value = 0;
      unsigned shift = 0;
      for (const std::byte byte : field.bytes) {  // packed
        if (shift < 64) value |= (static_cast<uint64_t>(byte) & 0x7F) << shift;
        shift += 7;
        if (static_cast<uint64_t>(byte) >= 0x80) continue;
        multiply(static_cast<int64_t>(value));
        value = shift = 0;
      }
    }
    return reader.good() ? ok() : damaged("the shape of a blob");
  }

  int64_t product_ = 1;
  uint64_t values_ = 0;
  bool has_shape_ = false;
};

Status check_layer(std::span<const std::byte> bytes, uint32_t blobs) {
  ProtobufReader reader(bytes);
  for (ProtobufReader::Field field; reader.next(&field);)
    if (field.number == blobs && field.delimited)
      if (auto status = Blob().read(field.bytes); !status) return status;
  return reader.good() ? ok() : damaged("a layer that is not a sequence of fields");
}

}  // namespace

Result<DnnDescription> describe_caffe(std::string_view prototxt) {
  const auto net = read_text_message(prototxt);
  if (!net) return net.error();
  DnnDescription out;
  old_inputs(*net, &out);
  for (const char* kind : {"layer", "layers"})
    for (const auto* layer : net->messages(kind)) {
      const auto type = layer->text("type");
      out.nodes.insert(layer->text("name"));
      out.operators.insert(type);
      if (type == "Input") layer_inputs(*layer, &out);
    }
  if (out.operators.empty())
    return Error{.code = Code::MODEL_INVALID,
                 .what = "the description of the network has no layer",
                 .fix = "model=net.prototxt,net.caffemodel"};
  return out;
}

// NetParameter: field 2 holds layers of version 1, field 100 current ones; blobs are fields 6 and
// 7.
Status check_caffe_weights(std::span<const std::byte> caffemodel) {
  ProtobufReader reader(caffemodel);
  size_t layers = 0;
  for (ProtobufReader::Field field; reader.next(&field);) {
    if (field.number != 2 && field.number != 100) continue;
    if (!field.delimited) return damaged("an invalid layer");
    ++layers;
    if (auto status = check_layer(field.bytes, field.number == 2 ? 6 : 7); !status) return status;
  }
  if (!reader.good())
    return damaged(reader.missing() > 0 ? "the file ends at least " +
                                              std::to_string(reader.missing()) + " bytes too early"
                                        : "the file is not a sequence of fields");
  return layers > 0 ? ok() : damaged("it contains no layer");
}

}  // namespace weir::engine
