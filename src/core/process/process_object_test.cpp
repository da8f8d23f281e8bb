// Tests that each name has one object in the process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/process/process_object.hpp"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace weir::process {
namespace process_object_test {

struct Counted {
  Counted() { ++made; }
  static inline int made = 0;
  int value = 0;
};
struct Other {
  char bytes[100] = {};
};

TEST(ProcessObject, IsCreatedOnceByManyThreads) {
  std::vector<Counted*> seen(4);
  {
    std::vector<std::jthread> threads;
    for (auto& place : seen)
      threads.emplace_back([&place] { place = &object<Counted>("test.counted"); });
  }
  EXPECT_EQ(Counted::made, 1);
  for (const auto* one : seen) EXPECT_EQ(one, seen[0]);
}

TEST(ProcessObject, DiffersByNameAndSize) {
  EXPECT_NE(&object<Other>("test.one"), &object<Other>("test.two"));
  EXPECT_NE(static_cast<void*>(&object<Other>("test.one")),
            static_cast<void*>(&object<int>("test.one")));
}

TEST(ProcessObject, ComesFromTheGivenProvider) {
  static Other theirs;
  take_objects_from([](const char*, size_t, Make) -> void* { return &theirs; });
  EXPECT_EQ(&object<Other>("test.one"), &theirs);
  take_objects_from(local_object);
  EXPECT_NE(&object<Other>("test.one"), &theirs);
}

}  // namespace process_object_test
}  // namespace weir::process
