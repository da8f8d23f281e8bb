// Writes parents before children: offsets to objects count forward only.
#include "tensorflow-lite/tflite_builder.hpp"

#include <cstring>

namespace weir::engine_test {
namespace {

using Object = std::shared_ptr<FlatObject>;

template <class T>
std::vector<std::byte> raw(T value) {
  std::vector<std::byte> out(sizeof value);
  std::memcpy(out.data(), &value, sizeof value);
  return out;
}
template <class T>
Object scalars(const std::vector<T>& values) {
  auto out = std::make_shared<FlatObject>();
  out->kind = FlatObject::Scalars;
  out->count = static_cast<uint32_t>(values.size());
  out->bytes.resize(values.size() * sizeof(T));
  if (!values.empty()) std::memcpy(out->bytes.data(), values.data(), out->bytes.size());
  return out;
}
Object string(const std::string& text) {
  auto out = scalars(std::vector<char>(text.begin(), text.end()));
  out->bytes.push_back(std::byte{0});  // not counted
  return out;
}
Object objects(const std::vector<Object>& elements) {
  auto out = std::make_shared<FlatObject>();
  out->kind = FlatObject::Objects;
  out->elements = elements;
  out->count = static_cast<uint32_t>(elements.size());
  return out;
}

class Writer {
 public:
  std::vector<std::byte> file(const Object& root) {
    put<uint32_t>(0);
    for (const char c : {'T', 'F', 'L', '3'}) out_.push_back(static_cast<std::byte>(c));
    patch(0, object(*root));
    return std::move(out_);
  }

 private:
  template <class T>
  void put(T value) {
    for (const auto byte : raw(value)) out_.push_back(byte);
  }
  void align(size_t to) {
    while (out_.size() % to != 0) out_.push_back(std::byte{0});
  }
  void patch(size_t at, size_t target) {
    const auto offset = static_cast<uint32_t>(target - at);
    std::memcpy(out_.data() + at, &offset, sizeof offset);
  }
  size_t object(const FlatObject& object) {
    if (object.kind == FlatObject::Table) return table(object);
    // The elements, behind the count, are aligned for tensors.
    do align(4);
    while ((out_.size() + 4) % 16 != 0 && (out_.push_back(std::byte{0}), true));
    const size_t at = out_.size();
    put(object.count);
    out_.insert(out_.end(), object.bytes.begin(), object.bytes.end());
    for (size_t i = 0; i < object.elements.size(); ++i) put<uint32_t>(0);
    for (size_t i = 0; i < object.elements.size(); ++i)
      patch(at + 4 + 4 * i, this->object(*object.elements[i]));
    return at;
  }
  size_t table(const FlatObject& object) {
    uint32_t fields = 0;
    for (const auto& [field, value] : object.scalars) fields = std::max(fields, field + 1);
    for (const auto& [field, value] : object.fields) fields = std::max(fields, field + 1);
    std::vector<uint16_t> places(fields, 0);
    uint16_t size = 4;
    for (const auto& [field, value] : object.fields) places[field] = size, size += 4;
    for (const auto& [field, value] : object.scalars) {
      const auto bytes = static_cast<uint16_t>(value.size());
      size = static_cast<uint16_t>((size + bytes - 1) / bytes * bytes);
      places[field] = size, size = static_cast<uint16_t>(size + bytes);
    }
    align(8);
    const size_t vtable = out_.size();
    put<uint16_t>(static_cast<uint16_t>(4 + 2 * fields));
    put<uint16_t>(size);
    for (const auto place : places) put(place);
    align(8);
    const size_t at = out_.size();
    out_.resize(at + size);
    const auto back = static_cast<int32_t>(at - vtable);
    std::memcpy(out_.data() + at, &back, sizeof back);
    for (const auto& [field, value] : object.scalars)
      std::memcpy(out_.data() + at + places[field], value.data(), value.size());
    for (const auto& [field, value] : object.fields)
      patch(at + places[field], this->object(*value));
    return at;
  }

