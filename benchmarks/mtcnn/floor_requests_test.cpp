// Tests that the floor reads what was written, and repeats inputs when it needs more.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "floor_requests.hpp"

#include <gtest/gtest.h>

#include <filesystem>

namespace control {
namespace floor_requests_test {

using Bytes = std::vector<uint8_t>;

TEST(BytesOf, RepeatAtTheEndOfWhatWasSeen) {
  EXPECT_EQ(repeat_bytes({1, 2, 3}, 7), (Bytes{1, 2, 3, 1, 2, 3, 1}));
  EXPECT_EQ(repeat_bytes({1, 2, 3}, 2), (Bytes{1, 2}));
  EXPECT_EQ(repeat_bytes({1, 2, 3}, 0), Bytes{});
}

TEST(BytesOf, AreOneValueWhereNothingWasSeen) {
  EXPECT_EQ(repeat_bytes({}, 2), (Bytes{140, 140}));
}

TEST(InputsOf, HaveTheLayersOfThePyramidAndAllRegions) {
  const auto inputs = make_inputs({{24, 24}, 2, 1}, 12, {});  // layers of 24, 18 and 13 pixels
  EXPECT_EQ(inputs[0].size(), 3u * (24 * 24 + 18 * 18 + 13 * 13));
  EXPECT_EQ(inputs[1].size(), 2u * 3 * 24 * 24);
  EXPECT_EQ(inputs[2].size(), 3u * 48 * 48);
}

class RequestFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::TempDir() + "floor_requests";
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string folder_;
};

TEST_F(RequestFiles, KeepTheFirstPictureThatANetworkSaw) {
  RequestFile file(folder_ + "/requests");
  *file.wanted(0) = {1, 2};
  file.add({{640, 360}, 0, 0});  // without regions
  EXPECT_EQ(file.wanted(0), nullptr);
  ASSERT_NE(file.wanted(1), nullptr);
  *file.wanted(1) = {3};
  *file.wanted(2) = {4, 5};
  file.add({{640, 360}, 20, 3});
  EXPECT_EQ(file.wanted(1), nullptr);
  EXPECT_EQ(file.wanted(2), nullptr);
  ASSERT_TRUE(file.write());

  const auto requests = read_requests(folder_ + "/requests");
  ASSERT_EQ(requests.size(), 2u);
  EXPECT_EQ(requests[0].refined, 0u);
  EXPECT_EQ(requests[1].picture.width, 640u);
  EXPECT_EQ(requests[1].picture.height, 360u);
  EXPECT_EQ(requests[1].refined, 20u);
  EXPECT_EQ(requests[1].marked, 3u);
  EXPECT_EQ(read_seen(folder_ + "/requests"), (Seen{Bytes{1, 2}, Bytes{3}, Bytes{4, 5}}));
}

TEST_F(RequestFiles, OfNoNameAreNotWritten) {
  RequestFile file("");
  EXPECT_EQ(file.wanted(0), nullptr);
  file.add({{640, 360}, 1, 1});
  EXPECT_TRUE(file.write());
}

TEST_F(RequestFiles, ThatCannotBeWrittenOrReadAreReported) {
  RequestFile file(folder_ + "/nowhere/requests");
  file.add({{640, 360}, 1, 1});
  EXPECT_FALSE(file.write());
  EXPECT_TRUE(read_requests(folder_ + "/nowhere/requests").empty());
  EXPECT_EQ(read_seen(folder_ + "/nowhere/requests"), Seen{});
}

}  // namespace floor_requests_test
}  // namespace control
