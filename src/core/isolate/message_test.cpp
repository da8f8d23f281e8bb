// Tests the bounds checks of messages with any input.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/message.hpp"

#include <gtest/gtest.h>

#include "core/isolate/worker_model_info.hpp"

namespace weir::isolate {
namespace message_test {

std::span<const std::byte> body(MessageWriter* writer) {
  return writer->finish().subspan(sizeof(MessageHead));
}

TEST(Message, RoundTrips) {
  MessageWriter writer;
  writer.begin(Kind::Open);
  writer.put<uint32_t>(7);
  writer.text("tflite");
  writer.put<double>(0.5);
  MessageReader reader(body(&writer));
  EXPECT_EQ(reader.take<uint32_t>(), 7u);
  EXPECT_EQ(reader.text(), "tflite");
  EXPECT_EQ(reader.take<double>(), 0.5);
  EXPECT_TRUE(reader.complete());
}

TEST(Message, ContainsItsKindAndItsLength) {
  MessageWriter writer;
  writer.begin(Kind::Invoke);
  writer.text("abc");
  MessageHead head{};
  std::memcpy(&head, writer.finish().data(), sizeof head);
  EXPECT_EQ(head.kind, static_cast<uint32_t>(Kind::Invoke));
  EXPECT_EQ(head.bytes, sizeof(uint32_t) + 3);
}

TEST(Message, IsInvalidIfPartsAreMissing) {
  MessageWriter writer;
  writer.begin(Kind::Open);
  writer.put<uint32_t>(100);  // the length of a missing text
  MessageReader reader(body(&writer));
  EXPECT_EQ(reader.text(), "");
  EXPECT_EQ(reader.take<uint64_t>(), 0u);
  EXPECT_FALSE(reader.complete());
}

TEST(Message, IsInvalidIfBytesAreLeft) {
  MessageWriter writer;
  writer.begin(Kind::Open);
  writer.put<uint64_t>(1);
  MessageReader reader(body(&writer));
  reader.take<uint32_t>();
  EXPECT_FALSE(reader.complete());
}

TEST(Message, IsInvalidIfACountExceedsTheLimit) {
  MessageWriter writer;
  writer.begin(Kind::Open);
  writer.put<uint32_t>(257);
  MessageReader reader(body(&writer));
  EXPECT_EQ(reader.count(256), 0u);
  EXPECT_FALSE(reader.complete());
}

WorkerModelInfo described(const std::vector<weir_tensor_info>& tensors) {
  weir_model_info info{};
  info.n_inputs = info.n_outputs = static_cast<uint32_t>(tensors.size());
  info.inputs = info.outputs = tensors.data();
  info.alignment = 64;
  info.metadata_json = "{}";
  MessageWriter writer;
  writer.begin(Kind::Opened);
  put_model("fake", {}, info, &writer);
  MessageReader reader(body(&writer));
  auto facts = WorkerModelInfo::take(&reader);
  EXPECT_TRUE(reader.complete());
  return facts;
}

weir_tensor_info tensor(const char* name) {
  weir_tensor_info out{};
  out.type = WEIR_UINT8;
  out.rank = 2;
  out.shape[0] = -1;
  out.shape[1] = 4;
  out.name = name;
  return out;
}

TEST(WorkerModelInfo, RoundTripWithTheirNames) {
  const WorkerModelInfo facts = described({tensor("x"), tensor(nullptr), tensor("")});
  EXPECT_EQ(facts.engine, "fake");
  EXPECT_EQ(facts.info.alignment, 64u);
  EXPECT_EQ(facts.metadata_json, "{}");
  ASSERT_EQ(facts.inputs.list().size(), 3u);
  EXPECT_STREQ(facts.inputs.list()[0].name, "x");
  EXPECT_EQ(facts.inputs.list()[1].name, nullptr);
  EXPECT_STREQ(facts.inputs.list()[2].name, "");
  EXPECT_EQ(facts.outputs.list()[0].shape[0], -1);
  EXPECT_EQ(facts.outputs.list()[0].shape[1], 4);
}

TEST(WorkerModelInfo, HaveTheAcceleratorAndItsWarning) {
  const Error warning{.code = Code::OPTION_VALUE, .what = "no gpu", .fix = "true:cpu"};
  for (const AcceleratorChoice& choice : {AcceleratorChoice{"cpu", warning}, {"", {}}}) {
    MessageWriter writer;
    writer.begin(Kind::Opened);
    put_model("fake", choice, {}, &writer);
    MessageReader reader(body(&writer));
    const auto facts = WorkerModelInfo::take(&reader);
    EXPECT_TRUE(reader.complete());
    EXPECT_EQ(facts.accelerator.used, choice.used);
    ASSERT_EQ(facts.accelerator.warning.has_value(), choice.warning.has_value());
    if (choice.warning) {
      EXPECT_EQ(facts.accelerator.warning->message(), warning.message());
    }
  }
}

TEST(WorkerModelInfo, AreTheSameWhateverTheNames) {
  auto other = tensor("y");
  EXPECT_TRUE(same_tensors(described({tensor("x")}), described({other})));
  other.shape[1] = 5;
  EXPECT_FALSE(same_tensors(described({tensor("x")}), described({other})));
  EXPECT_FALSE(same_tensors(described({tensor("x")}), described({})));
}

// Every truncation and every changed byte: reads stay within bounds (checked by the sanitizers),
// and truncations are detected.
TEST(WorkerModelInfo, RejectDamage) {
  const std::vector<weir_tensor_info> tensors{tensor("input"), tensor("other")};
  weir_model_info info{};
  info.n_inputs = info.n_outputs = 2;
  info.inputs = info.outputs = tensors.data();
  MessageWriter writer;
  writer.begin(Kind::Opened);
  put_model("fake", {}, info, &writer);
  const auto whole = body(&writer);
  for (size_t size = 0; size < whole.size(); ++size) {
    MessageReader reader(whole.first(size));
    WorkerModelInfo::take(&reader);
    EXPECT_FALSE(reader.complete()) << size;
  }
  std::vector<std::byte> damaged(whole.begin(), whole.end());
  for (auto& byte : damaged) {
    const auto kept = byte;
    byte = std::byte{0xFF};
    MessageReader reader(damaged);
    const auto facts = WorkerModelInfo::take(&reader);
    EXPECT_LE(facts.inputs.list().size(), size_t{WEIR_TENSOR_LIMIT});
    byte = kept;
  }
}

TEST(Errors, RoundTripWithTheirTexts) {
  const Error error{.code = Code::MODEL_INVALID,
                    .what = "what",
                    .offered = "offered",
                    .needed = "needed",
                    .difference = "difference",
                    .fix = "fix"};
  MessageWriter writer;
  writer.begin(Kind::Failed);
  put_error(error, &writer);
  MessageReader reader(body(&writer));
  EXPECT_EQ(take_error(&reader).message(), error.message());
  EXPECT_TRUE(reader.complete());
}

TEST(Errors, AreShortenedAndGetAValidCode) {
  MessageWriter writer;
  writer.begin(Kind::Failed);
  put_error({static_cast<Code>(-5), std::string(1 << 20, 'x'), "", "", "", ""}, &writer);
  MessageReader reader(body(&writer));
  const Error error = take_error(&reader);
  EXPECT_TRUE(reader.complete());
  EXPECT_EQ(error.code, Code::INTERNAL);
  EXPECT_EQ(error.what.size(), 65536u);
}

}  // namespace message_test
}  // namespace weir::isolate
