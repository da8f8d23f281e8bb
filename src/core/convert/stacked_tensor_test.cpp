// Shapes of several frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/convert/stacked_tensor.hpp"

#include <gtest/gtest.h>

#include "says.hpp"

namespace weir {
namespace stacked_tensor_test {

std::string gathered(std::string_view shape, uint32_t frames) {
  const auto tensor = stacked_tensor({ElementType::Int16, Shape::parse(shape), "x"}, frames);
  return tensor ? tensor->to_string() : tensor.error().message();
}

TEST(GatheredTensor, CountsFramesInItsOutermostDimension) {
  EXPECT_EQ(gathered("3:4:5:1", 2), "int16 3:4:5:2");
  EXPECT_EQ(gathered("1:1", 7), "int16 1:7");
  EXPECT_EQ(gathered("3", 2), "int16 3:2");
  EXPECT_EQ(gathered("1", 2), "int16 1:2");
  EXPECT_EQ(gathered("3:4", 2), "int16 3:4:2");
  EXPECT_EQ(gathered("3:1:4", 2), "int16 3:1:4:2");
}

TEST(GatheredTensor, OfOneFrameIsTheFrame) {
  EXPECT_EQ(gathered("3:1", 1), "int16 3:1");
}

TEST(GatheredTensor, HasLimits) {
  EXPECT_EQ(gathered("2:1:1:1:1:1:1:1:1:1:1:1:1:1:1:1", 4),
            "int16 2:1:1:1:1:1:1:1:1:1:1:1:1:1:1:4");
  for (const auto& [shape, frames] :
       {std::pair{"1:1:1:1:1:1:1:1:1:1:1:1:1:1:1:2", 2u}, std::pair{"4294967295:1073741824", 4u}}) {
    const auto text = gathered(shape, frames);
    EXPECT_SAYS(text, "WEIR-2006: frames of this tensor cannot be combined");
    EXPECT_SAYS(text, "fix: tensor_converter frames-per-tensor=1");
  }
}

}  // namespace stacked_tensor_test
}  // namespace weir
