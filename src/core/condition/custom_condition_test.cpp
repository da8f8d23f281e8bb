// Conditions registered in the process, through C and C++.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/condition/custom_condition.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <thread>

#include <cstring>
#include <stdexcept>

#include "says.hpp"
#include "weir/custom_condition.hpp"

namespace weir::condition {
namespace custom_condition_test {

// True above *data; 0 drops, 255 fails, 254 fails without a message.
int above(const weir_host* host, const weir_frame* in, int* result, void* data, weir_error* error) {
  const auto value = *static_cast<const uint8_t*>(in->tensors[0].data);
  if (value == 255)
    return host->fail(error, WEIR_SPEC_MISMATCH, "255 is too much", "255", "less", nullptr,
                      nullptr);
  if (value == 254) return -WEIR_INTERNAL;
  if (value == 0) return 1;
  *result = value > *static_cast<int*>(data) ? 42 : 0;
  return WEIR_OK;
}

Result<std::optional<bool>> decide(CustomCondition* condition, uint8_t value) {
  weir_tensor tensor{};
  tensor.data = &value;
  tensor.bytes = 1;
  weir_frame frame{};
  frame.tensors = &tensor;
  frame.n_tensors = 1;
  return condition->decide(frame);
}

TEST(CustomCondition, CallsTheFunctionWithItsData) {
  int limit = 5;
  ASSERT_EQ(weir_condition_register("above", above, &limit), WEIR_OK);
  EXPECT_TRUE(is_custom_condition("above"));
  CustomCondition condition("above");
  EXPECT_EQ(*decide(&condition, 6), true);
  EXPECT_EQ(*decide(&condition, 5), false);
  EXPECT_EQ(*decide(&condition, 0), std::nullopt);
  EXPECT_EQ(weir_condition_unregister("above"), WEIR_OK);
  EXPECT_EQ(decide(&condition, 6).error().code, Code::CALLBACK_UNKNOWN) << "its data may be gone";
  int other_limit = 7;
  ASSERT_EQ(weir_condition_register("above", above, &other_limit), WEIR_OK);
  EXPECT_EQ(*decide(&condition, 6), false) << "the one that has the name now";
  EXPECT_EQ(weir_condition_unregister("above"), WEIR_OK);
  CustomCondition later("above");
  EXPECT_EQ(decide(&later, 6).error().code, Code::CALLBACK_UNKNOWN);
}

TEST(CustomCondition, UnregisterWaitsForARunningCall) {
  struct Slow {
    std::promise<void> entered, unregistered;
    std::atomic<bool> has_ended = false;
  } slow;
  const auto function = [](const weir_host*, const weir_frame*, int*, void* data, weir_error*) {
    auto* to = static_cast<Slow*>(data);
    to->entered.set_value();
    to->unregistered.get_future().wait_for(std::chrono::milliseconds(50));
    to->has_ended = true;
    return 0;
  };
  ASSERT_EQ(weir_condition_register("slow", function, &slow), WEIR_OK);
  CustomCondition condition("slow");
  std::jthread caller([&] { EXPECT_TRUE(decide(&condition, 1)); });
  slow.entered.get_future().wait();
  EXPECT_EQ(weir_condition_unregister("slow"), WEIR_OK);
  EXPECT_TRUE(slow.has_ended);
  slow.unregistered.set_value();
}

TEST(CustomCondition, MayUnregisterItself) {
  const auto function = [](const weir_host*, const weir_frame*, int*, void*, weir_error*) {
    return weir_condition_unregister("own");
  };
  ASSERT_EQ(weir_condition_register("own", function, nullptr), WEIR_OK);
  CustomCondition condition("own");
  EXPECT_EQ(*decide(&condition, 1), false);
  EXPECT_FALSE(decide(&condition, 1));
}

TEST(CustomCondition, MayBeRegisteredAfterItIsNamed) {
  int limit = 5;
  CustomCondition condition("above");
  EXPECT_FALSE(decide(&condition, 6));
  ASSERT_EQ(weir_condition_register("above", above, &limit), WEIR_OK);
  EXPECT_EQ(*decide(&condition, 6), true);
  EXPECT_EQ(weir_condition_unregister("above"), WEIR_OK);
}

TEST(CustomCondition, ReportsTheNameAndReasonOfAFailure) {
  int limit = 5;
  ASSERT_EQ(weir_condition_register("above", above, &limit), WEIR_OK);
  CustomCondition condition("above");
  const auto text = decide(&condition, 255).error().message();
  EXPECT_SAYS(text, "WEIR-5003: the condition above failed: 255 is too much");
  EXPECT_SAYS(text, "offered: 255");
  EXPECT_SAYS(text, "needed: less");
  const auto silent = decide(&condition, 254).error().message();
  EXPECT_SAYS(silent, "WEIR-5003: the condition above failed without an error message");
  EXPECT_SAYS(silent, "offered: it returned -");
  EXPECT_SAYS(silent, " for a frame of ");
  EXPECT_SAYS(silent, "needed: 0 for success, above 0 to drop the frame");
  EXPECT_EQ(weir_condition_unregister("above"), WEIR_OK);
}

TEST(CustomCondition, ReportsAnExceptionWithItsName) {
  const auto throwing = [](const weir_host*, const weir_frame*, int*, void*, weir_error*) -> int {
    throw std::runtime_error("thrown in a condition");
  };
  ASSERT_EQ(weir_condition_register("throwing", throwing, nullptr), WEIR_OK);
  CustomCondition condition("throwing");
  const auto text = decide(&condition, 1).error().message();
  EXPECT_SAYS(text, "WEIR-5003: the condition throwing threw an exception");
  EXPECT_SAYS(text, "offered: thrown in a condition");
  EXPECT_EQ(weir_condition_unregister("throwing"), WEIR_OK);
}

TEST(CustomCondition, ListsTheKnownNamesForAnUnknownName) {
  ASSERT_EQ(weir_condition_register("one", above, nullptr), WEIR_OK);
  ASSERT_EQ(weir_condition_register("two", above, nullptr), WEIR_OK);
  CustomCondition condition("three");
  const auto text = decide(&condition, 1).error().message();
  EXPECT_SAYS(text, "WEIR-5002: no condition is registered under this name");
  EXPECT_SAYS(text, "offered: compared-value-option=three");
  EXPECT_SAYS(text, "needed: one of: one, two");
  EXPECT_SAYS(text, "weir_condition_register(\"three\", function, data)");
  EXPECT_EQ(weir_condition_unregister("one"), WEIR_OK);
  EXPECT_EQ(weir_condition_unregister("two"), WEIR_OK);
}

TEST(CustomCondition, SuggestsTheNearestName) {
  ASSERT_EQ(weir_condition_register("bright", above, nullptr), WEIR_OK);
  CustomCondition condition("brigth");
  const auto text = decide(&condition, 1).error().message();
  EXPECT_SAYS(text, "did you mean bright?");
  EXPECT_SAYS(text, "fix: compared-value-option=bright");
  EXPECT_EQ(weir_condition_unregister("bright"), WEIR_OK);
}

TEST(CustomCondition, RequiresAnUnusedNameAndAFunction) {
  EXPECT_EQ(weir_condition_register(nullptr, above, nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(weir_condition_register("", above, nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(weir_condition_register("none", nullptr, nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(weir_condition_register("twice", above, nullptr), WEIR_OK);
  EXPECT_EQ(weir_condition_register("twice", above, nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(weir_condition_unregister("twice"), WEIR_OK);
  EXPECT_EQ(weir_condition_unregister("twice"), -WEIR_CALLBACK_UNKNOWN);
  EXPECT_EQ(weir_condition_unregister(nullptr), -WEIR_CALLBACK_UNKNOWN);
}

TEST(RegisteredConditionInCpp, IsRegisteredForItsLifetime) {
  {
    int calls = 0;
    const RegisteredCondition odd("odd", [&calls](const weir_frame& frame) {
      ++calls;
      return *static_cast<const uint8_t*>(frame.tensors[0].data) % 2 == 1;
    });
    CustomCondition condition("odd");
    EXPECT_EQ(*decide(&condition, 3), true);
    EXPECT_EQ(*decide(&condition, 4), false);
    EXPECT_EQ(calls, 2);
  }
  EXPECT_FALSE(is_custom_condition("odd"));
}

TEST(RegisteredConditionInCpp, ConvertsExceptionsToErrors) {
  const RegisteredCondition throwing("throwing", [](const weir_frame& frame) -> bool {
    switch (*static_cast<const uint8_t*>(frame.tensors[0].data)) {
      case 0:
        throw Failure({.code = Code::SPEC_MISMATCH,
                       .what = "a failure",
                       .offered = "this",
                       .needed = "that"});
      case 1:
        throw std::runtime_error("an exception");
      case 2:
        throw std::bad_alloc();
      default:
        throw 7;
    }
  });
  CustomCondition condition("throwing");
  const auto text = [&](uint8_t value) { return decide(&condition, value).error().message(); };
  EXPECT_SAYS(text(0), "WEIR-5003: the condition throwing failed: a failure\n  offered: this");
  EXPECT_SAYS(text(1), "the condition throwing failed: an exception");
  EXPECT_SAYS(text(2), "memory ran out in a condition");
  EXPECT_SAYS(text(3), "an unknown exception in a condition");
}

TEST(RegisteredConditionInCpp, RejectsATakenNameAndAMissingFunction) {
  const auto always = [](const weir_frame&) { return true; };
  const RegisteredCondition first("first", always);
  EXPECT_THROW(RegisteredCondition("first", always), Failure);
  EXPECT_THROW(RegisteredCondition("", always), Failure);
  EXPECT_THROW(RegisteredCondition("empty", {}), Failure);
  EXPECT_TRUE(is_custom_condition("first"));
}

}  // namespace custom_condition_test
}  // namespace weir::condition
