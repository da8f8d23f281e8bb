// Video formats as tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/convert/video_tensor.hpp"

#include <gtest/gtest.h>

#include "says.hpp"

namespace weir {
namespace video_tensor_test {

TEST(VideoTensor, HasChannelsInnermost) {
  const auto rgb = video_tensor("RGB", 640, 480, 1);
  ASSERT_TRUE(rgb);
  EXPECT_EQ(rgb->spec.to_string(), "uint8 3:640:480:1");
  EXPECT_EQ(rgb->row_bytes, 1920u);
  EXPECT_EQ(rgb->rows, 480u);
  EXPECT_EQ(video_tensor("ABGR", 5, 7, 2)->spec.to_string(), "uint8 4:5:7:2");
  EXPECT_EQ(video_tensor("GRAY8", 5, 7, 1)->spec.to_string(), "uint8 1:5:7:1");
}

TEST(VideoTensor, OfSixteenBitsIsUint16) {
  const auto gray = video_tensor("GRAY16_LE", 5, 7, 1);
  EXPECT_EQ(gray->spec.to_string(), "uint16 1:5:7:1");
  EXPECT_EQ(gray->row_bytes, 10u);
}

TEST(VideoTensor, OfAPlanarFormatHasChannelsOutside) {
  const auto planar = video_tensor("BGRP", 8, 4, 1);
  EXPECT_EQ(planar->spec.to_string(), "uint8 8:4:3:1");
  EXPECT_EQ(planar->rows, 12u);
}

TEST(VideoTensor, RejectsOtherFormatsWithAFix) {
  const auto r = video_tensor("NV12", 8, 4, 1);
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Code::FORMAT_UNSUPPORTED);
  EXPECT_SAYS(r.error().fix, "videoconvert");
  EXPECT_FALSE(video_tensor("rgb", 8, 4, 1));
}

TEST(VideoTensor, RejectsEmptyAndOversizedFrames) {
  EXPECT_FALSE(video_tensor("RGB", 0, 4, 1));
  EXPECT_FALSE(video_tensor("RGBA", 4294967295u, 4294967295u, 4294967295u));
  EXPECT_FALSE(video_tensor("RGB", 8, 4, 0)) << "no frame";
}

TEST(VideoTensor, RejectsMorePlanarRowsThanCanBeCounted) {
  const auto r = video_tensor("RGBP", 1, 1431655766u, 1);  // 3 * 1431655766 = 2^32 + 2
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Code::LIMIT_EXCEEDED);
  EXPECT_SAYS(r.error().needed, "rows");
  EXPECT_EQ(video_tensor("RGBP", 1, 1431655765u, 1)->rows, 4294967295u);
}

}  // namespace video_tensor_test
}  // namespace weir
