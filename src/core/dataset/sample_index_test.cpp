// SampleIndex: where samples lie, and descriptions that contradict themselves or the file.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/dataset/sample_index.hpp"

#include <gtest/gtest.h>

#include "says.hpp"

namespace weir::dataset {
namespace sample_index_test {

Result<SampleIndex> equal(uint64_t bytes, uint64_t count, uint64_t file_bytes) {
  return SampleIndex::of_equal(bytes, count, "data.bin", file_bytes);
}
Result<SampleIndex> listed(uint64_t total, Description::Sizes sizes, uint64_t file_bytes) {
  return SampleIndex::of_listed({.caps = "c", .total_samples = total, .sizes = std::move(sizes)},
                                "data.json", "data.bin", file_bytes);
}
std::vector<uint64_t> tensor_sizes(const SampleIndex& index, uint64_t sample) {
  const auto sizes = index.tensor_sizes(sample);
  return {sizes.begin(), sizes.end()};
}

TEST(SampleIndex, OfEqualSamplesMultiplies) {
  const auto index = equal(12, 3, 36);
  ASSERT_TRUE(index);
  EXPECT_EQ(index->count(), 3u);
  EXPECT_EQ(index->offset(0), 0u);
  EXPECT_EQ(index->offset(2), 24u);
  EXPECT_TRUE(index->tensor_sizes(2).empty());
}

TEST(SampleIndex, CountsBeyond32Bits) {
  const uint64_t huge = uint64_t{1} << 40;
  const auto index = equal(huge, 1 << 20, huge << 20);
  ASSERT_TRUE(index);
  EXPECT_EQ(index->offset((1 << 20) - 1), ((uint64_t{1} << 20) - 1) << 40);
}

TEST(SampleIndex, AcceptsBytesAfterTheLastSample) {
  EXPECT_EQ(equal(12, 3, 40)->count(), 3u);
}

TEST(SampleIndex, NamesTheFirstSampleThatIsNotInTheFile) {
  const auto refused = equal(12, 3, 35);
  EXPECT_REFUSED(refused, SAMPLES_INVALID, "offered: data.bin: 35 bytes");
  EXPECT_REFUSED(refused, SAMPLES_INVALID, "needed: 3 samples of 12 bytes");
  EXPECT_REFUSED(refused, SAMPLES_INVALID, "first difference: sample 2 is not complete");
  EXPECT_REFUSED(equal(1, 1, 0), SAMPLES_INVALID, "sample 0 is not complete");
}

TEST(SampleIndex, RejectsProductsThatOverflow) {
  EXPECT_REFUSED(equal(uint64_t{1} << 40, uint64_t{1} << 40, 100), SAMPLES_INVALID,
                 "sample 0 is not complete");
  EXPECT_REFUSED(equal(0, 5, 100), SAMPLES_INVALID, "a sample_size of 1 byte or more");
}

TEST(SampleIndex, OfListedSamplesHasTheirTensors) {
  const auto index = listed(3, {{0, 260, 400}, {130, 130, 140, 128, 200}, {0, 2, 3}}, 728);
  ASSERT_TRUE(index);
  EXPECT_EQ(index->count(), 3u);
  EXPECT_EQ(index->offset(1), 260u);
  EXPECT_EQ(tensor_sizes(*index, 0), (std::vector<uint64_t>{130, 130}));
  EXPECT_EQ(tensor_sizes(*index, 1), (std::vector<uint64_t>{140}));
  EXPECT_EQ(tensor_sizes(*index, 2), (std::vector<uint64_t>{128, 200}));
}

TEST(SampleIndex, OfNothingIsEmpty) {
  EXPECT_EQ(listed(0, {}, 0)->count(), 0u);
  EXPECT_EQ(equal(5, 0, 0)->count(), 0u);
}

TEST(SampleIndex, NamesTheFirstContradictionBetweenLists) {
  const auto says = [](uint64_t total, Description::Sizes sizes, const char* difference) {
    EXPECT_REFUSED(listed(total, std::move(sizes), 10000), SAMPLES_INVALID,
                   std::string("first difference: ") + difference);
  };
  says(2, {{0}, {130}, {0}}, "sample_offset has 1 elements, total_samples is 2");
  says(1, {{0}, {130}, {}}, "tensor_count has 0 elements, total_samples is 1");
  says(1, {{0}, {130}, {1}}, "tensor_count[0] is 1, not 0");
  says(1, {{0}, {}, {0}}, "tensor_count[0] is 0, but tensor_size has 0 elements");
  says(3, {{0, 0, 0}, {130, 130, 130}, {0, 2, 1}},
       "tensor_count[2] is 1, which is not more than tensor_count[1] is 2");
  says(2, {{0, 0}, {130, 130}, {0, 0}},
       "tensor_count[1] is 0, which is not more than tensor_count[0] is 0");
  says(2, {{0, 0}, {130, 130}, {0, 2}}, "tensor_count[1] is 2, but tensor_size has 2 elements");
  says(2, {{0, 0}, {130, 130}, {0, 200}}, "tensor_count[1] is 200, but tensor_size has 2 elements");
  says(2, {{0, 0}, {130}, {0, UINT64_MAX}},
       "sample 0 has 18446744073709551615 tensors, at most 256");
  says(1, {{0}, std::vector<uint64_t>(257, 128), {0}}, "sample 0 has 257 tensors, at most 256");
  says(1, {{0}, {130, 127}, {0}}, "tensor_size[1] is 127, less than the 128 bytes of a header");
}

TEST(SampleIndex, NamesTheFirstTensorBeyondTheFile) {
  const auto refused = listed(2, {{0, 260}, {130, 130, 140}, {0, 2}}, 399);
  EXPECT_REFUSED(refused, SAMPLES_INVALID, "offered: data.bin: 399 bytes");
  EXPECT_REFUSED(refused, SAMPLES_INVALID,
                 "first difference: sample 1: sample_offset[1] is 260, and tensor 0 of it ends "
                 "beyond the file");
  EXPECT_REFUSED(listed(1, {{UINT64_MAX}, {130}, {0}}, 399), SAMPLES_INVALID,
                 "ends beyond the file");
  EXPECT_REFUSED(listed(1, {{5}, {UINT64_MAX}, {0}}, 399), SAMPLES_INVALID, "ends beyond the file");
}

TEST(SampleIndex, NeedsTheListsOfTensorsWithHeaders) {
  EXPECT_REFUSED(
      SampleIndex::of_listed({.caps = "c", .sample_size = 3}, "data.json", "data.bin", 9),
      SAMPLES_INVALID, "needed: the lists sample_offset, tensor_size and tensor_count");
}

}  // namespace sample_index_test
}  // namespace weir::dataset
