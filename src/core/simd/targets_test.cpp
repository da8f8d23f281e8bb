// Detects the same targets as Highway's own library.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <dlfcn.h>
#include <gtest/gtest.h>

#include "hwy/highway.h"

namespace targets_test {

TEST(SimdTargets, AreThoseThatHighwayFinds) {
  void* library = dlopen("libhwy.so.1", RTLD_NOW | RTLD_LOCAL);
  if (!library) GTEST_SKIP() << "Highway's library is not there: apt-get install libhwy1";
  using Function = int64_t();
  auto* const theirs = reinterpret_cast<Function*>(dlsym(library, "_ZN3hwy16SupportedTargetsEv"));
  ASSERT_NE(theirs, nullptr);
  EXPECT_NE(theirs, &hwy::SupportedTargets) << "ours is hidden, theirs is not used";
  EXPECT_EQ(hwy::SupportedTargets() & HWY_TARGETS, theirs() & HWY_TARGETS);
  dlclose(library);
}

TEST(SimdTargets, AreNeverNone) {
  EXPECT_NE(hwy::SupportedTargets() & HWY_TARGETS, 0);
  hwy::DisableTargets(~int64_t{0});
  EXPECT_EQ(hwy::SupportedTargets(), HWY_STATIC_TARGET);
  hwy::DisableTargets(0);
  EXPECT_NE(hwy::SupportedAndGeneratedTargets().size(), 0u);
}

TEST(SimdTargets, ATestChoosesOne) {
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    EXPECT_EQ(hwy::SupportedTargets(), target);
    EXPECT_FALSE(hwy::GetChosenTarget().IsInitialized()) << "it is chosen again";
  }
  hwy::SetSupportedTargetsForTest(0);
}

}  // namespace targets_test
