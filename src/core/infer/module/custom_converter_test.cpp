// Tests converter functions registered by the application.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/custom_converter.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "says.hpp"
#include "weir/custom_converter.h"

namespace weir::infer {
namespace custom_converter_test {

// Adds *data to each byte.
int add(const weir_host* host, const char* caps, const weir_frame* in, weir_frame* out, void* data,
        weir_error* error) {
  if (std::strcmp(caps, "drop") == 0) return 1;
  if (std::strcmp(caps, "fail") == 0)
    return host->fail(error, WEIR_INVOKE_FAILED, "as ordered", caps, nullptr, nullptr, nullptr);
  const weir_tensor& from = in->tensors[0];
  weir_tensor& to = out->tensors[0];
  to.info = from.info;
  if (host->allocate(nullptr, WEIR_MEMORY_HOST, from.bytes, 64, &to) != WEIR_OK)
    return -WEIR_OUT_OF_MEMORY;
  out->n_tensors = 1;
  for (uint64_t i = 0; i < from.bytes; ++i)
    static_cast<uint8_t*>(to.data)[i] =
        static_cast<uint8_t>(static_cast<const uint8_t*>(from.data)[i] + *static_cast<int*>(data));
  return WEIR_OK;
}

Result<ConvertedFrame> converted(Converter* converter) {
  uint8_t bytes[] = {1, 2, 3};
  weir_tensor tensor{};
  tensor.data = bytes;
  tensor.bytes = sizeof bytes;
  tensor.info.type = WEIR_UINT8;
  tensor.info.rank = 1;
  tensor.info.shape[0] = sizeof bytes;
  weir_frame frame{};
  frame.tensors = &tensor;
  frame.n_tensors = 1;
  return converter->convert(frame);
}

TEST(CustomConverter, CallsTheFunctionWithItsData) {
  int data = 5;
  ASSERT_EQ(weir_converter_register("add", add, &data), WEIR_OK);
  EXPECT_TRUE(is_custom_converter("add"));
  const auto converter = custom_converter("add");
  EXPECT_TRUE(converter->configure("application/x-any")->empty());
  auto frame = converted(converter.get());
  ASSERT_TRUE(frame);
  ASSERT_EQ(frame->tensors.size(), 1u);
  EXPECT_EQ(frame->tensors[0].spec().to_string(), "uint8 3");
  EXPECT_EQ(std::memcmp(frame->tensors[0].memory().data, "\6\7\10", 3), 0);
  EXPECT_EQ(weir_converter_unregister("add"), WEIR_OK);
  EXPECT_EQ(converted(converter.get()).error().code, Code::CONVERTER_UNKNOWN)
      << "its data may be gone";
  ASSERT_TRUE(converter->configure("application/x-other"));
  EXPECT_EQ(converted(converter.get()).error().code, Code::CONVERTER_UNKNOWN);
}

TEST(CustomConverter, MayDropAndFail) {
  int data = 0;
  ASSERT_EQ(weir_converter_register("add", add, &data), WEIR_OK);
  const auto converter = custom_converter("add");
  ASSERT_TRUE(converter->configure("drop"));
  EXPECT_TRUE(converted(converter.get())->tensors.empty());
  ASSERT_TRUE(converter->configure("fail"));
  const auto failed = converted(converter.get());
  EXPECT_EQ(failed.error().code, Code::INVOKE_FAILED);
  EXPECT_EQ(failed.error().what, "the function add failed: as ordered");
  EXPECT_EQ(weir_converter_unregister("add"), WEIR_OK);
}

TEST(CustomConverter, ListsTheKnownNamesForAnUnknownName) {
  int data = 0;
  ASSERT_EQ(weir_converter_register("one", add, &data), WEIR_OK);
  ASSERT_EQ(weir_converter_register("two", add, &data), WEIR_OK);
  const auto converter = custom_converter("three");
  const auto text = converted(converter.get()).error().message();
  EXPECT_SAYS(text, "WEIR-3011: no function is registered under this name");
  EXPECT_SAYS(text, "needed: one of: one, two");
  EXPECT_SAYS(text, "weir_converter_register(\"three\", function, data)");
  EXPECT_EQ(weir_converter_unregister("one"), WEIR_OK);
  EXPECT_EQ(weir_converter_unregister("two"), WEIR_OK);
}

TEST(CustomConverter, RequiresAnUnusedNameAndAFunction) {
  EXPECT_EQ(weir_converter_register(nullptr, add, nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(weir_converter_register("", add, nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(weir_converter_register("none", nullptr, nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(weir_converter_register("twice", add, nullptr), WEIR_OK);
  EXPECT_EQ(weir_converter_register("twice", add, nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(weir_converter_unregister("twice"), WEIR_OK);
  EXPECT_EQ(weir_converter_unregister("twice"), -WEIR_CONVERTER_UNKNOWN);
  EXPECT_EQ(weir_converter_unregister(nullptr), -WEIR_CONVERTER_UNKNOWN);
  EXPECT_FALSE(is_custom_converter("none"));
}

}  // namespace custom_converter_test
}  // namespace weir::infer
