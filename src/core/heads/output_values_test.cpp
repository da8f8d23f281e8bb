// Tests of the conversion of outputs to real numbers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/output_values.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "says.hpp"

namespace weir::heads {
namespace output_values_test {

weir_tensor tensor_of(uint32_t type, std::initializer_list<int64_t> shape, void* data,
                      uint64_t bytes) {
  weir_tensor out{};
  out.info = tensor_info(nullptr, static_cast<weir_type>(type), shape);
  out.data = data;
  out.bytes = bytes;
  return out;
}
std::string error_of(const weir_tensor& tensor) {
  OutputValues values;
  values.begin({&tensor, 1});
  try {
    values.read(0);
  } catch (const Failure& failure) {
    return failure.what();
  }
  return "";
}

TEST(OutputValues, Float32IsNotCopied) {
  float numbers[3] = {1, 2, 3};
  const auto tensor = tensor_of(WEIR_FLOAT32, {1, 3}, numbers, sizeof numbers);
  OutputValues values;
  values.begin({&tensor, 1});
  EXPECT_EQ(values.read(0).data(), numbers);
  EXPECT_EQ(values.read(0).size(), 3u);
}

TEST(OutputValues, AppliesTheQuantisationUnlessRaw) {
  int8_t numbers[2] = {-128, 127};
  auto tensor = tensor_of(WEIR_INT8, {2}, numbers, sizeof numbers);
  tensor.info.scale = 0.25f, tensor.info.zero_point = -128;
  OutputValues values;
  values.begin({&tensor, 1});
  EXPECT_EQ(values.read(0)[0], 0);
  EXPECT_EQ(values.read(0)[1], 63.75f);
  values.begin({&tensor, 1});
  EXPECT_EQ(values.read_raw(0)[1], 127);
}

TEST(OutputValues, ReadsMemoryThatIsNotAligned) {
  std::byte memory[9] = {};
  const float number = 1.5f;
  std::memcpy(memory + 1, &number, sizeof number);
  const auto tensor = tensor_of(WEIR_FLOAT32, {2}, memory + 1, 8);
  OutputValues values;
  values.begin({&tensor, 1});
  EXPECT_EQ(values.read(0)[0], 1.5f);
}

TEST(OutputValues, RefusesWhatTheShapeDoesNotSay) {
  float numbers[3] = {};
  EXPECT_SAYS(error_of(tensor_of(WEIR_FLOAT32, {4}, numbers, 12)), "12 bytes");
  EXPECT_SAYS(error_of(tensor_of(WEIR_FLOAT32, {-1}, numbers, 12)), "a tensor of a known size");
  EXPECT_SAYS(error_of(tensor_of(WEIR_FLOAT32, {0}, numbers, 0)), "a tensor of a known size");
  EXPECT_SAYS(error_of(tensor_of(WEIR_FLOAT32, {int64_t{1} << 40, int64_t{1} << 40}, numbers, 12)),
              "a tensor of a known size");
  EXPECT_SAYS(error_of(tensor_of(WEIR_FLOAT32, {3}, nullptr, 12)), "0 bytes");
  OutputValues values;
  EXPECT_THROW(values.read(0), Failure);
}

}  // namespace output_values_test
}  // namespace weir::heads
