// Tests of the extensions weir.converter-stream/1 and weir.decoder-stream/1 through C tables: what
// converters and decoders get, and what a host does with inconsistent tables.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <cstring>
#include <span>

#include "core/infer/module/converter.hpp"
#include "core/infer/module/decoder.hpp"
#include "core/tensor/tensor_header.hpp"
#include "says.hpp"
#include "weir/abi.h"

namespace weir::infer {
namespace stream_extensions_test {

alignas(64) std::byte memory[kTensorHeaderBytes + 64];
uint64_t bytes_made = 0;
int flexible = 0;
const void* table = nullptr;  // the result of `extension`

const void* extension(const char* id) {
  return std::strcmp(id, WEIR_CONVERTER_STREAM) == 0 || std::strcmp(id, WEIR_DECODER_STREAM) == 0
             ? table
             : nullptr;
}

weir_converter_type converter_type() {
  weir_converter_type type{};
  type.struct_size = sizeof type;
  type.name = "flexible";
  type.open = [](const weir_option*, uint32_t, void*, weir_converter** out, weir_error*) {
    *out = reinterpret_cast<weir_converter*>(&memory);
    return 0;
  };
  type.close = [](weir_converter*) {};
  type.convert = [](weir_converter*, const weir_frame*, weir_frame* out, weir_error*) {
    out->n_tensors = 1;
    out->tensors[0] = weir_tensor{};
    out->tensors[0].data = memory;
    out->tensors[0].bytes = out->tensors[0].capacity = bytes_made;
    out->tensors[0].info.type = WEIR_UINT8;
    out->tensors[0].info.rank = 1;
    out->tensors[0].info.shape[0] = 8;
    return 0;
  };
  type.extension = extension;
  return type;
}

void write_header(uint32_t elements, Format format = Format::Static) {
  write_tensor_header({{ElementType::UInt8, Shape{elements}, ""}, format, MediaType::Video, 2},
                      std::span(memory).first<kTensorHeaderBytes>());
}

// "flexible", "static", or the error.
std::string converted() {
  static const weir_converter_type type = converter_type();
  auto converter = Converter::open(type, {});
  EXPECT_TRUE(converter);
  const auto made = (*converter)->convert({});
  if (!made) return made.error().message();
  return made->is_flexible ? "flexible" : "static";
}

const weir_converter_stream kFlexibleTable{sizeof(weir_converter_stream),
                                           [](weir_converter*) { return flexible; }};

TEST(ConverterStream, DistinguishesFlexibleFramesFromStaticOnes) {
  table = &kFlexibleTable;
  write_header(8);
  flexible = 1;
  bytes_made = kTensorHeaderBytes + 8;
  EXPECT_EQ(converted(), "flexible");
  EXPECT_SAYS((flexible = 0, converted()), "whose size differs from its description");
  bytes_made = 8;
  EXPECT_EQ(converted(), "static");
}

TEST(ConverterStream, ComparesTheHeaderWithTheTensor) {
  table = &kFlexibleTable;
  flexible = 1;
  bytes_made = kTensorHeaderBytes + 8;
  write_header(7);
  EXPECT_SAYS(converted(), "WEIR-2005: the header of a flexible tensor does not agree");
  write_header(8, Format::Sparse);
  EXPECT_SAYS(converted(), "WEIR-2");
  write_header(8);
  for (const uint64_t bytes : {uint64_t{1}, uint64_t{127}, kTensorHeaderBytes + 7}) {
    bytes_made = bytes;
    EXPECT_SAYS(converted(), "WEIR-2005");
  }
  bytes_made = kTensorHeaderBytes + 9;
  EXPECT_SAYS(converted(), "137 bytes with the header");
  std::memset(memory, 0, sizeof memory);
  bytes_made = kTensorHeaderBytes + 8;
  EXPECT_SAYS(converted(), "WEIR-2005");
}

TEST(ConverterStream, IsIgnoredWhenTheTableIsIncomplete) {
  flexible = 1;
  bytes_made = 8;
  const weir_converter_stream small{4, kFlexibleTable.is_flexible}, empty{sizeof empty, nullptr};
  for (const void* incomplete : {static_cast<const void*>(&small), static_cast<const void*>(&empty),
                                 static_cast<const void*>(nullptr)}) {
    table = incomplete;
    EXPECT_EQ(converted(), "static");
  }
}

struct Stream {
  int32_t n = 7, d = 7;
  int is_flexible = 7;
} received;

weir_decoder_type decoder_type() {
  weir_decoder_type type{};
  type.struct_size = sizeof type;
  type.name = "stream";
  type.open = [](const weir_option*, uint32_t, void*, weir_decoder** out, weir_error*) {
    *out = reinterpret_cast<weir_decoder*>(&memory);
    return 0;
  };
  type.close = [](weir_decoder*) {};
  type.extension = extension;
  return type;
}

void receive(weir_decoder*, int32_t n, int32_t d, int is_flexible) {
  received = {n, d, is_flexible};
}

TEST(DecoderStream, PassesTheFrameRateAndTheFormat) {
  static const weir_decoder_type type = decoder_type();
  const weir_decoder_stream stream{sizeof stream, WEIR_DECODER_WITH_HEADERS, receive};
  table = &stream;
  const auto decoder = Decoder::open(type, {});
  ASSERT_TRUE(decoder);
  EXPECT_TRUE((*decoder)->needs_headers());
  (*decoder)->set_stream({30, 1}, Format::Flexible);
  EXPECT_EQ(received.n, 30);
  EXPECT_EQ(received.d, 1);
  EXPECT_NE(received.is_flexible, 0);
  (*decoder)->set_stream({-1, -1}, Format::Static);
  EXPECT_EQ(received.n, 0) << "an invalid rate is unknown";
  EXPECT_EQ(received.d, 1);
  EXPECT_EQ(received.is_flexible, 0);
}

TEST(DecoderStream, IsIgnoredWhenTheTableIsIncomplete) {
  static const weir_decoder_type type = decoder_type();
  const weir_decoder_stream small{4, WEIR_DECODER_WITH_HEADERS, receive},
      empty{sizeof empty, WEIR_DECODER_WITH_HEADERS, nullptr};
  for (const void* incomplete : {static_cast<const void*>(&small), static_cast<const void*>(&empty),
                                 static_cast<const void*>(nullptr)}) {
    table = incomplete;
    received = {};
    const auto decoder = Decoder::open(type, {});
    ASSERT_TRUE(decoder);
    EXPECT_FALSE((*decoder)->needs_headers());
    (*decoder)->set_stream({30, 1}, Format::Flexible);
    EXPECT_EQ(received.n, 7) << "not called";
  }
}

}  // namespace stream_extensions_test
}  // namespace weir::infer
