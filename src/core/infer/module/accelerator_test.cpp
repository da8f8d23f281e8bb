// Tests the grammar of accelerator and the choice made (docs/compatibility/filter.md 4.4).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/accelerator.hpp"

#include <gtest/gtest.h>

#include "says.hpp"

namespace weir::infer {
namespace accelerator_test {

using Names = std::vector<std::string>;
using Kind = AcceleratorRequest::Kind;

std::string chosen(std::string_view text, const Names& supported) {
  return choose_accelerator(parse_accelerator(text), supported);
}

TEST(Accelerator, NothingSetIsTheEnginesDefault) {
  EXPECT_EQ(parse_accelerator("").kind, Kind::EngineDefault);
  EXPECT_EQ(chosen("", {"gpu", "cpu"}), "");
}

TEST(Accelerator, FalseDisablesAllListedAccelerators) {
  EXPECT_EQ(chosen("false", {"gpu"}), "none");
  EXPECT_EQ(chosen("FALSE:gpu", {"gpu"}), "none");
}

TEST(Accelerator, TheFirstListedNameThatTheEngineSupportsWins) {
  EXPECT_EQ(chosen("true:npu,gpu,cpu", {"cpu", "gpu"}), "gpu");
  EXPECT_EQ(chosen("True:(NPU, Gpu)", {"cpu", "gpu"}), "gpu");
  EXPECT_EQ(chosen("true:cpu.neon", {"cpu", "cpu.simd"}), "cpu.neon") << "the same hardware";
}

TEST(Accelerator, WithoutASupportedNameTheEngineChooses) {
  EXPECT_EQ(chosen("true", {"gpu", "cpu"}), "gpu") << "its first";
  EXPECT_EQ(chosen("true:npu.edgetpu", {"gpu", "cpu"}), "gpu");
  EXPECT_EQ(chosen("true:auto,cpu", {"gpu", "cpu"}), "gpu");
  EXPECT_EQ(chosen("true:none", {"gpu"}), "none");
  EXPECT_EQ(chosen("true:default", {"gpu"}), "");
}

TEST(Accelerator, NamesWithAnExclamationMarkAreLeftOut) {
  EXPECT_EQ(chosen("true:!gpu", {"gpu", "cpu"}), "cpu");
  EXPECT_EQ(chosen("true:gpu,!gpu", {"gpu", "cpu"}), "cpu");
  EXPECT_EQ(chosen("true:!gpu,!cpu", {"gpu", "cpu"}), "none");
}

std::string warning_of(const char* text, const std::vector<std::string>& supported) {
  const auto warning =
      unavailable_hardware(parse_accelerator(text), supported, "onnxruntime", text);
  return warning ? warning->message() : "";
}

TEST(Accelerator, HardwareThatTheEngineDoesNotHaveIsAWarning) {
  EXPECT_EQ(warning_of("true:gpu", {"cpu"}),
            "WEIR-1004: the engine onnxruntime has no accelerator gpu: cpu is used\n"
            "  offered: accelerator=true:gpu\n  needed: one of: cpu\n"
            "  fix: accelerator=true:cpu");
  EXPECT_SAYS(warning_of("true:npu,gpu", {"cpu"}), "has no accelerator npu, gpu: cpu is used");
  EXPECT_SAYS(warning_of("true:npu,!gpu", {"gpu", "cpu"}), "has no accelerator npu: cpu is used");
}

TEST(Accelerator, HardwareWithAnAlternativeThatTheEngineHasIsNoWarning) {
  for (const char* text :
       {"", "true", "false", "false:gpu", "true:gpu,cpu", "true:auto", "true:npu,auto",
        "true:default", "true:none", "true:cpu", "true:!gpu", "yes"})
    EXPECT_EQ(warning_of(text, {"cpu"}), "") << text;
  EXPECT_EQ(warning_of("true:gpu", {"gpu", "cpu"}), "");
  EXPECT_EQ(warning_of("true:gpu", {}), "") << "the engine does not say what it has";
}

TEST(Accelerator, AnEngineThatListsNothingReceivesAllNames) {
  EXPECT_EQ(chosen("true:npu,gpu,!cpu", {}), "npu,gpu");
  EXPECT_EQ(chosen("true", {}), "auto");
}

TEST(Accelerator, AnInvalidTextDisablesAccelerationAndReportsThePlace) {
  const std::pair<const char*, const char*> faults[] = {
      {"yes", "at \"yes\""},        {"true:cpu,gqu", "at \"gqu\", did you mean gpu?"},
      {"true:", "at \"\""},         {"true:cpu,,gpu", "at \"\""},
      {"true:(cpu", "at \"(cpu\""}, {"tru:cpu", "at \"tru\", did you mean true?"},
      {"true:!", "at \"!\""},
  };
  for (const auto& [text, words] : faults) {
    std::optional<Error> warning;
    EXPECT_EQ(choose_accelerator(parse_accelerator(text, &warning), {"cpu"}), "none") << text;
    ASSERT_TRUE(warning) << text;
    EXPECT_EQ(warning->code, Code::OPTION_VALUE);
    EXPECT_SAYS(warning->message(), words);
    EXPECT_SAYS(warning->message(), text);
  }
  std::optional<Error> warning;
  parse_accelerator("true:(cpu,!npu)", &warning);
  EXPECT_FALSE(warning);
}

TEST(Accelerator, NamesHaveTheDocumentedNumbers) {
  EXPECT_EQ(accelerator_number("cpu"), 0x1000u);
  EXPECT_EQ(accelerator_number("cpu.simd"), accelerator_number("cpu.neon"));
  EXPECT_EQ(accelerator_number("npu.sr"), 0x4100u);
  EXPECT_EQ(accelerator_number("tpu"), std::nullopt);
}

}  // namespace accelerator_test
}  // namespace weir::infer
