// input-combination and output-combination: what they select and reject.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/filter/combination.hpp"

#include <gtest/gtest.h>

#include "says.hpp"

namespace weir {
namespace combination_test {

TEST(InputCombination, KeepsTheOrderGiven) {
  const auto r = parse_input_combination(" 2, 0 ");
  ASSERT_TRUE(r);
  EXPECT_EQ(*r, (std::vector<size_t>{2, 0}));
}

TEST(InputCombination, EmptyMeansAll) {
  EXPECT_TRUE(parse_input_combination("")->empty());
}

TEST(InputCombination, RejectsTextThatIsNotAnIndex) {
  for (const char* text : {"a", "1,,2", "-1", "1;2", "256", "1.5", ","}) {
    const auto r = parse_input_combination(text);
    ASSERT_FALSE(r) << text;
    EXPECT_EQ(r.error().code, Code::OPTION_SYNTAX);
    EXPECT_EQ(r.error().offered, text);
  }
}

TEST(OutputCombination, PutsInputsFirstAndOutputsInModelOrder) {
  const auto r = parse_output_combination("o2,i1,o0,i0");
  ASSERT_TRUE(r);
  EXPECT_EQ(r->inputs, (std::vector<size_t>{1, 0}));
  EXPECT_EQ(r->outputs, (std::vector<size_t>{0, 2}));
}

TEST(OutputCombination, RejectsOtherLetters) {
  for (const char* text : {"0", "x1", "i", "o-1", "i0 o1", "o999"})
    EXPECT_FALSE(parse_output_combination(text)) << text;
}

TEST(ChooseTensors, NamesThePropertyAndTheIndex) {
  const std::vector<TensorSpec> tensors{{ElementType::UInt8, Shape{3}, ""}};
  EXPECT_EQ(choose_tensors(tensors, {}, "input-combination")->size(), 1u);
  const auto r = choose_tensors(tensors, {1}, "input-combination");
  ASSERT_FALSE(r);
  EXPECT_SAYS(r.error().what, "input-combination");
  EXPECT_NE(r.error().offered.find('1'), std::string::npos);
}

}  // namespace combination_test
}  // namespace weir
