// Test helpers: tensors of models made from what the networks' papers say, and heads that read
// them as a mode does.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "core/heads/families.hpp"
#include "core/tensor/geometry.hpp"
#include "says.hpp"

namespace weir::heads {

using Floats = std::vector<float>;

// An output with its numbers, of any element type. Dimensions as in caps.
struct TestOutput {
  OutputSignature facts;
  std::vector<std::byte> bytes;
  float scale = 0;
  int32_t zero_point = 0;

  TestOutput(const char* shape, const Floats& numbers, std::string name = "")
      : facts{
            {.type = ElementType::Float32, .shape = Shape::parse(shape), .name = std::move(name)}} {
    set(numbers);
  }
  template <class T>
  static TestOutput of(ElementType type, const char* shape, const std::vector<T>& values,
                       std::string name = "") {
    TestOutput out(shape, {}, std::move(name));
    out.facts.type = type;
    out.set(values);
    return out;
  }
  // real = scale * (value - zero_point), rounded to the nearest of uint8.
  TestOutput quantised(float step, int32_t zero) const {
    std::vector<uint8_t> values;
    for (const float number : floats())
      values.push_back(
          static_cast<uint8_t>(std::clamp(std::lround(number / step) + zero, 0l, 255l)));
    TestOutput out = *this;
    out.facts.type = ElementType::UInt8;
    out.mark_quantised(step, zero);
    out.set(values);
    return out;
  }
  void mark_quantised(float step, int32_t zero) {
    scale = step, zero_point = zero;
    facts.is_quantised = true;
  }
  TestOutput halved() const {  // as float16
    std::vector<float16> values;
    for (const float number : floats()) values.push_back(float16(number));
    TestOutput out = *this;
    out.facts.type = ElementType::Float16;
    out.set(values);
    return out;
  }
  Floats floats() const {
    Floats out(bytes.size() / sizeof(float));
    if (!out.empty()) std::memcpy(out.data(), bytes.data(), bytes.size());
    return out;
  }
  weir_tensor tensor() const {
    weir_tensor out{};
    out.data = const_cast<std::byte*>(bytes.data());
    out.bytes = out.capacity = bytes.size();
    out.info.type = static_cast<uint32_t>(facts.type);
    out.info.rank = static_cast<uint32_t>(facts.shape.rank());
    for (uint32_t i = 0; i < out.info.rank; ++i)
      out.info.shape[i] = facts.shape[out.info.rank - 1 - i];
    out.info.scale = scale, out.info.zero_point = zero_point;
    return out;
  }

 private:
  template <class T>
  void set(const std::vector<T>& values) {
    bytes.resize(values.size() * sizeof(T));
    if (!bytes.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  }
};

struct HeadSetup {
  std::string head{};  // "" = recognised
  uint32_t tasks = kDetection;
  Size input{64, 64};  // 0 x 0: not known
  Size frame{};        // of the frame's source map; 0 x 0: none
  size_t labels = 0;
  std::map<std::string, std::string> metadata{}, custom{};
  float threshold = 0.25f;
};

inline ModelSignature facts_of(const std::vector<TestOutput>& outputs, const HeadSetup& setup) {
  ModelSignature out{
      .outputs = {}, .input = setup.input, .metadata = setup.metadata, .labels = setup.labels};
  for (const auto& output : outputs) out.outputs.push_back(output.facts);
  return out;
}

// What a head finds in one frame.
struct HeadResult {
  std::string family, error;  // error: "" after success
  results::Features features;
  detection::Candidates found;
  results::FrameResults details;  // completed for all that was found
  std::string warning;            // "": none
};

inline HeadResult run_head(const std::vector<TestOutput>& outputs, const HeadSetup& setup = {}) {
  HeadResult out;
  try {
    const ModelSignature facts = facts_of(outputs, setup);
    const Family family =
        setup.head.empty() ? recognise(facts, setup.tasks) : family_named(setup.head, setup.tasks);
    out.family = family.name;
    const auto head = family.open(facts, {.threshold = setup.threshold, .custom = setup.custom});
    out.features = head->features();
    std::vector<weir_tensor> tensors;
    for (const auto& output : outputs) tensors.push_back(output.tensor());
    OutputValues values;
    values.begin(tensors);
    const auto input = setup.frame.width > 0 ? setup.frame : setup.input;
    out.found = head->find(values, input);
    head->complete(values, out.found, input, &out.details);
    if (const auto warning = head->next_warning()) out.warning = warning->message();
  } catch (const Failure& failure) {
    out.error = failure.error().message();
  }
  return out;
}

// The family that is recognised, or the error.
inline std::string recognised(const std::vector<TestOutput>& outputs, const HeadSetup& setup = {}) {
  const HeadResult result = run_head(outputs, setup);
  return result.error.empty() ? result.family : result.error;
}

// Rows and columns exchanged: from N rows of L numbers to L planes of N numbers.
inline Floats transposed(const Floats& rows, size_t length) {
  const size_t count = rows.size() / length;
  Floats out(rows.size());
  for (size_t i = 0; i < count; ++i)
    for (size_t k = 0; k < length; ++k) out[k * count + i] = rows[i * length + k];
  return out;
}

inline std::string shape_text(size_t inner, size_t outer) {
  return std::to_string(inner) + ":" + std::to_string(outer) + ":1";
}

// Both orders of dimensions of the same rows.
inline std::vector<TestOutput> both_orders(const Floats& rows, size_t length) {
  const size_t count = rows.size() / length;
  return {TestOutput(shape_text(length, count).c_str(), rows),
          TestOutput(shape_text(count, length).c_str(), transposed(rows, length))};
}

// An object, in pixels of the model's input.
struct TestObject {
  float x1, y1, x2, y2, score;
  int32_t class_index;
};

inline void expect_found(const detection::Candidates& found, const std::vector<TestObject>& objects,
                         float tolerance = 1e-3f) {
  ASSERT_EQ(found.size(), objects.size());
  for (size_t i = 0; i < objects.size(); ++i) {
    EXPECT_NEAR(found[i].x, objects[i].x1, tolerance) << i;
    EXPECT_NEAR(found[i].y, objects[i].y1, tolerance) << i;
    EXPECT_NEAR(found[i].x + found[i].width, objects[i].x2, tolerance) << i;
    EXPECT_NEAR(found[i].y + found[i].height, objects[i].y2, tolerance) << i;
    EXPECT_NEAR(found[i].score, objects[i].score, tolerance / 50 + 1e-5f) << i;
    EXPECT_EQ(found[i].class_index, objects[i].class_index) << i;
  }
}

}  // namespace weir::heads
