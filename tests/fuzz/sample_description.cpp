// Fuzz target: reads the JSON files of datareposink and patterns of file names. The first line is a
// pattern, and the rest a description. Accepted samples lie inside of the file.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <string>

#include "core/dataset/file_pattern.hpp"
#include "core/dataset/sample_index.hpp"
#include "fuzz_input.hpp"

namespace {

using namespace weir;
using fuzz::require;

constexpr uint64_t kFileBytes = 4096;

void read_pattern(std::string_view text) {
  const auto pattern = dataset::FilePattern::parse(text);
  if (!pattern) {
    require(!pattern.error().difference.empty(), "an error has its place");
    return;
  }
  require(pattern->name(12345).find("12345") != std::string::npos, "a name has its number");
  require(pattern->name(1) != pattern->name(2), "numbers give different names");
}

void read_samples(const dataset::Description& description) {
  const auto equal = dataset::SampleIndex::of_equal(description.sample_size.value_or(1),
                                                    description.total_samples, "data", kFileBytes);
  if (equal && equal->count() > 0)
    require(equal->offset(equal->count() - 1) + description.sample_size.value_or(1) <= kFileBytes,
            "a sample lies inside of the file");
  const auto listed = dataset::SampleIndex::of_listed(description, "json", "data", kFileBytes);
  if (!listed) return;
  for (uint64_t i = 0; i < listed->count(); ++i) {
    const auto sizes = listed->tensor_sizes(i);
    require(!sizes.empty() && sizes.size() <= 256, "a sample has tensors");
    uint64_t end = listed->offset(i);
    for (const uint64_t bytes : sizes) {
      require(bytes >= 128, "a tensor has a header");
      require(bytes <= kFileBytes - end, "a tensor lies inside of the file");
      end += bytes;
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::FuzzInput input(data, size);
  read_pattern(input.line());
  const auto description = dataset::parse_description("fuzz", input.text());
  if (!description) {
    require(!description.error().what.empty(), "an error has a text");
    return 0;
  }
  const auto again = dataset::parse_description("fuzz", dataset::to_json(*description));
  require(again && *again == *description, "a description is written as it was read");
  read_samples(*description);
  return 0;
}
