// Tests external converters through their C table: their results are validated.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/converter.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <functional>

#include "core/infer/module/module_library.hpp"
#include "says.hpp"

namespace weir::infer {
namespace converter_test {

int released = 0;
alignas(64) std::byte memory[64];

// A converter in C whose results the test defines.
struct Script {
  std::function<int(weir_tensor_info*, uint32_t*)> configure = [](auto*, auto*) { return 0; };
  std::function<int(const weir_frame*, weir_frame*, weir_error*)> convert = [](auto*, auto*,
                                                                               auto*) { return 0; };
  int opened = 0, resets = 0;
} script;

weir_converter* handle() {
  return reinterpret_cast<weir_converter*>(&script);
}
int open_script(const weir_option* options, uint32_t n, void*, weir_converter** out,
                weir_error* error) {
  if (n == 1 && std::strcmp(options[0].value, "refused") == 0)
    return host().fail(error, WEIR_FILE_NOT_FOUND, "no such script", options[0].value, nullptr,
                       nullptr, nullptr);
  if (n == 1 && std::strcmp(options[0].value, "null") == 0) return WEIR_OK;
  ++script.opened;
  *out = handle();
  return WEIR_OK;
}
void close_script(weir_converter*) {
  --script.opened;
}
int configure(weir_converter*, const char*, weir_tensor_info* out, uint32_t* n, weir_error*) {
  return script.configure(out, n);
}
int convert(weir_converter*, const weir_frame* in, weir_frame* out, weir_error* error) {
  return script.convert(in, out, error);
}
void reset(weir_converter*) {
  ++script.resets;
}
const weir_converter_type kType{sizeof(weir_converter_type),
                                WEIR_ABI_MAJOR,
                                WEIR_ABI_MINOR,
                                "script",
                                "other/script, written",
                                "application/x-script",
                                "[]",
                                open_script,
                                close_script,
                                configure,
                                convert,
                                reset,
                                nullptr};
const weir_converter_type* const kTypes[] = {&kType, nullptr};
const weir_module kModule{sizeof(weir_module),
                          WEIR_ABI_MAJOR,
                          WEIR_ABI_MINOR,
                          nullptr,
                          nullptr,
                          kTypes,
                          nullptr,
                          nullptr};

// A tensor of `count` uint8 that counts its release.
weir_tensor good(int64_t count) {
  weir_tensor tensor{};
  tensor.data = memory;
  tensor.bytes = static_cast<uint64_t>(count);
  tensor.capacity = sizeof memory;
  tensor.release = [](void*) { ++released; };
  tensor.info.type = WEIR_UINT8;
  tensor.info.rank = 2;
  tensor.info.shape[0] = 1;
  tensor.info.shape[1] = count;
  return tensor;
}

class ConverterTest : public testing::Test {
 protected:
  void SetUp() override {
    script = {};
    released = 0;
    auto opened = Converter::open(kType, {});
    ASSERT_TRUE(opened);
    converter_ = *std::move(opened);
  }
  void TearDown() override {
    converter_.reset();
    EXPECT_EQ(script.opened, 0);
  }
  // The error text for a frame of one tensor modified by `f`.
  std::string refusal(const std::function<void(weir_frame*)>& f) {
    released = 0;
    script.convert = [&f](auto*, weir_frame* out, auto*) {
      out->tensors[0] = good(8);
      out->n_tensors = 1;
      f(out);
      return 0;
    };
    const auto frame = converter_->convert({});
    if (frame) return "";
    EXPECT_EQ(frame.error().code, Code::CALLBACK_FAILED);
    EXPECT_EQ(frame.error().fix, "correct the converter script");
    return frame.error().message();
  }