  std::vector<std::byte> out_;
};

}  // namespace

int32_t TfliteBuilder::tensor(const std::string& name, TfliteElement type,
                              const std::vector<int32_t>& shape, float scale, int64_t zero_point) {
  auto out = std::make_shared<FlatObject>();
  std::vector<int32_t> closed = shape;
  bool open = false;
  for (auto& extent : closed)
    if (extent < 0) extent = 1, open = true;
  out->fields[0] = scalars(closed);
  out->scalars[1] = raw<uint8_t>(type);
  out->scalars[2] = raw<uint32_t>(0);
  out->fields[3] = string(name);
  if (scale != 0) {
    auto quantization = std::make_shared<FlatObject>();
    quantization->fields[2] = scalars(std::vector<float>{scale});
    quantization->fields[3] = scalars(std::vector<int64_t>{zero_point});
    out->fields[4] = quantization;
  }
  if (open) out->fields[7] = scalars(shape);
  tensors_.push_back(out);
  return static_cast<int32_t>(tensors_.size() - 1);
}

int32_t TfliteBuilder::constant(const std::string& name, const std::vector<int32_t>& values) {
  const auto index = tensor(name, kTfInt32, {static_cast<int32_t>(values.size())});
  auto buffer = std::make_shared<FlatObject>();
  auto data = scalars(values);
  data->count = static_cast<uint32_t>(data->bytes.size());
  buffer->fields[0] = data;
  buffers_.push_back(buffer);
  tensors_.back()->scalars[2] = raw(static_cast<uint32_t>(buffers_.size()));  // 0 is the empty one
  return index;
}

TfliteBuilder& TfliteBuilder::operation(TfliteOperator code, const std::vector<int32_t>& inputs,
                                        const std::vector<int32_t>& outputs,
                                        const std::string& custom) {
  auto kind = std::make_shared<FlatObject>();
  kind->scalars[0] = raw(static_cast<int8_t>(code));
  kind->scalars[2] = raw<int32_t>(1);
  kind->scalars[3] = raw<int32_t>(code);
  if (!custom.empty()) kind->fields[1] = string(custom);
  auto out = std::make_shared<FlatObject>();
  out->scalars[0] = raw(static_cast<uint32_t>(codes_.size()));
  out->fields[1] = scalars(inputs);
  out->fields[2] = scalars(outputs);
  codes_.push_back(kind);
  operators_.push_back(out);
  return *this;
}

TfliteBuilder& TfliteBuilder::inputs(const std::vector<int32_t>& tensors) {
  inputs_ = tensors;
  return *this;
}
TfliteBuilder& TfliteBuilder::outputs(const std::vector<int32_t>& tensors) {
  outputs_ = tensors;
  return *this;
}

std::vector<std::byte> TfliteBuilder::bytes() const {
  auto graph = std::make_shared<FlatObject>();
  graph->fields[0] = objects(tensors_);
  graph->fields[1] = scalars(inputs_);
  graph->fields[2] = scalars(outputs_);
  graph->fields[3] = objects(operators_);
  std::vector<Object> buffers{std::make_shared<FlatObject>()};
  buffers.insert(buffers.end(), buffers_.begin(), buffers_.end());
  auto model = std::make_shared<FlatObject>();
  model->scalars[0] = raw<uint32_t>(3);
  model->fields[1] = objects(codes_);
  model->fields[2] = objects({graph});
  model->fields[3] = string("made by a test");
  model->fields[4] = objects(buffers);
  return Writer().file(model);
}

std::vector<std::byte> negation(const std::vector<int32_t>& shape) {
  TfliteBuilder model;
  const auto x = model.tensor("x", kTfFloat32, shape), y = model.tensor("y", kTfFloat32, shape);
  return model.operation(kTfNeg, {x}, {y}).inputs({x}).outputs({y}).bytes();
}

std::vector<std::byte> reshaping(TfliteElement type) {
  TfliteBuilder model;
  const auto x = model.tensor("x", type, {2, 3}), y = model.tensor("y", type, {3, 2});
  const auto shape = model.constant("shape", {3, 2});
  return model.operation(kTfReshape, {x, shape}, {y}).inputs({x}).outputs({y}).bytes();
}

}  // namespace weir::engine_test
