// The grammar of the arithmetic option and its type rules.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/transform.hpp"

#include <gtest/gtest.h>

#include "says.hpp"

namespace weir::transform {
namespace arithmetic_test {

Arithmetic arithmetic_of(std::string_view option) {
  const auto operation = parse(Mode::Arithmetic, option);
  EXPECT_TRUE(operation) << operation.error().message();
  return operation ? std::get<Arithmetic>(operation->what) : Arithmetic{};
}

Error refusal_of(std::string_view option) {
  const auto operation = parse(Mode::Arithmetic, option);
  EXPECT_FALSE(operation) << option;
  return operation ? Error{} : operation.error();
}

TEST(ArithmeticOption, ReadsATypecastAndOperatorsInOrder) {
  const auto read = arithmetic_of("typecast:float32,add:-127.5,mul:2,div:1e1");
  EXPECT_EQ(read.to, ElementType::Float32);
  EXPECT_FALSE(read.channel_dimension);
  ASSERT_EQ(read.steps.size(), 3u);
  EXPECT_EQ(read.steps[0].op, Operator::Add);
  EXPECT_EQ(std::get<double>(read.steps[0].operand), -127.5);
  EXPECT_EQ(read.steps[1].op, Operator::Mul);
  EXPECT_EQ(std::get<int64_t>(read.steps[1].operand), 2);
  EXPECT_EQ(read.steps[2].op, Operator::Div);
  EXPECT_EQ(std::get<double>(read.steps[2].operand), 10.0);
}

TEST(ArithmeticOption, ReadsChannels) {
  const auto read = arithmetic_of("per-channel:true@2,add:1@0,mul:2@15,div:3");
  EXPECT_EQ(read.to, ElementType::End);
  EXPECT_EQ(read.channel_dimension, 2u);
  EXPECT_EQ(read.steps[0].channel, 0u);
  EXPECT_EQ(read.steps[1].channel, 15u);
  EXPECT_FALSE(read.steps[2].channel);
}

TEST(ArithmeticOption, PerChannelFalseIsNoDimension) {
  EXPECT_FALSE(arithmetic_of("per-channel:false,add:1@3").channel_dimension);
}

TEST(ArithmeticOption, CaseIsIgnored) {
  const auto read = arithmetic_of("TypeCast:FLOAT64,PER-CHANNEL:TRUE@1,ADD:1E2@3");
  EXPECT_EQ(read.to, ElementType::Float64);
  EXPECT_EQ(read.channel_dimension, 1u);
  EXPECT_EQ(std::get<double>(read.steps[0].operand), 100.0);
}

TEST(ArithmeticOption, NumbersWithAPointOrExponentAreFloats) {
  const auto operand = [](const std::string& number) {
    return arithmetic_of("add:" + number).steps.at(0).operand;
  };
  EXPECT_EQ(operand("007"), (std::variant<int64_t, double>(int64_t{7})));
  EXPECT_EQ(operand("+5"), (std::variant<int64_t, double>(int64_t{5})));
  EXPECT_EQ(operand("-9223372036854775808"), (std::variant<int64_t, double>(INT64_MIN)));
  EXPECT_EQ(operand(".5"), (std::variant<int64_t, double>(0.5)));
  EXPECT_EQ(operand("-.25e+1"), (std::variant<int64_t, double>(-2.5)));
  EXPECT_EQ(operand("1e0"), (std::variant<int64_t, double>(1.0)));
}

TEST(ArithmeticOption, OnlyTheFirstOfSeveralNumbersCounts) {
  const auto read = arithmetic_of("add:1:2:3@1,mul:4:5.5");
  ASSERT_EQ(read.steps.size(), 2u);
  EXPECT_EQ(std::get<int64_t>(read.steps[0].operand), 1);
  EXPECT_EQ(read.steps[0].channel, 1u);
  EXPECT_EQ(std::get<int64_t>(read.steps[1].operand), 4);
}

TEST(ArithmeticOption, ACommaMayStandAtTheEndOrBeMissing) {
  EXPECT_EQ(arithmetic_of("add:1,").steps.size(), 1u);
  EXPECT_EQ(arithmetic_of("add:1mul:2@3div:4").steps.size(), 3u);
}

TEST(ArithmeticOption, ATypecastAtTheEndIsIgnoredWithAWarning) {
  const auto operation = parse(Mode::Arithmetic, "add:1,typecast:float32");
  ASSERT_TRUE(operation);
  EXPECT_EQ(std::get<Arithmetic>(operation->what).to, ElementType::End);
  ASSERT_EQ(operation->warnings.size(), 1u);
  EXPECT_SAYS(operation->warnings[0], "ignored");
}

TEST(ArithmeticOption, ATypecastInTheMiddleIsRejectedAndMovedInTheFix) {
  const auto error = refusal_of("add:1,typecast:float32,mul:2");
  EXPECT_EQ(error.code, Code::OPTION_SYNTAX);
  EXPECT_EQ(error.needed, "typecast only at the start of the option");
  EXPECT_EQ(error.fix, "option=typecast:float32,add:1,mul:2");
  EXPECT_EQ(error.difference, "at character 7:\n    add:1,typecast:float32,mul:2\n          ^");
}

TEST(ArithmeticOption, TypecastsWithoutOperatorsAreRejected) {
  for (const char* option :
       {"typecast:float32", "typecast:float32,", "typecast:float32,typecast:int8,add:1",
        "per-channel:false,typecast:int8", "per-channel:true@0,typecast:uint8,add:1",
        "typecast:float,add:1", "typecast:,add:1", "typecast:uint8add:1", "typecast:uint88,add:1",
        "add:1,typecast:flaot32", "add:1,typecast:float32,", "add:1,typecast:int8,typecast:int8"})
    EXPECT_EQ(refusal_of(option).code, Code::OPTION_SYNTAX) << option;
}

TEST(ArithmeticOption, BrokenOperatorsAreRejected) {
  for (const char* option : {"",
                             ",",
                             "add",
                             "add:",
                             "add:,",
                             "sub:1",
                             "add:1,,mul:2",
                             ",add:1",
                             " add:1",
                             "add:1 ",
                             "add: 1",
                             "add:1, mul:2",
                             "add:1;mul:2",
                             "add=1",
                             "add:x",
                             "add:1:,mul:2",
                             "add:1:",
                             "add:1,mul",
                             "add:1,2",
                             "1:add"})
    EXPECT_EQ(refusal_of(option).code, Code::OPTION_SYNTAX) << option;
}

TEST(ArithmeticOption, BrokenNumbersAreRejected) {
  for (const char* option : {"add:5.", "add:.", "add:1e", "add:1e+", "add:--1", "add:+-1", "add:+",
                             "add:1.2.3", "add:0x10", "add:nan", "add:inf", "add:1,5", "add:e5"})
    EXPECT_EQ(refusal_of(option).code, Code::OPTION_SYNTAX) << option;
}

TEST(ArithmeticOption, NumbersOutOfRangeAreRejected) {
  for (const char* option :
       {"add:9223372036854775808", "mul:1e400", "div:-1e999", "per-channel:true@16,add:1",
        "per-channel:true@99999999999999999999,add:1", "per-channel:true@0,add:1@4294967296"})
    EXPECT_EQ(refusal_of(option).code, Code::OPTION_VALUE) << option;
}

TEST(ArithmeticOption, BrokenPerChannelsAreRejected) {
  for (const char* option :
       {"per-channel:true,add:1", "per-channel:true@,add:1", "per-channel:true@x,add:1",
        "per-channel:false@0,add:1", "per-channel:yes,add:1", "per-channel:true@0", "per-channel:",
        "per-channel:true@0,", "add:1,per-channel:true@0", "per-channel:true@0,add:1@",
        "per-channel:true@0,add:1@-1", "per-channel:true@0,typecast:int8"})
    EXPECT_EQ(refusal_of(option).code, Code::OPTION_SYNTAX) << option;
}

TEST(ArithmeticOption, TheCaretPointsAtThePlace) {
  EXPECT_EQ(refusal_of("add:1,,mul:2").difference,
            "at character 7:\n    add:1,,mul:2\n          ^");
  EXPECT_EQ(refusal_of("add:").difference, "at the end:\n    add:\n        ^");
  EXPECT_EQ(refusal_of("sub:1").needed, "add:NUMBER, mul:NUMBER or div:NUMBER");
}

TEST(ArithmeticTypes, TheOutputHasTheTypecastsTypeOrTheInputs) {
  const TensorSpec in{ElementType::UInt8, {3, 224, 224}, "image"};
  const auto cast = output_spec(*parse(Mode::Arithmetic, "typecast:float32,add:1"), in);
  ASSERT_TRUE(cast);
  EXPECT_EQ(cast->type, ElementType::Float32);
  EXPECT_EQ(cast->shape.to_string(), "3:224:224");
  EXPECT_EQ(cast->name, "image");
  EXPECT_EQ(output_spec(*parse(Mode::Arithmetic, "add:1"), in)->type, ElementType::UInt8);
}

TEST(ArithmeticTypes, TheInputsTypeIsOpenWithATypecastOnly) {
  const TemplateSpec out{ElementType::Float32, {3, 4}};
  const auto cast = input_candidates(*parse(Mode::Arithmetic, "typecast:float32,add:1"), out);
  ASSERT_TRUE(cast);
  EXPECT_TRUE(cast->type_open());
  EXPECT_EQ(cast->shape, out.shape);
  EXPECT_EQ(input_candidates(*parse(Mode::Arithmetic, "add:1"), out)->type, ElementType::Float32);
  EXPECT_FALSE(input_candidates(*parse(Mode::Arithmetic, "typecast:int8,add:1"), out));
}

}  // namespace arithmetic_test
}  // namespace weir::transform
