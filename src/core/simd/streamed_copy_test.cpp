// Copies of every length between all alignments, on every SIMD target of this CPU.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/simd/streamed_copy.hpp"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <vector>

namespace weir {
namespace streamed_copy_test {

TEST(StreamedCopy, WritesTheGivenBytesAndNothingElse) {
  constexpr size_t kLine = 64, kMax = 3 * kLine;
  std::vector<std::byte> from(kMax + kLine), to(kMax + 2 * kLine);
  for (size_t i = 0; i < from.size(); ++i) from[i] = static_cast<std::byte>(i + 1);
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    SCOPED_TRACE(hwy::TargetName(target));
    for (size_t at = 0; at < kLine; at += 3)
      for (size_t length = 0; length <= kMax; ++length) {
        const size_t begin = length % kLine;  // varies the source alignment
        std::fill(to.begin(), to.end(), std::byte{0});
        copy_streamed(to.data() + at, from.data() + begin, length);
        flush_streamed();
        for (size_t i = 0; i < to.size(); ++i)
          ASSERT_EQ(to[i], i >= at && i < at + length ? from[begin + i - at] : std::byte{0})
              << length << " bytes to " << at << ", byte " << i;
      }
  }
  hwy::SetSupportedTargetsForTest(0);
}

}  // namespace streamed_copy_test
}  // namespace weir
