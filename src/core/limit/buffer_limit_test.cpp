// The limit on output buffers and its error text.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/limit/buffer_limit.hpp"

#include <gtest/gtest.h>

#include "says.hpp"

namespace weir {
namespace buffer_limit_test {

FrameSpec bytes_spec(const std::string& dimensions) {
  return FrameSpec{Format::Static, {{ElementType::UInt8, Shape::parse(dimensions), ""}}, {}};
}

TEST(BufferLimit, IsOneGibibyteByDefault) {
  const BufferLimit limit("tensor_crop");
  EXPECT_EQ(limit.bytes(), 1073741824u);
  EXPECT_TRUE(limit.check(1073741824));
  EXPECT_FALSE(limit.check(1073741825));
}

TEST(BufferLimit, AllowsEverySizeAtZero) {
  BufferLimit limit("tensor_crop");
  limit.set_bytes(0);
  EXPECT_TRUE(limit.check(UINT64_MAX));
}

TEST(BufferLimit, NamesElementBytesLimitAndAFixToPaste) {
  BufferLimit limit("tensor_sparse_dec");
  limit.set_bytes(1000);
  const auto status = limit.check(1001);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().message(),
            "WEIR-2006: an output buffer of tensor_sparse_dec is larger than max-buffer-size\n"
            "  offered: 1001 bytes\n  needed: at most 1000 bytes\n"
            "  fix: tensor_sparse_dec max-buffer-size=1001");
}

TEST(BufferLimit, ChecksTheSumOfTheTensors) {
  BufferLimit limit("tensor_merge");
  limit.set_bytes(100);
  FrameSpec spec = bytes_spec("60");
  EXPECT_TRUE(limit.check(spec));
  spec.tensors.push_back(spec.tensors[0]);
  EXPECT_REFUSED(limit.check(spec), LIMIT_EXCEEDED, "offered: 120 bytes");
  EXPECT_REFUSED(limit.check_input(spec), LIMIT_EXCEEDED, "an input frame of tensor_merge");
}

TEST(BufferLimit, RejectsASumThatOverflows) {
  FrameSpec spec;
  spec.tensors.assign(9, bytes_spec("1073741824:1073741824").tensors[0]);  // 9 * 2^60
  EXPECT_REFUSED(BufferLimit("tensor_mux").check(spec), LIMIT_EXCEEDED, "WEIR-2006");
}

TEST(BufferLimit, AcceptsTensorsOfUnknownSize) {
  const BufferLimit limit("tensor_filter");
  EXPECT_TRUE(limit.check(FrameSpec{Format::Flexible, {}, {}}));
  EXPECT_TRUE(limit.check_input(FrameSpec{Format::Flexible, {}, {}}));
}

}  // namespace buffer_limit_test
}  // namespace weir
