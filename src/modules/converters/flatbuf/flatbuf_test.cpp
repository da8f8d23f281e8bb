// Tests of the flatbuf converter with messages that FlatBuffers' own classes write.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "message_converter_test_support.hpp"
#include "tensors_generated.h"

namespace weir::testing_converters {
namespace flatbuf_test {

namespace schema = nnstreamer::flatbuf;
using flatbuffers::FlatBufferBuilder;

struct Given {
  std::vector<uint32_t> dimensions{3};
  Bytes data{7, 8, 9};
  schema::Tensor_type type = schema::Tensor_type::NNS_UINT8;
};

flatbuffers::Offset<schema::Tensor> add(const Given& given, FlatBufferBuilder* builder) {
  return schema::CreateTensorDirect(*builder, "input", given.type, &given.dimensions, &given.data);
}
Bytes finish(FlatBufferBuilder* builder, flatbuffers::Offset<schema::Tensors> root) {
  builder->Finish(root);
  return {builder->GetBufferPointer(), builder->GetBufferPointer() + builder->GetSize()};
}
Bytes make_message(const std::vector<Given>& tensors, std::optional<int32_t> count = {},
                   std::optional<schema::frame_rate> rate = schema::frame_rate(30, 1),
                   int32_t format = 0) {
  FlatBufferBuilder builder;
  std::vector<flatbuffers::Offset<schema::Tensor>> all;
  for (const auto& given : tensors) all.push_back(add(given, &builder));
  return finish(&builder,
                schema::CreateTensorsDirect(
                    builder, count.value_or(static_cast<int32_t>(tensors.size())),
                    rate ? &*rate : nullptr, &all, static_cast<schema::Tensor_format>(format)));
}

TEST(FlatbufConverter, SharesTheBytesOfTheMessage) {
  MessageReader reader("flatbuf");
  EXPECT_TRUE(reader.configure("other/flatbuf-tensor,framerate=30/1").empty())
      << "the first frame decides";
  const auto made =
      reader.read(make_message({{}, {{1, 2}, {1, 2, 3, 4}, schema::Tensor_type::NNS_INT16}}));
  EXPECT_EQ(made.error, "");
  EXPECT_EQ(made.specs, (std::vector<std::string>{"uint8 3", "int16 1:2"}));
  EXPECT_EQ(made.bytes, std::vector<Bytes>({{7, 8, 9}, {1, 2, 3, 4}}));
  EXPECT_EQ(made.shared, std::vector<bool>({true, true}));
  EXPECT_EQ(made.rate, "30/1");
}

TEST(FlatbufConverter, TakesAMessageWithoutRateOrWithDimensionsUpTo16) {
  const auto made = MessageReader("flatbuf").read(
      make_message({{{3, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1}}}, {}, std::nullopt));
  EXPECT_EQ(made.error, "");
  EXPECT_EQ(made.specs, std::vector<std::string>{"uint8 3:1:1:1:1:1:1:1:1:1:1:1:1:1:1:1"});
  EXPECT_EQ(made.rate, "");
}

TEST(FlatbufConverter, CopiesWhatIsNotAligned) {
  for (size_t shift = 0; shift < 8; ++shift) {
    const auto made = MessageReader("flatbuf").read(make_message({{}}), shift);
    EXPECT_EQ(made.error, "");
    EXPECT_EQ(made.bytes, std::vector<Bytes>({{7, 8, 9}}));
    EXPECT_EQ(made.shared, std::vector<bool>{shift == 0}) << shift;
  }
}

TEST(FlatbufConverter, KeepsTheHeadersOfFlexibleTensors) {
  const Bytes chunk = with_header({ElementType::UInt8, Shape{3}, ""}, {7, 8, 9});
  const auto made =
      MessageReader("flatbuf").read(make_message({{{3}, chunk}}, {}, std::nullopt, 1));
  EXPECT_EQ(made.error, "");
  EXPECT_TRUE(made.is_flexible);
  EXPECT_EQ(made.bytes, std::vector<Bytes>({chunk}));
  const Bytes sparse = with_header({ElementType::UInt8, Shape{3}, ""}, {7, 8, 9}, Format::Sparse);
  EXPECT_NE(MessageReader("flatbuf").read(make_message({{{3}, sparse}}, {}, std::nullopt, 1)).error,
            "");
}

TEST(FlatbufConverter, NamesWhatIsDamaged) {
  MessageReader reader("flatbuf");
  const auto error = [&](const Bytes& bytes) { return reader.read(bytes).error; };
  EXPECT_SAYS(error({1, 2, 3}),
              "WEIR-2005: a flatbuf message is damaged: its tables cannot be read");
  EXPECT_SAYS(error({1, 2, 3}), "offered: 3 bytes");
  EXPECT_SAYS(error(Bytes(64, 0xFF)), "its tables cannot be read");
  FlatBufferBuilder empty;
  EXPECT_SAYS(error(finish(&empty, schema::CreateTensors(empty))), "it has no tensors");
  EXPECT_SAYS(error(make_message({{}}, 2)), "the number of tensors that it declares");
  EXPECT_SAYS(error(make_message({{}}, INT32_MIN)),
              "WEIR-2006: a flatbuf message has too many tensors");
  EXPECT_SAYS(error(make_message({{std::vector<uint32_t>(17, 1)}})),
              "a tensor has too many dimensions\n  offered: 17");
  EXPECT_SAYS(error(make_message({{{3}, {7}}})), "offered: 1 bytes\n  needed: 3 bytes for uint8 3");
  EXPECT_SAYS(error(make_message({{{3}, {7}, schema::Tensor_type::NNS_END}})),
              "no known element type");
  EXPECT_SAYS(error(make_message(std::vector<Given>(257))), "WEIR-2006");
  EXPECT_SAYS(error(make_message({{}}, {}, schema::frame_rate(1, 0))), "an invalid frame rate");
  EXPECT_SAYS(error(make_message({{}}, {}, std::nullopt, 3)), "an unknown format");
  EXPECT_EQ(error(make_message({{}})), "") << "and goes on";
}

TEST(FlatbufConverter, RefusesTensorsThatShareTheirBytes) {
  FlatBufferBuilder builder;
  const std::vector<uint32_t> dimensions{1000};
  const auto data = builder.CreateVector(Bytes(1000, 5));
  std::vector<flatbuffers::Offset<schema::Tensor>> all;
  for (int i = 0; i < 200; ++i)
    all.push_back(schema::CreateTensor(builder, 0, schema::Tensor_type::NNS_UINT8,
                                       builder.CreateVector(dimensions), data));
  const auto error =
      MessageReader("flatbuf")
          .read(finish(&builder, schema::CreateTensorsDirect(builder, 200, nullptr, &all)))
          .error;
  EXPECT_SAYS(error, "tensors of the message overlap\n  offered: 200000 bytes of tensors");
}

}  // namespace flatbuf_test
}  // namespace weir::testing_converters
