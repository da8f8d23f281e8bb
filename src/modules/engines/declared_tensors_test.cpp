// Tests of the options that declare tensors: valid lists, and the errors for invalid ones.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "declared_tensors.hpp"

#include <gtest/gtest.h>

namespace weir::engine {
namespace declared_tensors_test {

TEST(DeclaredTensors, ListsFillTheTensorsInOrder) {
  DeclaredTensors tensors;
  EXPECT_TRUE(*tensors.take("input", " 3 : 224:224:1 , 10"));
  EXPECT_TRUE(*tensors.take("InputType", "uint8.float32"));
  EXPECT_TRUE(*tensors.take("inputname", ",second"));
  EXPECT_TRUE(*tensors.take("outputname", "a,b,c"));
  ASSERT_EQ(tensors.inputs().size(), 2u);
  EXPECT_EQ(tensors.inputs()[0].shape, (std::vector<int64_t>{1, 224, 224, 3}));
  EXPECT_EQ(tensors.inputs()[0].type, uint32_t{WEIR_UINT8});
  EXPECT_EQ(tensors.inputs()[0].name, "");
  EXPECT_EQ(tensors.inputs()[1].shape, std::vector<int64_t>{10});
  EXPECT_EQ(tensors.inputs()[1].name, "second");
  ASSERT_EQ(tensors.outputs().size(), 3u);
  EXPECT_EQ(tensors.outputs()[2].name, "c");
  EXPECT_FALSE(tensors.outputs()[2].has_shape);
  EXPECT_EQ(tensors.outputs()[2].type, uint32_t{WEIR_TYPE_END});
}

TEST(DeclaredTensors, IgnoreOtherOptions) {
  DeclaredTensors tensors;
  for (const char* key : {"inputs", "NumThreads", "", "inputlayout"})
    EXPECT_FALSE(*tensors.take(key, "3"));
  EXPECT_TRUE(*tensors.take("input", " "));
  EXPECT_TRUE(tensors.inputs().empty());
}

TEST(DeclaredTensors, TextsThatCannotBeReadAreRejected) {
  DeclaredTensors tensors;
  for (const char* text :
       {"3:x", "0", "-1", "3::4", "99999999999", "1.5:2,", "1:1:1:1:1:1:1:1:1:1:1:1:1:1:1:1:1"}) {
    const auto taken = tensors.take("output", text);
    if (std::string(text) == "1.5:2,") {  // a full stop separates tensors
      EXPECT_TRUE(taken);
      continue;
    }
    ASSERT_FALSE(taken) << text;
    EXPECT_EQ(taken.error().code, Code::DIMENSION_SYNTAX);
    EXPECT_EQ(taken.error().offered, text);
  }
  const auto type = tensors.take("inputtype", "uint8,floaty");
  ASSERT_FALSE(type);
  EXPECT_EQ(type.error().code, Code::TYPE_SYNTAX);
  EXPECT_EQ(type.error().offered, "floaty");
  const auto many = tensors.take("inputname", std::string(300, ','));
  ASSERT_FALSE(many);
  EXPECT_EQ(many.error().code, Code::LIMIT_EXCEEDED);
}

TEST(DeclaredTensors, DimensionsAreWrittenInnermostFirst) {
  EXPECT_EQ(dimension_text({1, 224, 224, 3}), "3:224:224:1");
  EXPECT_EQ(dimension_text({}), "1");
  EXPECT_EQ(parse_type("FLOAT16"), uint32_t{WEIR_FLOAT16});
  EXPECT_FALSE(parse_type("float"));
}

}  // namespace declared_tensors_test
}  // namespace weir::engine
