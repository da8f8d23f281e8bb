// Helpers of the records tests: frames of results from numbers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "core/records/record_writer.hpp"
#include "core/records/result_frame.hpp"
#include "says.hpp"

namespace weir::records {

inline constexpr char kBoxes[] = "x1,y1,x2,y2,score,class";

// The tensors of a frame and their memory.
class TestFrame {
 public:
  TestFrame& floats(const std::string& dimensions, const std::vector<float>& values) {
    return add(ElementType::Float32, dimensions, values);
  }
  TestFrame& bytes(const std::string& dimensions, const std::vector<uint8_t>& values) {
    return add(ElementType::UInt8, dimensions, values);
  }
  // uint8 L:N, zeros after each text.
  TestFrame& texts(size_t length, const std::vector<std::string>& texts) {
    std::vector<uint8_t> values(length * texts.size());
    for (size_t i = 0; i < texts.size(); ++i)
      std::memcpy(values.data() + i * length, texts[i].data(), std::min(length, texts[i].size()));
    return bytes(std::to_string(length) + ":" + std::to_string(texts.size()), values);
  }
  template <class T>
  TestFrame& add(ElementType type, const std::string& dimensions, const std::vector<T>& values) {
    // One byte after the memory's start: no alignment.
    memories_.push_back(std::make_shared<std::vector<std::byte>>(values.size() * sizeof(T) + 1));
    auto& memory = *memories_.back();
    if (!values.empty()) std::memcpy(memory.data() + 1, values.data(), values.size() * sizeof(T));
    tensors.push_back({{.type = type, .shape = Shape::parse(dimensions), .name = {}},
                       std::span(memory).subspan(1)});
    return *this;
  }

  std::vector<ResultTensor> tensors;

 private:
  // Copies of a frame share them.
  std::vector<std::shared_ptr<std::vector<std::byte>>> memories_;
};

// Checks that the text contains each of these.
inline void expect_says(const std::string& text, std::initializer_list<const char*> all) {
  for (const char* words : all) EXPECT_SAYS(text, words);
}

inline ResultReader reader_of(const std::string& columns, const std::string& sources = "") {
  auto reader = ResultReader::make(columns, sources);
  EXPECT_TRUE(reader) << (reader ? "" : reader.error().message());
  return reader ? *std::move(reader) : ResultReader();
}

// What the writer appends for one frame; "(nothing)" if it declines.
inline std::string written(RecordWriter& writer, const ResultReader& reader, const TestFrame& frame,
                           const FrameFacts& facts = {}) {
  ResultFrame objects;
  const Status status = reader.read(frame.tensors, &objects);
  if (!status) return status.error().message();
  std::string out;
  return writer.write(reader, objects, facts, &out) ? out : "(nothing)";
}

}  // namespace weir::records
