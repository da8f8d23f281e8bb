// Helpers of the tensor_crop tests: a small picture, regions, and the element between bare pads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/tensor/tensor_header.hpp"
#include "elements/tensor_mux/many_inputs_test_support.hpp"

namespace weir::test {

inline constexpr char kRaw[] =
    "other/tensor,dimension=(string)2:5:4,type=(string)uint8,framerate=30/1";
inline constexpr char kInfo[] = "other/tensors,format=flexible,framerate=15/2";

inline Bytes make_header(ElementType type, const Shape& shape, Format format) {
  TensorHeader header;
  header.spec = {type, shape, ""};
  header.format = format;
  Bytes out(kTensorHeaderBytes);
  write_tensor_header(header, std::span<std::byte, kTensorHeaderBytes>(
                                  reinterpret_cast<std::byte*>(out.data()), kTensorHeaderBytes));
  return out;
}
inline Bytes make_info(const std::vector<uint32_t>& numbers) {
  Bytes out = make_header(ElementType::UInt32, Shape{4, static_cast<uint32_t>(numbers.size() / 4)},
                          Format::Flexible);
  const auto* bytes = reinterpret_cast<const uint8_t*>(numbers.data());
  out.insert(out.end(), bytes, bytes + numbers.size() * 4);
  return out;
}
// 2:5:4: the two channels of column x, row y are 10y + 2x and 10y + 2x + 1.
inline Bytes picture() {
  Bytes out;
  for (uint8_t i = 0; i < 40; ++i) out.push_back(i);
  return out;
}
// docs/compatibility/routing.md 6.9: the header has four dimensions.
inline Bytes region(const Shape& shape, const Bytes& payload) {
  Bytes out =
      make_header(ElementType::UInt8, Shape{shape[0], shape[1], shape[2], 1}, Format::Flexible);
  out.insert(out.end(), payload.begin(), payload.end());
  return out;
}

struct Crop : ManyInputs {
  explicit Crop(const std::string& properties = "", const char* raw = kRaw)
      : ManyInputs("tensor_crop " + properties) {
    add(raw, "raw");
    add(kInfo, "info");
    play();
  }
  void push_both(Ref<GstBuffer> raw, const Bytes& info, GstClockTime info_pts) {
    auto first = push_later(0, raw);
    EXPECT_EQ(push(1, info, info_pts), GST_FLOW_OK);
    EXPECT_EQ(first.get(), GST_FLOW_OK);
  }
  void push_both(const Bytes& info) { push_both(make_buffer({picture()}, 100), info, 100); }
};

}  // namespace weir::test
