// Tests of the checks of tensors that cross the ABI.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tensor_check.hpp"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "weir/module.hpp"

namespace weir::engine {
namespace tensor_check_test {

weir_tensor_info shaped(uint32_t type, const std::vector<int64_t>& shape) {
  weir_tensor_info info{};
  info.type = type;
  info.rank = static_cast<uint32_t>(shape.size());
  std::copy(shape.begin(), shape.end(), info.shape);
  return info;
}

Code get_code(const Status& status) {
  return status ? Code::INTERNAL : status.error().code;
}

TEST(TensorCheck, SizesAreProductsAndScalarsAreOneElement) {
  EXPECT_EQ(tensor_bytes(shaped(WEIR_FLOAT32, {1, 224, 224, 3})), 602112u);
  EXPECT_EQ(tensor_bytes(shaped(WEIR_FLOAT16, {})), 2u);
  EXPECT_EQ(tensor_bytes(shaped(WEIR_UINT64, {4, 0})), 0u);
}

TEST(TensorCheck, HasNoSizeForOpenOversizedOrUnknownTensors) {
  EXPECT_EQ(tensor_bytes(shaped(WEIR_UINT8, {-1, 3})), std::nullopt);
  EXPECT_EQ(tensor_bytes(shaped(WEIR_UINT8, {INT64_MAX, INT64_MAX})), std::nullopt);
  EXPECT_EQ(tensor_bytes(shaped(WEIR_UINT8, {int64_t{1} << 32, int64_t{1} << 32})), std::nullopt);
  EXPECT_EQ(tensor_bytes(shaped(WEIR_TYPE_END, {1})), std::nullopt);
  auto unknown = shaped(WEIR_UINT8, {});
  unknown.rank = WEIR_RANK_UNKNOWN;
  EXPECT_EQ(tensor_bytes(unknown), std::nullopt);
}

TEST(TensorCheck, DescribesLikeCaps) {
  auto info = shaped(WEIR_UINT8, {1, -1, 224, 3});
  EXPECT_EQ(describe(info), "uint8 3:224:?:1");
  info.name = "input";
  EXPECT_EQ(describe(info), "uint8 3:224:?:1 (input)");
  EXPECT_EQ(describe(shaped(WEIR_INT64, {})), "int64 1");
  info.rank = WEIR_RANK_UNKNOWN;
  info.name = nullptr;
  EXPECT_EQ(describe(info), "uint8 of any rank");
}

TEST(TensorCheck, InfosFitByTypeRankAndKnownDimensions) {
  const std::vector model{shaped(WEIR_UINT8, {-1, 3})};
  EXPECT_TRUE(check_infos(model, std::vector{shaped(WEIR_UINT8, {5, 3})}, "input"));
  EXPECT_TRUE(check_infos(model, model, "input"));
  EXPECT_FALSE(check_infos(model, {}, "input"));
  EXPECT_FALSE(check_infos(model, std::vector{shaped(WEIR_INT8, {5, 3})}, "input"));
  EXPECT_FALSE(check_infos(model, std::vector{shaped(WEIR_UINT8, {3})}, "input"));
  const auto status = check_infos(model, std::vector{shaped(WEIR_UINT8, {5, 4})}, "input");
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, Code::SPEC_MISMATCH);
  EXPECT_EQ(status.error().difference, "dimension 1 is 4 instead of 3");
}

TEST(TensorCheck, AnyRankFitsAnUnknownOneUpToTheLimit) {
  auto unknown = shaped(WEIR_UINT8, {});
  unknown.rank = WEIR_RANK_UNKNOWN;
  const std::vector model{unknown};
  EXPECT_TRUE(check_infos(model, std::vector{shaped(WEIR_UINT8, {5, 3})}, "input"));
  auto deep = shaped(WEIR_UINT8, {1});
  deep.rank = 17;
  EXPECT_TRUE(tensor_bytes(deep) == std::nullopt);
}

TEST(TensorCheck, MemoryMustBeDenseHostMemoryOfTheRightSize) {
  uint8_t data[6] = {};
  weir_tensor tensor{};
  tensor.info = shaped(WEIR_UINT8, {2, 3});
  tensor.data = data;
  tensor.bytes = 6;
  EXPECT_TRUE(check_memory(tensor, 0, "input"));
  tensor.stride[0] = 3;
  tensor.stride[1] = 1;
  EXPECT_TRUE(check_memory(tensor, 0, "input"));
  tensor.stride[0] = 4;
  EXPECT_EQ(get_code(check_memory(tensor, 0, "input")), Code::FORMAT_UNSUPPORTED);
  tensor.stride[0] = 3;
  tensor.bytes = 5;
  EXPECT_EQ(get_code(check_memory(tensor, 0, "input")), Code::FRAME_SIZE);
  tensor.bytes = 6;
  tensor.data = nullptr;
  EXPECT_EQ(get_code(check_memory(tensor, 0, "input")), Code::FRAME_SIZE);
  tensor.data = data;
  tensor.memory_kind = WEIR_MEMORY_CUDA;
  EXPECT_EQ(get_code(check_memory(tensor, 0, "input")), Code::FORMAT_UNSUPPORTED);
}

weir_tensor make_tensor(const weir_tensor_info& info, void* data) {
  weir_tensor out{};
  out.info = info;
  out.data = data;
  out.bytes = *tensor_bytes(info);
  return out;
}

TEST(TensorCheck, FramesNeedTheModelsNumberOfTensorsAndTheirMemory) {
  uint8_t data[6]{};
  const std::vector<weir_tensor_info> model{shaped(WEIR_UINT8, {-1, 3}),
                                            shaped(WEIR_TYPE_END, {2})};
  std::vector<weir_tensor> given{make_tensor(shaped(WEIR_UINT8, {2, 3}), data),
                                 make_tensor(shaped(WEIR_INT16, {2}), data)};
  EXPECT_TRUE(check_inputs(model, given)) << "the model takes any type for its second input";
  EXPECT_TRUE(check_outputs(model, given));
  const auto count = check_inputs(model, std::span(given).first(1));
  ASSERT_FALSE(count);
  EXPECT_EQ(count.error().what, "the number of inputs does not fit the model");
  EXPECT_EQ(count.error().needed, "2: uint8 3:?, ? 2");
  EXPECT_EQ(check_outputs(model, {}).error().what, "the number of outputs does not fit the model");
  given[1].info.rank = 2;
  EXPECT_EQ(check_inputs(model, given).error().difference, "rank 2 instead of 1");
  given[1] = make_tensor(shaped(WEIR_INT16, {2}), data);
  given[1].bytes = 3;
  EXPECT_EQ(get_code(check_inputs(model, given)), Code::FRAME_SIZE);
  EXPECT_EQ(get_code(check_outputs(model, given)), Code::FRAME_SIZE);
  given[1].data = nullptr;
  EXPECT_EQ(get_code(check_inputs(model, given)), Code::FRAME_SIZE);
  EXPECT_TRUE(check_outputs(model, given)) << "an output without memory gets some";
}

class WriteOutput : public ::testing::Test {
 protected:
  WriteOutput() {
    static weir_host host{};
    host.struct_size = sizeof host;
    host.allocate = [](void*, uint32_t, uint64_t bytes, uint32_t, weir_tensor* out) -> int {
      static std::vector<uint8_t> memory;
      if (bytes > 100) return -WEIR_OUT_OF_MEMORY;
      memory.assign(bytes, 0);
      out->data = memory.data();
      out->bytes = out->capacity = bytes;
      return WEIR_OK;
    };
    before_ = std::exchange(module_host, &host);
  }
  ~WriteOutput() override { module_host = before_; }

