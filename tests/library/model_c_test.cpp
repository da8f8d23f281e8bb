// Tests of invalid arguments to the C API of models: an error, never a crash.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <array>
#include <memory>

#include "weir/model.h"

namespace model_c_test {

struct Freed {
  ~Freed() { weir_error_free(error); }
  weir_error* error = nullptr;
};

class ModelC : public testing::Test {
 protected:
  void SetUp() override {
    weir_model_options options = WEIR_MODEL_OPTIONS_INIT;
    options.engine = "fake";
    ASSERT_EQ(weir_model_open(&options, &model_, nullptr), WEIR_OK);
  }
  void TearDown() override { weir_model_close(model_); }
  weir_loaded_model* model_ = nullptr;
  const std::array<float, 4> x_{1, 2, 3, 4};
};

TEST_F(ModelC, NullPointersAreErrors) {
  Freed kept;
  EXPECT_EQ(weir_model_open(nullptr, &model_, &kept.error), -WEIR_OPTION_VALUE);
  EXPECT_STREQ(weir_error_what(kept.error), "options or model is a null pointer");
  EXPECT_EQ(weir_model_invoke(model_, nullptr, 0, nullptr, nullptr), -WEIR_OPTION_VALUE);
  weir_results* results = nullptr;
  EXPECT_EQ(weir_model_invoke(model_, nullptr, 1, &results, nullptr), -WEIR_SPEC_MISMATCH);
  EXPECT_EQ(weir_model_invoke_batch(model_, nullptr, 1, 1, nullptr, nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(weir_model_invoke_into(model_, nullptr, 0, nullptr, 1, nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(weir_model_reshape(model_, nullptr, 1, nullptr), -WEIR_SPEC_MISMATCH);
  const char* path = nullptr;
  weir_model_options options = WEIR_MODEL_OPTIONS_INIT;
  options.paths = &path;
  options.n_paths = 1;
  weir_loaded_model* other = nullptr;
  EXPECT_EQ(weir_model_open(&options, &other, nullptr), -WEIR_OPTION_VALUE);
  const weir_option no_key{nullptr, "x"};
  options = WEIR_MODEL_OPTIONS_INIT;
  options.engine = "fake";
  options.options = &no_key;
  options.n_options = 1;
  EXPECT_EQ(weir_model_open(&options, &other, nullptr), -WEIR_OPTION_VALUE);
  weir_model_close(nullptr);
  weir_results_free(nullptr);
  weir_error_free(nullptr);
}

TEST_F(ModelC, AMissingErrorIsEmpty) {
  EXPECT_EQ(weir_error_code(nullptr), 0);
  EXPECT_STREQ(weir_error_message(nullptr), "");
  EXPECT_STREQ(weir_error_needed(nullptr), "");
  EXPECT_STREQ(weir_error_difference(nullptr), "");
}

TEST_F(ModelC, OptionsOfAnOlderProgramAreReadAsFarAsTheyGo) {
  weir_model_options options = WEIR_MODEL_OPTIONS_INIT;
  options.engine = "fake";
  options.accelerator = reinterpret_cast<const char*>(1);  // past the end, must not be read
  options.options = reinterpret_cast<const weir_option*>(1);
  options.n_options = 1;
  options.struct_size = offsetof(weir_model_options, accelerator);
  weir_loaded_model* other = nullptr;
  ASSERT_EQ(weir_model_open(&options, &other, nullptr), WEIR_OK);
  weir_model_close(other);
  options.struct_size = 8;
  Freed kept;
  EXPECT_EQ(weir_model_open(&options, &other, &kept.error), -WEIR_OPTION_VALUE);
  EXPECT_STREQ(weir_error_needed(kept.error), "at least 16 bytes");
  EXPECT_STREQ(weir_error_fix(kept.error), "weir_model_options options = WEIR_MODEL_OPTIONS_INIT;");
}

TEST_F(ModelC, AnOptionBeyondStructSizeIsNotRead) {
  weir_model_options options = WEIR_MODEL_OPTIONS_INIT;
  options.engine = "fake";
  options.accelerator = reinterpret_cast<const char*>(1);
  weir_loaded_model* other = nullptr;
  for (uint32_t cut = 1; cut < sizeof options.accelerator; ++cut) {
    options.struct_size = offsetof(weir_model_options, accelerator) + cut;
    ASSERT_EQ(weir_model_open(&options, &other, nullptr), WEIR_OK) << cut;
    weir_model_close(other);
  }
  options.struct_size = offsetof(weir_model_options, engine) - 1;
  EXPECT_EQ(weir_model_open(&options, &other, nullptr), -WEIR_OPTION_VALUE);
}

TEST_F(ModelC, OptionsOfANewerProgramAreReadAsFarAsTheyAreKnown) {
  struct Newer {
    weir_model_options known;
    uint64_t unknown;
  } options{WEIR_MODEL_OPTIONS_INIT, 7};
  options.known.struct_size = sizeof options;
  options.known.engine = "fake";
  weir_loaded_model* other = nullptr;
  ASSERT_EQ(weir_model_open(&options.known, &other, nullptr), WEIR_OK);
  weir_model_close(other);
}

TEST_F(ModelC, WritesIntoTheCallersMemory) {
  std::array<float, 4> y{};
  weir_tensor in = weir_tensor_of(x_.data(), sizeof x_, WEIR_FLOAT32);
  in.info.rank = 2;
  in.info.shape[0] = 1;
  in.info.shape[1] = 4;
  weir_tensor out = weir_tensor_of(y.data(), sizeof y, WEIR_FLOAT32);
  ASSERT_EQ(weir_model_invoke_into(model_, &in, 1, &out, 1, nullptr), WEIR_OK);
  EXPECT_EQ(y, (std::array<float, 4>{2, 3, 4, 5}));
  EXPECT_EQ(out.info.shape[0], 1);
}

TEST_F(ModelC, ReportsWhereASizeIsWrong) {
  weir_tensor in = weir_tensor_of(x_.data(), 12, WEIR_FLOAT32);
  in.info.rank = 2;
  in.info.shape[0] = 1;
  in.info.shape[1] = 4;
  weir_results* results = nullptr;
  Freed kept;
  EXPECT_EQ(weir_model_invoke(model_, &in, 1, &results, &kept.error), -WEIR_FRAME_SIZE);
  EXPECT_STREQ(weir_error_message(kept.error),
               "WEIR-2004: input 0 (x) has a size that does not match its shape\n"
               "  offered: 12 bytes\n  needed: 16 bytes: float32 (1, 4) x");
}

}  // namespace model_c_test
