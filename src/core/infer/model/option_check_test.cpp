// Tests which options of custom= an engine of the user takes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/model/option_check.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "says.hpp"

namespace weir::infer {
namespace option_check_test {

using Pairs = std::vector<std::pair<std::string, std::string>>;

constexpr char kOptions[] = R"([
  {"name": "limit", "type": "integer", "default": "127"}, {"name": "gain", "type": "number"},
  {"name": "invert", "type": "boolean", "default": "false"}, {"name": "labels", "type": "file"},
  {"name": "mode", "type": "fast|exact", "default": "exact"}])";

std::string refusal(const Pairs& options, const char* json = kOptions,
                    const char* name = "threshold") {
  weir_engine engine{};
  engine.struct_size = sizeof engine;
  engine.name = name;
  engine.options_json = json;
  const auto status = check_options(engine, options);
  return status ? "" : status.error().message();
}

TEST(OptionCheck, DeclaredKeysWithValuesOfTheirTypeAreTaken) {
  for (const Pairs& options : {Pairs{},
                               {{"limit", "-3"}, {"gain", "1e-3"}, {"invert", "Yes"}},
                               {{"LIMIT", "3"}, {"labels", "any text"}, {"mode", "fast"}},
                               {{"invert", "0"}, {"gain", "2"}}})
    EXPECT_EQ(refusal(options), "");
}

TEST(OptionCheck, AnUnknownKeyIsAnErrorWithTheKnownOnes) {
  EXPECT_EQ(refusal({{"limit", "3"}, {"limt", "99"}}),
            "WEIR-1004: the engine threshold has no such option\n  offered: custom=limt:99\n"
            "  needed: one of: limit, gain, invert, labels, mode\n"
            "  first difference: did you mean limit?\n  fix: custom=limit:99");
  const auto far = refusal({{"threads", "2"}});
  EXPECT_SAYS(far, "offered: custom=threads:2");
  EXPECT_EQ(far.find("fix:"), std::string::npos) << far;
}

TEST(OptionCheck, AValueOfAnotherTypeIsAnError) {
  const auto limit = refusal({{"limit", "many"}});
  EXPECT_SAYS(limit, "WEIR-1004: the engine threshold does not accept this value for limit");
  EXPECT_SAYS(limit, "offered: custom=limit:many\n  needed: an integer\n  fix: custom=limit:127");
  EXPECT_SAYS(refusal({{"limit", "1.5"}}), "needed: an integer");
  EXPECT_SAYS(refusal({{"limit", ""}}), "needed: an integer");
  EXPECT_SAYS(refusal({{"gain", "nan"}}), "needed: a number");
  EXPECT_SAYS(refusal({{"invert", "2"}}), "needed: true or false\n  fix: custom=invert:false");
  EXPECT_SAYS(refusal({{"mode", "slow"}}), "needed: one of: fast, exact\n  fix: custom=mode:exact");
}

TEST(OptionCheck, EnginesThatDeclareNothingOrTakeTheWholeTextAreNotChecked) {
  for (const char* json : {static_cast<const char*>(nullptr), "", "[]", "no json", "{}", "[7]",
                           R"([{"name": "limit"}, {"name": "custom"}])"})
    EXPECT_EQ(refusal({{"anything", "goes"}}, json), "") << (json ? json : "none");
  EXPECT_EQ(refusal({{"anything", "goes"}}, kOptions, "onnxruntime"), "") << "it warns itself";
}

}  // namespace option_check_test
}  // namespace weir::infer