 private:
  const weir_host* before_;
};

TEST_F(WriteOutput, FillsGivenMemory) {
  const uint8_t from[4]{1, 2, 3, 4};
  uint8_t to[4]{};
  auto tensor = make_tensor(shaped(WEIR_UINT8, {4}), to);
  ASSERT_TRUE(write_output(shaped(WEIR_UINT8, {2, 2}), from, 0, &tensor));
  EXPECT_TRUE(std::equal(from, from + 4, to));
  EXPECT_EQ(tensor.info.rank, 1u) << "the host's description stays";
}

TEST_F(WriteOutput, AllocatesFromTheHostWithoutMemory) {
  const uint8_t from[2]{7, 8};
  weir_tensor tensor{};
  tensor.info.name = "scores";
  ASSERT_TRUE(write_output(shaped(WEIR_UINT8, {2}), from, 0, &tensor));
  EXPECT_EQ(tensor.bytes, 2u);
  EXPECT_EQ(static_cast<uint8_t*>(tensor.data)[1], 8);
  EXPECT_EQ(tensor.info.rank, 1u);
  EXPECT_STREQ(tensor.info.name, "scores");
}

TEST_F(WriteOutput, RejectsAWrongSizeOrTypeAndMissingMemory) {
  const uint8_t from[4]{};
  uint8_t to[4]{};
  auto tensor = make_tensor(shaped(WEIR_UINT8, {4}), to);
  const auto size = write_output(shaped(WEIR_UINT8, {3}), from, 5, &tensor);
  ASSERT_FALSE(size);
  EXPECT_EQ(size.error().code, Code::INVOKE_FAILED);
  EXPECT_EQ(size.error().offered, "uint8 3");
  EXPECT_EQ(size.error().needed, "uint8 4");
  EXPECT_EQ(size.error().difference, "output 5");
  EXPECT_EQ(get_code(write_output(shaped(WEIR_INT32, {1}), from, 0, &tensor)), Code::INVOKE_FAILED);
  weir_tensor none{};
  EXPECT_EQ(get_code(write_output(shaped(WEIR_UINT8, {101}), from, 0, &none)), Code::OUT_OF_MEMORY);
}

}  // namespace tensor_check_test
}  // namespace weir::engine
