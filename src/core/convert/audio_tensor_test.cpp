// Audio formats as tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/convert/audio_tensor.hpp"

#include <gtest/gtest.h>

#include <bit>

namespace weir {
namespace audio_tensor_test {

static_assert(std::endian::native == std::endian::little, "the names below are of such a machine");

TEST(AudioTensor, HasChannelsInnermost) {
  const std::pair<const char*, const char*> formats[] = {
      {"S8", "int8"},     {"U8", "uint8"},     {"S16LE", "int16"},   {"U16LE", "uint16"},
      {"S32LE", "int32"}, {"U32LE", "uint32"}, {"F32LE", "float32"}, {"F64LE", "float64"}};
  for (const auto& [format, type] : formats) {
    const auto tensor = audio_tensor(format, 2, 480);
    ASSERT_TRUE(tensor) << format;
    EXPECT_EQ(tensor->spec.to_string(), std::string(type) + " 2:480");
    EXPECT_EQ(tensor->frame_bytes * 480, tensor->spec.bytes());
    EXPECT_EQ(to_audio_format(tensor->spec.type), format);
  }
}

TEST(AudioTensor, RejectsOtherFormatsWithAFix) {
  for (const char* format :
       {"S16BE", "F32BE", "S24LE", "S24_32LE", "U18LE", "S8LE", "s16le", "S16", ""}) {
    const auto tensor = audio_tensor(format, 2, 1);
    ASSERT_FALSE(tensor) << format;
    EXPECT_EQ(tensor.error().code, Code::FORMAT_UNSUPPORTED);
    EXPECT_EQ(tensor.error().offered, format);
    EXPECT_EQ(tensor.error().needed, "S8, U8, S16LE, U16LE, S32LE, U32LE, F32LE, F64LE");
    EXPECT_EQ(tensor.error().fix,
              "audioconvert ! audio/x-raw,format=S16LE,layout=interleaved ! tensor_converter");
  }
}

TEST(AudioTensor, RejectsEmptyAndOversizedFrames) {
  EXPECT_EQ(audio_tensor("S16LE", 0, 1).error().code, Code::LIMIT_EXCEEDED);
  EXPECT_EQ(audio_tensor("S16LE", 1, 0).error().code, Code::LIMIT_EXCEEDED);
  EXPECT_EQ(audio_tensor("F64LE", UINT32_MAX, UINT32_MAX).error().code, Code::LIMIT_EXCEEDED);
}

TEST(AudioTensor, KnowsNoFormatForOtherTypes) {
  for (const auto type :
       {ElementType::Float16, ElementType::Int64, ElementType::UInt64, ElementType::End})
    EXPECT_EQ(to_audio_format(type), "");
}

}  // namespace audio_tensor_test
}  // namespace weir
