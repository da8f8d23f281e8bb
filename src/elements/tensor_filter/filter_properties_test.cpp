// The table of properties of tensor_filter: what each says about the model.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "elements/tensor_filter/filter_properties.hpp"

namespace {

std::vector<std::string> names_with(bool weir::FilterFlags::*flag) {
  std::vector<std::string> names;
  weir::each_flagged([&](const auto& p) {
    if (p.flags.*flag) names.emplace_back(p.name);
  });
  return names;
}

TEST(TensorFilterProperties, ReopenTheModelIfTheyDecideWhichOneItIs) {
  const auto names = names_with(&weir::FilterFlags::reopens);
  const std::set<std::string> expected{"framework",
                                       "input",
                                       "inputtype",
                                       "inputname",
                                       "inputlayout",
                                       "output",
                                       "outputtype",
                                       "outputname",
                                       "outputlayout",
                                       "custom",
                                       "accelerator",
                                       "input-combination",
                                       "output-combination",
                                       "invoke-async",
                                       "shared-tensor-filter-key",
                                       "invoke-dynamic",
                                       "suspend"};
  EXPECT_EQ(std::set(names.begin(), names.end()), expected);
  EXPECT_TRUE(weir::reopens_model("custom"));
  EXPECT_FALSE(weir::reopens_model("model")) << "is-updatable decides";
  EXPECT_FALSE(weir::reopens_model("sub-plugins"));
}

TEST(TensorFilterProperties, AreRepeatedInThisOrderToReplayAFrame) {
  const std::vector<std::string> expected{
      "framework", "model",  "custom",     "accelerator", "input",          "inputtype",
      "inputname", "output", "outputtype", "outputname",  "isolate-memory", "isolate-timeout"};
  EXPECT_EQ(names_with(&weir::FilterFlags::repeated), expected);
}

}  // namespace
