// Tests frames without results.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/results/empty_frame.hpp"

#include <gtest/gtest.h>

#include <list>

#include "core/tensor/tensor_header.hpp"

namespace weir::results {
namespace empty_frame_test {

struct Written {
  bool valid = false;
  std::list<std::vector<std::byte>> memories;
};
Written write(const std::string& columns) {
  Written out;
  out.valid = write_empty(parse_roles(columns, ""), [&](size_t bytes) {
    return std::span(out.memories.emplace_back(bytes, std::byte{0xAA}));
  });
  return out;
}

TEST(EmptyFrame, HasOneRowOfZeros) {
  const auto written = write("x1,y1,x2,y2,score,class,xys:17");
  ASSERT_TRUE(written.valid);
  ASSERT_EQ(written.memories.size(), 1u);
  const auto& bytes = written.memories.front();
  const auto header = read_tensor_chunk(bytes);
  ASSERT_TRUE(header);
  EXPECT_EQ(header->spec.to_string(), "float32 57:1");
  ASSERT_EQ(bytes.size(), kTensorHeaderBytes + 57 * sizeof(float));
  EXPECT_TRUE(std::all_of(bytes.begin() + kTensorHeaderBytes, bytes.end(),
                          [](std::byte b) { return b == std::byte{}; }));
}

TEST(EmptyFrame, HasATensorForEachRole) {
  const auto written = write("score,class;masks;scores;;text;class-map;depth");
  ASSERT_TRUE(written.valid);
  std::vector<std::string> specs;
  for (const auto& bytes : written.memories) {
    const auto header = read_tensor_chunk(bytes);
    ASSERT_TRUE(header);
    EXPECT_EQ(header->format, Format::Flexible);
    specs.push_back(header->spec.to_string());
  }
  EXPECT_EQ(specs, (std::vector<std::string>{"float32 2:1", "uint8 1:1:1", "float32 1:1", "uint8 1",
                                             "uint8 1:1", "uint16 1:1", "float32 1:1"}));
}

TEST(EmptyFrame, OfInvalidColumnsIsNotWritten) {
  for (const char* columns :
       {"x1,y1", "score,score", "score;x2,x1,y1,y2", "score,,class", "xys:0"}) {
    const auto written = write(columns);
    EXPECT_FALSE(written.valid) << columns;
    EXPECT_TRUE(written.memories.empty()) << columns;
  }
}

}  // namespace empty_frame_test
}  // namespace weir::results