  std::unique_ptr<Converter> converter_;
};

TEST_F(ConverterTest, ReturnsTensorsThatAreReleasedOnce) {
  script.convert = [](const weir_frame* in, weir_frame* out, auto*) {
    EXPECT_EQ(out->n_tensors, uint32_t{WEIR_TENSOR_LIMIT});
    EXPECT_EQ(out->pts, in->pts);
    out->tensors[0] = good(8);
    out->tensors[1] = good(9);
    out->n_tensors = 2;
    out->duration = 3;
    return 0;
  };
  weir_frame in{};
  in.pts = 7;
  for (int i = 1; i <= 2; ++i) {
    {
      auto frame = converter_->convert(in);
      ASSERT_TRUE(frame);
      ASSERT_EQ(frame->tensors.size(), 2u);
      EXPECT_EQ(frame->tensors[0].spec().to_string(), "uint8 8:1") << "innermost first";
      EXPECT_EQ(frame->tensors[1].memory().bytes, 9u);
      EXPECT_EQ(frame->pts, 7);
      EXPECT_EQ(frame->duration, 3);
      const weir_tensor taken = frame->tensors[1].take();
      EXPECT_EQ(taken.data, memory);
    }
    EXPECT_EQ(released, i) << "the one that was not taken";
  }
}

TEST_F(ConverterTest, MayDropAFrame) {
  script.convert = [](auto*, auto*, auto*) { return 1; };
  const auto frame = converter_->convert({});
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->tensors.empty());
}

TEST_F(ConverterTest, FreesTheMemoryOfAFailedCall) {
  script.convert = [](auto*, weir_frame* out, weir_error* error) {
    out->tensors[0] = good(8);
    out->tensors[5] = good(8);
    return host().fail(error, WEIR_INVOKE_FAILED, "broken", "this", "that", "here", "correct");
  };
  const auto frame = converter_->convert({});
  ASSERT_FALSE(frame);
  EXPECT_EQ(frame.error().code, Code::INVOKE_FAILED);
  EXPECT_EQ(frame.error().needed, "that");
  EXPECT_EQ(released, 2);
}

TEST_F(ConverterTest, ReportsAFailureWithoutAMessage) {
  script.convert = [](auto*, auto*, auto*) { return -WEIR_FRAME_SIZE; };
  EXPECT_SAYS(converter_->convert({}).error().message(),
              "WEIR-2004: the converter script failed on a frame");
  for (const int number : {-5, -123456}) {
    script.convert = [number](auto*, auto*, auto*) { return number; };
    const auto text = converter_->convert({}).error().message();
    EXPECT_SAYS(text, "WEIR-5003: the converter script failed on a frame");
    EXPECT_SAYS(text, "offered: it returned " + std::to_string(number));
  }
}

TEST_F(ConverterTest, ValidatesTheCount) {
  for (const uint32_t count : {0u, WEIR_TENSOR_LIMIT + 1u, UINT32_MAX})
    EXPECT_SAYS(refusal([count](weir_frame* out) { out->n_tensors = count; }),
                "the converter script produced no tensors, or more than there is room for");
  weir_tensor own = good(8);
  own.release = nullptr;
  EXPECT_SAYS(refusal([&own](weir_frame* out) { out->tensors = &own; }),
              "within the given capacity");
}

TEST_F(ConverterTest, ValidatesDescriptions) {
  const std::function<void(weir_tensor_info&)> faults[] = {
      [](auto& info) { info.type = WEIR_TYPE_END; },
      [](auto& info) { info.type = UINT32_MAX; },
      [](auto& info) { info.rank = WEIR_RANK_LIMIT + 1; },
      [](auto& info) { info.rank = WEIR_RANK_UNKNOWN; },
      [](auto& info) { info.shape[1] = -1; },
      [](auto& info) { info.shape[1] = int64_t{1} << 32; },
      [](auto& info) { info.rank = 3, info.shape[0] = info.shape[1] = info.shape[2] = UINT32_MAX; },
  };
  for (const auto& fault : faults) {
    EXPECT_SAYS(refusal([&](weir_frame* out) { fault(out->tensors[0].info); }),
                "the converter script describes an invalid tensor");
    EXPECT_EQ(released, 1);
  }
}

TEST_F(ConverterTest, ValidatesMemory) {
  const std::function<void(weir_tensor&)> faults[] = {
      [](auto& tensor) { tensor.data = nullptr; },
      [](auto& tensor) { tensor.memory_kind = WEIR_MEMORY_CUDA; },
      [](auto& tensor) { tensor.offset = 1; },
      [](auto& tensor) { tensor.stride[0] = 1; },
  };
  for (const auto& fault : faults)
    EXPECT_SAYS(refusal([&](weir_frame* out) { fault(out->tensors[0]); }),
                "the converter script produced a tensor that is not dense in host memory");
  for (const uint64_t bytes : {uint64_t{0}, uint64_t{7}, uint64_t{9}, UINT64_MAX})
    EXPECT_SAYS(refusal([bytes](weir_frame* out) { out->tensors[0].bytes = bytes; }),
                "the converter script produced a tensor whose size differs from its description");
}

TEST_F(ConverterTest, ReportsItsTensorsOrThatTheyAreUnknown) {
  const auto configured = [&](std::function<int(weir_tensor_info*, uint32_t*)> f) {
    script.configure = std::move(f);
    return converter_->configure("caps");
  };
  const auto known = configured([](auto* out, auto* n) {
    EXPECT_EQ(*n, uint32_t{WEIR_TENSOR_LIMIT});
    out[0] = good(8).info;
    *n = 1;
    return 0;
  });
  ASSERT_TRUE(known);
  ASSERT_EQ(known->size(), 1u);
  EXPECT_EQ((*known)[0].to_string(), "uint8 8:1");
  EXPECT_TRUE(configured([](auto*, auto* n) { return *n = 0, 0; })->empty());
  EXPECT_TRUE(configured([](auto* out, auto* n) {
                out[0] = good(-1).info;
                *n = 1;
                return 0;
              })->empty());
  EXPECT_EQ(configured([](auto*, auto* n) { return *n = 257, 0; }).error().code,
            Code::CALLBACK_FAILED);
  EXPECT_EQ(configured([](auto* out, auto* n) {
              out[0] = good(-2).info;
              *n = 1;
              return 0;
            })
                .error()
                .code,
            Code::CALLBACK_FAILED);
  EXPECT_SAYS(configured([](auto*, auto*) { return -WEIR_FORMAT_UNSUPPORTED; }).error().message(),
              "WEIR-2002: the converter script rejects these caps");
}

TEST_F(ConverterTest, ReportsWhyItCannotBeOpened) {
  EXPECT_SAYS(Converter::open(kType, {{"script", "refused"}}).error().message(),
              "WEIR-4001: no such script");
  EXPECT_SAYS(Converter::open(kType, {{"script", "null"}}).error().message(),
              "WEIR-5003: the converter script cannot be opened\n  offered: 0 and no handle");
}

TEST_F(ConverterTest, ForgetsItsStateAtAReset) {
  converter_->reset();
  EXPECT_EQ(script.resets, 1);
}

TEST(ConverterLibrary, FindsConvertersByNameAndAlias) {
  ModuleLibrary library;
  library.add_builtin(&kModule);
  for (const char* name : {"script", "other/script", "written"}) {
    const auto found = library.converter(name);
    ASSERT_TRUE(found) << name;
    EXPECT_EQ(*found, &kType);
  }
  const auto all = library.converters();
  EXPECT_EQ(std::count(all.begin(), all.end(), &kType), 1);
  for (const char* name : {"scrip", "", "../script", "a/b"}) {
    const auto missing = library.converter(name);
    ASSERT_FALSE(missing) << name;
    EXPECT_EQ(missing.error().code, Code::CONVERTER_UNKNOWN);
    EXPECT_SAYS(missing.error().message(), "script");
  }
}

}  // namespace converter_test
}  // namespace weir::infer
