// Tests the serialisation of calls and the placement of outputs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/calls.hpp"

#include <gtest/gtest.h>

namespace weir::isolate {
namespace calls_test {

TEST(OpenCall, RoundTrips) {
  const OpenCall call{"tflite", {"a.tflite", "b"}, {{"NumThreads", "2"}, {"x", ""}}, "cpu",
                      3,        {{"input", "3:4"}}};
  MessageWriter writer;
  writer.begin(Kind::Open);
  call.put(&writer);
  MessageReader reader(writer.finish().subspan(sizeof(MessageHead)));
  const auto back = OpenCall::take(&reader);
  EXPECT_TRUE(reader.complete());
  EXPECT_EQ(back.engine, call.engine);
  EXPECT_EQ(back.paths, call.paths);
  EXPECT_EQ(back.options, call.options);
  EXPECT_EQ(back.declared, call.declared);
  EXPECT_EQ(back.accelerator, call.accelerator);
  EXPECT_EQ(back.threads, 3);
}

TEST(Places, StartAtConsecutivePages) {
  uint64_t end = 0;
  EXPECT_EQ(place(10, &end), 0u);
  EXPECT_EQ(end, 10u);
  EXPECT_EQ(place(4096, &end), 4096u);
  EXPECT_EQ(place(0, &end), 8192u);
  EXPECT_EQ(end, 8192u);
}

TEST(Places, EndBeforeNumbersOverflow) {
  uint64_t end = 10;
  EXPECT_FALSE(place(UINT64_MAX, &end));
  end = UINT64_MAX - 5;
  EXPECT_FALSE(place(1, &end));
}

}  // namespace calls_test
}  // namespace weir::isolate
