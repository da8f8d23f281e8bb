// Tests of octet_stream: it shares its inputs and copies nothing.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "decoder_test_support.hpp"

namespace weir::testing_decoders {
namespace octet_stream_test {

TEST(OctetStream, SharesTheTensors) {
  const auto out = decode("octet_stream", {}, Tensor<float>{ElementType::Float32, "2", {1, 2}});
  EXPECT_EQ(out.error, "");
  EXPECT_EQ(out.sink.caps, "application/octet-stream");
  EXPECT_EQ(out.sink.shared, std::vector<uint32_t>{0});
  EXPECT_TRUE(out.sink.memories.empty());
}

TEST(OctetStream, SharesEachTensorInOrder) {
  const Tensor<uint8_t> one{ElementType::UInt8, "1", {1}};
  const auto out = decode_frame("octet_stream", {}, one.info(), std::vector<weir_tensor>(3));
  EXPECT_EQ(out.sink.shared, (std::vector<uint32_t>{0, 1, 2}));
  EXPECT_TRUE(decode_frame("octet_stream", {}, one.info(), {}).sink.shared.empty());
}

TEST(OctetStream, PassesOverOptionsThatItDoesNotHave) {
  const auto out =
      decode("octet_stream", {{"option1", "x"}}, Tensor<uint8_t>{ElementType::UInt8, "1", {1}});
  EXPECT_EQ(out.error, "");
}

}  // namespace octet_stream_test
}  // namespace weir::testing_decoders
