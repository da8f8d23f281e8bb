// Makes small .tflite files for tests, field by field along schema.fbs (version 3) of TensorFlow.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace weir::engine_test {

// A FlatBuffers object before it is written: a table, a vector of objects, or plain bytes.
struct FlatObject {
  std::map<uint32_t, std::vector<std::byte>> scalars;      // of a table, by field
  std::map<uint32_t, std::shared_ptr<FlatObject>> fields;  // of a table, by field
  std::vector<std::shared_ptr<FlatObject>> elements;       // of a vector of objects
  std::vector<std::byte> bytes;                            // of a vector of scalars
  uint32_t count = 0;                                      // of its elements
  enum { Table, Objects, Scalars } kind = Table;
};

// Element types as the schema numbers them.
enum TfliteElement : uint8_t {
  kTfFloat32 = 0,
  kTfFloat16 = 1,
  kTfInt32 = 2,
  kTfUInt8 = 3,
  kTfInt64 = 4,
  kTfString = 5,
  kTfBool = 6,
  kTfInt16 = 7,
  kTfInt8 = 9,
  kTfFloat64 = 10,
  kTfUInt64 = 12,
  kTfUInt32 = 15,
};
// Operators as the schema numbers them.
enum TfliteOperator : int32_t { kTfAdd = 0, kTfReshape = 22, kTfCustom = 32, kTfNeg = 59 };

class TfliteBuilder {
 public:
  // Each returns the tensor's index. Extents of -1 are open and stand as 1 in the shape.
  int32_t tensor(const std::string& name, TfliteElement type, const std::vector<int32_t>& shape,
                 float scale = 0, int64_t zero_point = 0);
  int32_t constant(const std::string& name, const std::vector<int32_t>& values);
  TfliteBuilder& operation(TfliteOperator code, const std::vector<int32_t>& inputs,
                           const std::vector<int32_t>& outputs, const std::string& custom = "");
  TfliteBuilder& inputs(const std::vector<int32_t>& tensors);
  TfliteBuilder& outputs(const std::vector<int32_t>& tensors);
  std::vector<std::byte> bytes() const;

 private:
  std::vector<std::shared_ptr<FlatObject>> tensors_, operators_, codes_, buffers_;
  std::vector<int32_t> inputs_, outputs_;
};

// y = -x
std::vector<std::byte> negation(const std::vector<int32_t>& shape = {2, 3});
// y = x, in another shape
std::vector<std::byte> reshaping(TfliteElement type);

}  // namespace weir::engine_test
