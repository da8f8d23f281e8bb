// Tensors as boxes, and boxes that find their picture.
#include "core/preprocess/boxes.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <thread>

#include "core/preprocess/box_queue.hpp"

namespace weir::preprocess {
namespace {

using Outcome = BoxQueue::Outcome;
constexpr std::chrono::nanoseconds kLong = std::chrono::minutes(2);

template <class Number>
std::vector<Box> read(ElementType type, const std::vector<Number>& numbers) {
  const TensorSpec spec{type, {4, static_cast<uint32_t>(numbers.size() / 4)}, ""};
  EXPECT_TRUE(check_boxes(spec));
  std::vector<Box> out;
  read_boxes(spec, std::as_bytes(std::span(numbers)), &out);
  return out;
}

TEST(Boxes, AreReadFromBothTypes) {
  EXPECT_EQ(read<uint32_t>(ElementType::UInt32, {1, 2, 3, 4, 4294967295u, 0, 4294967295u, 9}),
            (std::vector<Box>{{1, 2, 3, 4}, {4294967295, 0, 4294967295, 9}}));
  EXPECT_EQ(read<float>(ElementType::Float32, {-1.4f, 2.6f, 3, 1.5f, 0.2f, 0, 0.2f, 5}),
            (std::vector<Box>{{-1, 3, 3, 1}, {}}));
}

TEST(Boxes, ThatAreNoNumbersOrTooBigAreEmptyOrCut) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  const auto boxes = read<float>(
      ElementType::Float32, {kNan, 0, 1, 1,  0,      kInf,   1,     1,     0,      0, -kInf,   1,
                             0,    0, 2, -3, -3e38f, -3e38f, 3e38f, 3e38f, -3e38f, 0, 3.2e38f, 1});
  ASSERT_EQ(boxes.size(), 6u);
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(boxes[i], Box{}) << i;
  const Rect picture{2, 3, 10, 20};
  EXPECT_EQ(common_part(picture, boxes[4]).width, 0u);
  EXPECT_EQ(common_part(picture, boxes[5]), (Rect{2, 3, 10, 0}));
}

TEST(Boxes, AreClipped) {
  const Rect picture{2, 3, 10, 20};
  EXPECT_EQ(common_part(picture, {0, 0, 100, 100}), picture);
  EXPECT_EQ(common_part(picture, {-5, 20, 9, 9}), (Rect{2, 20, 2, 3}));
  EXPECT_EQ(common_part(picture, {12, 3, 1, 1}).width, 0u);
  EXPECT_EQ(common_part(picture, {4, 5, 0, 1}).width, 0u);
}

TEST(Boxes, OfAnotherTypeOrShapeAreRefused) {
  for (const TensorSpec& spec :
       {TensorSpec{ElementType::Int32, {4, 2}, ""}, TensorSpec{ElementType::Float32, {5, 2}, ""},
        TensorSpec{ElementType::Float32, {4, 2, 2}, ""}, TensorSpec{ElementType::UInt32, {}, ""}}) {
    const auto status = check_boxes(spec);
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, Code::SPEC_MISMATCH);
    EXPECT_NE(status.error().message().find("uint32 4:N or float32 4:N"), std::string::npos);
  }
  EXPECT_TRUE(check_boxes({ElementType::UInt32, {4, 7, 1, 1}, ""}));
  EXPECT_TRUE(check_boxes({ElementType::UInt32, {4}, ""}));
}

TEST(BoxQueue, GivesTheBoxesOfTheSameTime) {
  BoxQueue queue;
  std::vector<Box> out;
  for (const int64_t time : {10, 20, 40}) queue.bring(time, {{time, 0, 1, 1}});
  EXPECT_EQ(queue.take(20, kLong, &out), Outcome::Found);
  EXPECT_EQ(out, (std::vector<Box>{{20, 0, 1, 1}}));
  EXPECT_EQ(queue.unused(), 1u);
  EXPECT_EQ(queue.take(30, kLong, &out), Outcome::None);
  EXPECT_TRUE(out.empty());
  EXPECT_EQ(queue.take(40, kLong, &out), Outcome::Found);
  EXPECT_EQ(queue.unused(), 1u);
}

TEST(BoxQueue, DoesNotWaitForWhatCannotCome) {
  BoxQueue queue;
  std::vector<Box> out;
  queue.advance(11);
  EXPECT_EQ(queue.take(10, kLong, &out), Outcome::None);
  EXPECT_EQ(queue.take(11, std::chrono::nanoseconds(1), &out), Outcome::Late);
  queue.end();
  EXPECT_EQ(queue.take(12, kLong, &out), Outcome::None);
  queue.clear();
  EXPECT_EQ(queue.take(1, std::chrono::nanoseconds(0), &out), Outcome::Late);
  queue.flush(true);
  EXPECT_EQ(queue.take(2, kLong, &out), Outcome::Flushed);
  queue.flush(false);
  queue.bring(3, {});
  EXPECT_EQ(queue.take(3, kLong, &out), Outcome::Found);
}

TEST(BoxQueue, WaitsForAnotherThread) {
  BoxQueue queue;
  std::thread other([&] {
    for (int64_t time = 0; time < 1000; ++time) {
      if (time % 3 == 0)
        queue.advance(time + 1);
      else
        queue.bring(time, {{time, 0, 1, 1}});
    }
    queue.end();
  });
  std::vector<Box> out;
  uint64_t found = 0;
  for (int64_t time = 500; time < 1003; ++time) {
    const auto outcome = queue.take(time, kLong, &out);
    EXPECT_TRUE(outcome == Outcome::Found || outcome == Outcome::None);
    if (outcome == Outcome::Found) {
      ++found;
      EXPECT_EQ(out[0].x, time);
      EXPECT_NE(time % 3, 0);
    }
  }
  other.join();
  EXPECT_LE(found, 333u);
  EXPECT_EQ(found + queue.unused(), 666u);
}

TEST(BoxQueue, IsBounded) {
  BoxQueue queue;
  for (size_t i = 0; i < kBoxQueueLimit + 5; ++i) queue.bring(static_cast<int64_t>(i), {});
  EXPECT_EQ(queue.unused(), 5u);
  std::vector<Box> out;
  EXPECT_EQ(queue.take(4, kLong, &out), Outcome::None);
  EXPECT_EQ(queue.take(5, kLong, &out), Outcome::Found);
}

}  // namespace
}  // namespace weir::preprocess
