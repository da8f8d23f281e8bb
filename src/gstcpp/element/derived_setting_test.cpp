// DerivedSetting: computed once, and never stale after a change.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/derived_setting.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <future>

namespace weir::gst {
namespace derived_setting_test {

TEST(DerivedSetting, IsComputedOnceUntilItIsReset) {
  DerivedSetting<int> derived;
  int computed = 0;
  const auto get = [&] { return *derived.get([&] { return ++computed; }); };
  EXPECT_EQ(get(), 1);
  EXPECT_EQ(get(), 1);
  derived.reset();
  EXPECT_EQ(get(), 2);
}

TEST(DerivedSetting, KeepsAValueThatIsStillInUse) {
  DerivedSetting<int> derived;
  const auto first = derived.get([] { return 1; });
  derived.reset();
  EXPECT_EQ(*first, 1);
  EXPECT_NE(derived.get([] { return 2; }), first);
}

TEST(DerivedSetting, DiscardsAValueIfASettingChangesWhileItIsComputed) {
  DerivedSetting<int> derived;
  std::atomic<int> setting = 1;
  std::promise<void> has_read, may_return;
  auto reader = std::async(std::launch::async, [&] {
    return *derived.get([&] {
      const int read = setting;
      has_read.set_value();
      may_return.get_future().wait();
      return read;
    });
  });
  has_read.get_future().wait();
  setting = 2;
  auto writer = std::async(std::launch::async, [&] { derived.reset(); });
  may_return.set_value();
  EXPECT_EQ(reader.get(), 1);
  writer.get();
  EXPECT_EQ(*derived.get([&] { return setting.load(); }), 2);
}

}  // namespace derived_setting_test
}  // namespace weir::gst
