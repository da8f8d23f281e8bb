// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/dataset/sample_index.hpp"

#include <utility>

#include "core/tensor/tensor_header.hpp"

namespace weir::dataset {
namespace {

constexpr char kRecordAgain[] =
    "datareposrc with the location and the json that one datareposink wrote";

Error does_not_fit(std::string offered, std::string needed, std::string difference) {
  return Error{.code = Code::SAMPLES_INVALID,
               .what = "the description does not fit the file of the samples",
               .offered = std::move(offered),
               .needed = std::move(needed),
               .difference = std::move(difference),
               .fix = kRecordAgain};
}

std::string entry(const char* list, uint64_t index, uint64_t value) {
  return std::string(list) + "[" + std::to_string(index) + "] is " + std::to_string(value);
}

// Finds the first contradiction in the lists of a description.
class ListCheck {
 public:
  ListCheck(const Description& description, const std::string& json, const std::string& path,
            uint64_t file_bytes)
      : description_(description),
        sizes_(*description.sizes),
        json_(json),
        path_(path),
        file_bytes_(file_bytes) {}

  Status run() const {
    const uint64_t total = description_.total_samples;
    for (const auto& [name, length] : {std::pair("sample_offset", sizes_.sample_offset.size()),
                                       std::pair("tensor_count", sizes_.tensor_count.size())})
      if (length != total)
        return wrong(std::string(name) + " has " + std::to_string(length) +
                     " elements, total_samples is " + std::to_string(total));
    for (uint64_t i = 0; i < total; ++i)
      if (auto status = check_sample(i); !status) return status;
    return ok();
  }

 private:
  Error wrong(std::string difference) const {
    return does_not_fit(json_, "lists of one recording", std::move(difference));
  }

  Status check_sample(uint64_t i) const {
    const uint64_t first = sizes_.tensor_count[i];
    const bool is_last = i + 1 == sizes_.tensor_count.size();
    const uint64_t end = is_last ? sizes_.tensor_size.size() : sizes_.tensor_count[i + 1];
    if (i == 0 && first != 0) return wrong(entry("tensor_count", 0, first) + ", not 0");
    if (first >= end && is_last)
      return wrong(entry("tensor_count", i, first) + ", but tensor_size has " +
                   std::to_string(end) + " elements");
    if (first >= end)
      return wrong(entry("tensor_count", i + 1, end) + ", which is not more than " +
                   entry("tensor_count", i, first));
    if (end - first > kTensorLimit)
      return wrong("sample " + std::to_string(i) + " has " + std::to_string(end - first) +
                   " tensors, at most " + std::to_string(kTensorLimit));
    return check_bytes(i, first, end);
  }

  Status check_bytes(uint64_t i, uint64_t first, uint64_t end) const {
    uint64_t last_byte = sizes_.sample_offset[i];
    for (uint64_t t = first; t < end; ++t) {
      if (t >= sizes_.tensor_size.size())
        return wrong(entry("tensor_count", i + 1, end) + ", but tensor_size has " +
                     std::to_string(sizes_.tensor_size.size()) + " elements");
      const uint64_t bytes = sizes_.tensor_size[t];
      if (bytes < kTensorHeaderBytes)
        return wrong(entry("tensor_size", t, bytes) + ", less than the " +
                     std::to_string(kTensorHeaderBytes) + " bytes of a header");
      if (__builtin_add_overflow(last_byte, bytes, &last_byte) || last_byte > file_bytes_)
        return does_not_fit(path_ + ": " + std::to_string(file_bytes_) + " bytes",
                            "the tensors that " + json_ + " lists",
                            "sample " + std::to_string(i) + ": " +
                                entry("sample_offset", i, sizes_.sample_offset[i]) +
                                ", and tensor " + std::to_string(t - first) +
                                " of it ends beyond the file");
    }
    return ok();
  }

  const Description& description_;
  const Description::Sizes& sizes_;
  const std::string &json_, &path_;
  uint64_t file_bytes_;
};

}  // namespace

Result<SampleIndex> SampleIndex::of_equal(uint64_t bytes, uint64_t count, const std::string& path,
                                          uint64_t file_bytes) {
  uint64_t all = 0;
  if (bytes == 0) return does_not_fit("samples of 0 bytes", "a sample_size of 1 byte or more", "");
  if (__builtin_mul_overflow(bytes, count, &all) || all > file_bytes)
    return does_not_fit(path + ": " + std::to_string(file_bytes) + " bytes",
                        std::to_string(count) + " samples of " + std::to_string(bytes) + " bytes",
                        "sample " + std::to_string(file_bytes / bytes) + " is not complete");
  SampleIndex out;
  out.bytes_ = bytes;
  out.count_ = count;
  return out;
}

Result<SampleIndex> SampleIndex::of_listed(Description description, const std::string& json,
                                           const std::string& path, uint64_t file_bytes) {
  if (!description.sizes)
    return does_not_fit(json, "the lists sample_offset, tensor_size and tensor_count",
                        "the members are missing, and the tensors have headers");
  if (auto status = ListCheck(description, json, path, file_bytes).run(); !status)
    return status.error();
  SampleIndex out;
  out.count_ = description.total_samples;
  out.sizes_ = *std::move(description.sizes);
  return out;
}

std::span<const uint64_t> SampleIndex::tensor_sizes(uint64_t sample) const noexcept {
  if (bytes_ > 0) return {};
  const uint64_t first = sizes_.tensor_count[sample];
  const uint64_t end =
      sample + 1 < count_ ? sizes_.tensor_count[sample + 1] : sizes_.tensor_size.size();
  return std::span(sizes_.tensor_size).subspan(first, end - first);
}

}  // namespace weir::dataset
