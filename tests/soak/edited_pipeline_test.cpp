// Edits a playing pipeline at random: nothing hangs, frames are lost only where a policy allows it,
// every ledger adds up. Seeds that once failed stay in the list.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edited_pipeline.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace weir::soak {
namespace edited_pipeline_test {

constexpr int kEdits = 40;

class EditedPipelineWithSeed : public ::testing::TestWithParam<uint32_t> {};

TEST_P(EditedPipelineWithSeed, LosesNothingAndNeverStalls) {
  EditedPipeline pipeline(GetParam(), std::getenv("WEIR_TEST_MODEL"));
  for (int i = 0; i < kEdits; ++i) ASSERT_EQ(pipeline.edit(), "");
  EXPECT_EQ(pipeline.finish(), "");
  EXPECT_EQ(pipeline.lost(), 0u);
}

INSTANTIATE_TEST_SUITE_P(Seeds, EditedPipelineWithSeed,
                         ::testing::Values(1u, 2u, 3u, 5u, 8u, 13u, 17u, 20u, 21u, 34u, 45u, 55u,
                                           89u));

}  // namespace edited_pipeline_test
}  // namespace weir::soak
