// Checks of tensors that come through the ABI.
#include "tensor_check.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace weir::engine {
namespace {

weir_tensor_info shaped(uint32_t type, const std::vector<int64_t>& shape) {
  weir_tensor_info info{};
  info.type = type;
  info.rank = static_cast<uint32_t>(shape.size());
  std::copy(shape.begin(), shape.end(), info.shape);
  return info;
}

Code code_of(const Status& status) {
  return status ? Code::INTERNAL : status.error().code;
}

TEST(TensorCheck, SizesAreProductsAndScalarsAreOneElement) {
  EXPECT_EQ(tensor_bytes(shaped(WEIR_FLOAT32, {1, 224, 224, 3})), 602112u);
  EXPECT_EQ(tensor_bytes(shaped(WEIR_FLOAT16, {})), 2u);
  EXPECT_EQ(tensor_bytes(shaped(WEIR_UINT64, {4, 0})), 0u);
}

TEST(TensorCheck, NoSizeForWhatIsOpenTooLargeOrUnknown) {
  EXPECT_EQ(tensor_bytes(shaped(WEIR_UINT8, {-1, 3})), std::nullopt);
  EXPECT_EQ(tensor_bytes(shaped(WEIR_UINT8, {INT64_MAX, INT64_MAX})), std::nullopt);
  EXPECT_EQ(tensor_bytes(shaped(WEIR_UINT8, {int64_t{1} << 32, int64_t{1} << 32})), std::nullopt);
  EXPECT_EQ(tensor_bytes(shaped(WEIR_TYPE_END, {1})), std::nullopt);
  auto unknown = shaped(WEIR_UINT8, {});
  unknown.rank = WEIR_RANK_UNKNOWN;
  EXPECT_EQ(tensor_bytes(unknown), std::nullopt);
}

TEST(TensorCheck, DescribesAsCapsDo) {
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
  EXPECT_EQ(code_of(check_memory(tensor, 0, "input")), Code::FORMAT_UNSUPPORTED);
  tensor.stride[0] = 3;
  tensor.bytes = 5;
  EXPECT_EQ(code_of(check_memory(tensor, 0, "input")), Code::FRAME_SIZE);
  tensor.bytes = 6;
  tensor.data = nullptr;
  EXPECT_EQ(code_of(check_memory(tensor, 0, "input")), Code::FRAME_SIZE);
  tensor.data = data;
  tensor.memory_kind = WEIR_MEMORY_CUDA;
  EXPECT_EQ(code_of(check_memory(tensor, 0, "input")), Code::FORMAT_UNSUPPORTED);
}

}  // namespace
}  // namespace weir::engine
