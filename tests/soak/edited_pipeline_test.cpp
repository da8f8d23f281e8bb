// A playing pipeline is edited at random: nothing hangs, nothing is lost but where a policy says
// so, every ledger adds up. A seed that ever failed stays in the list.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edited_pipeline.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace weir::soak {
namespace {

constexpr int kEdits = 40;

class EditedPipelineWithSeed : public ::testing::TestWithParam<uint32_t> {};

TEST_P(EditedPipelineWithSeed, LosesNothingAndNeverStandsStill) {
  EditedPipeline pipeline(GetParam(), std::getenv("WEIR_TEST_MODEL"));
  for (int i = 0; i < kEdits; ++i) ASSERT_EQ(pipeline.edit(), "");
  EXPECT_EQ(pipeline.finish(), "");
  EXPECT_EQ(pipeline.lost(), 0u);
}

INSTANTIATE_TEST_SUITE_P(Seeds, EditedPipelineWithSeed,
                         ::testing::Values(1u, 2u, 3u, 5u, 8u, 13u, 17u, 20u, 21u, 34u, 45u, 55u,
                                           89u));

}  // namespace
}  // namespace weir::soak
