// Compares nonzero elements on every SIMD target of this CPU with a plain loop.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/nonzero.hpp"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cstring>
#include <random>
#include <vector>

namespace weir {
namespace nonzero_test {

struct Found {
  std::vector<std::byte> values;
  std::vector<uint32_t> indices;
  bool operator==(const Found&) const = default;
};

Found plain(const std::vector<std::byte>& dense, NonzeroElements kind, size_t max) {
  Found out;
  for (size_t i = 0; i < dense.size() / kind.size && out.indices.size() < max; ++i) {
    uint64_t value = 0;
    std::memcpy(&value, dense.data() + i * kind.size, kind.size);
    const uint64_t sign = uint64_t{1} << (8 * kind.size - 1);
    if ((kind.is_signed ? value & ~sign : value) == 0) continue;
    out.indices.push_back(static_cast<uint32_t>(i));
    for (size_t b = 0; b < kind.size; ++b) out.values.push_back(dense[i * kind.size + b]);
  }
  return out;
}

Found found(const std::vector<std::byte>& dense, NonzeroElements kind, size_t max) {
  const size_t elements = dense.size() / kind.size;
  // One guard element after each output.
  std::vector<std::byte> values((max + 1) * kind.size, std::byte{0xA5});
  std::vector<std::byte> indices((max + 1) * 4, std::byte{0xA5});
  const size_t count = kind.write(dense.data(), elements, max, values.data(), indices.data());
  for (size_t i = count * kind.size; i < values.size(); ++i) EXPECT_EQ(values[i], std::byte{0xA5});
  for (size_t i = count * 4; i < indices.size(); ++i) EXPECT_EQ(indices[i], std::byte{0xA5});
  Found out;
  values.resize(count * kind.size);
  out.values = values;
  out.indices.resize(count);
  if (count > 0) std::memcpy(out.indices.data(), indices.data(), count * 4);
  return out;
}

// `percent` of the elements are nonzero; some of them have only the highest bit set.
std::vector<std::byte> some(size_t elements, size_t size, unsigned percent, std::mt19937* random) {
  std::vector<std::byte> out(elements * size);
  for (size_t i = 0; i < elements; ++i) {
    if ((*random)() % 100 >= percent) continue;
    if ((*random)() % 4 == 0) out[i * size + size - 1] = std::byte{0x80};
    if ((*random)() % 4 != 0) out[i * size + (*random)() % size] = std::byte((*random)() % 256);
  }
  return out;
}

TEST(NonzeroElements, AreThoseOfAPlainLoopOnEachTarget) {
  std::mt19937 random(7);
  const NonzeroElements kinds[] = {{1, false}, {2, false}, {2, true}, {4, false},
                                   {4, true},  {8, false}, {8, true}};
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    SCOPED_TRACE(hwy::TargetName(target));
    for (const auto kind : kinds)
      for (const size_t elements : {0u, 1u, 63u, 64u, 65u, 200u, 1024u})
        for (const unsigned percent : {0u, 1u, 40u, 100u}) {
          const auto dense = some(elements, kind.size, percent, &random);
          const auto expected = plain(dense, kind, elements);
          EXPECT_EQ(kind.count(dense.data(), elements), expected.indices.size());
          EXPECT_EQ(found(dense, kind, elements), expected)
              << kind.size << " bytes, " << elements << " elements, " << percent << " %";
        }
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST(NonzeroElements, WritesAtMostTheGivenNumber) {
  std::mt19937 random(8);
  for (const NonzeroElements kind : {NonzeroElements{1, false}, NonzeroElements{4, true}}) {
    const auto dense = some(300, kind.size, 60, &random);
    for (const size_t max : {0u, 1u, 64u, 65u})
      EXPECT_EQ(found(dense, kind, max), plain(dense, kind, max)) << max;
  }
}

}  // namespace nonzero_test
}  // namespace weir
