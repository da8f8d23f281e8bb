// Builds small networks for tests: protobuf messages field by field, Caffe blobs, TensorFlow nodes
// and Darknet weights.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace weir::engine_test {

class MessageBuilder {
 public:
  MessageBuilder& number(uint32_t field, uint64_t value) {
    varint(field << 3);
    varint(value);
    return *this;
  }
  MessageBuilder& bytes(uint32_t field, const std::string& value) {
    varint(field << 3 | 2);
    varint(value.size());
    text_ += value;
    return *this;
  }
  MessageBuilder& message(uint32_t field, const MessageBuilder& value) {
    return bytes(field, value.text_);
  }
  const std::string& text() const { return text_; }

 private:
  void varint(uint64_t value) {
    for (; value >= 0x80; value >>= 7) text_ += static_cast<char>(value | 0x80);
    text_ += static_cast<char>(value);
  }
  std::string text_;
};

template <class T>
std::string raw(const std::vector<T>& values) {
  return std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

// caffe.proto: LayerParameter name 1, type 2, blobs 7; BlobProto data 5, shape 7 { dim 1 }.
struct CaffeBlob {
  std::vector<uint64_t> shape;
  std::vector<float> values;
};
inline MessageBuilder caffe_layer(const std::string& name, const std::string& type,
                                  const std::vector<CaffeBlob>& blobs) {
  MessageBuilder layer;
  layer.bytes(1, name).bytes(2, type);
  for (const auto& blob : blobs) {
    MessageBuilder shape;
    for (const auto extent : blob.shape) shape.number(1, extent);
    layer.message(7, MessageBuilder().bytes(5, raw(blob.values)).message(7, shape));
  }
  return layer;
}
inline std::string caffemodel(const std::vector<MessageBuilder>& layers) {
  MessageBuilder net;
  for (const auto& layer : layers) net.message(100, layer);
  return net.text();
}

// node_def.proto: name 1, op 2, input 3, attr 5 { key 1, value 2 }; attr_value.proto: list 1, s 2,
// type 6, shape 7, tensor 8.
class TensorflowNode {
 public:
  TensorflowNode(const std::string& name, const std::string& op,
                 const std::vector<std::string>& inputs = {}) {
    node_.bytes(1, name).bytes(2, op);
    for (const auto& input : inputs) node_.bytes(3, input);
  }
  TensorflowNode& attribute(const std::string& key, const MessageBuilder& value) {
    node_.message(5, MessageBuilder().bytes(1, key).message(2, value));
    return *this;
  }
  TensorflowNode& type(const std::string& key, uint64_t type = 1) {
    return attribute(key, MessageBuilder().number(6, type));
  }
  TensorflowNode& text(const std::string& key, const std::string& value) {
    return attribute(key, MessageBuilder().bytes(2, value));
  }
  TensorflowNode& numbers(const std::string& key, const std::vector<uint64_t>& values) {
    MessageBuilder list;
    for (const auto value : values) list.number(3, value);
    return attribute(key, MessageBuilder().message(1, list));
  }
  const MessageBuilder& message() const { return node_; }

 private:
  MessageBuilder node_;
};

inline MessageBuilder tensorflow_shape(const std::vector<int64_t>& shape) {
  MessageBuilder out;
  for (const auto extent : shape)
    out.message(2, MessageBuilder().number(1, static_cast<uint64_t>(extent)));
  return out;
}
inline TensorflowNode placeholder(const std::string& name, const std::vector<int64_t>& shape,
                                  uint64_t type = 1) {
  return TensorflowNode(name, "Placeholder")
      .type("dtype", type)
      .attribute("shape", MessageBuilder().message(7, tensorflow_shape(shape)));
}
// tensor.proto: dtype 1, tensor_shape 2, tensor_content 4.
inline TensorflowNode constant(const std::string& name, const std::vector<int64_t>& shape,
                               const std::vector<float>& values) {
  MessageBuilder tensor;
  tensor.number(1, 1).message(2, tensorflow_shape(shape)).bytes(4, raw(values));
  return TensorflowNode(name, "Const")
      .type("dtype")
      .attribute("value", MessageBuilder().message(8, tensor));
}
inline std::string graph(const std::vector<TensorflowNode>& nodes) {
  MessageBuilder out;
  for (const auto& node : nodes) out.message(1, node.message());
  return out.text();
}

// Darknet weights, version 0.2: three int32, the number of images seen as int64, then floats.
inline std::string darknet_weights(const std::vector<float>& values) {
  return raw(std::vector<int32_t>{0, 2, 0}) + raw(std::vector<int64_t>{0}) + raw(values);
}

}  // namespace weir::engine_test
