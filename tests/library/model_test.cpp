// Tests of model.hpp with the shared library and engines from modules.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "weir/model.hpp"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>

#include "says.hpp"

namespace model_test {

using weir::Code;
using weir::Model;
using weir::ModelOptions;
using weir::TensorView;
using Values = std::vector<float>;

Model open(const ModelOptions& options) {
  auto model = Model::open(std::span<const std::string>(), options);
  if (!model) throw std::runtime_error(model.error().message());
  return *std::move(model);
}
ModelOptions engine(const char* name) {
  ModelOptions options;
  options.engine = name;
  return options;
}
Values values(const weir::Tensor& tensor) {
  const auto all = tensor.as<float>();
  return all ? Values(all->begin(), all->end()) : Values{};
}

TEST(ModelApi, DescribesWhatItOpened) {
  const Model model = open(engine("fake"));
  EXPECT_EQ(model.engine(), "fake");
  EXPECT_EQ(model.engine_version(), "1");
  EXPECT_EQ(model.metadata(), "");
  const auto inputs = model.inputs();
  ASSERT_EQ(inputs.size(), 1u);
  EXPECT_EQ(inputs[0].to_string(), "float32 (?, 4) x");
  EXPECT_EQ(inputs[0].shape, (weir::TensorShape{-1, 4}));
  EXPECT_EQ(inputs[0].elements(), -1);
  EXPECT_EQ(model.outputs()[0].name, "y");
}

TEST(ModelApi, ReportsQuantisationLayoutAndMetadata) {
  const std::string path = testing::TempDir() + "weir-quantised";
  std::ofstream(path) << "x";
  const auto model = Model::open(path, engine("fake-models"));
  ASSERT_TRUE(model) << model.error().message();
  const auto input = model->inputs()[0];
  EXPECT_EQ(input.to_string(), "uint8 (1, ?, ?, 3) picture");
  EXPECT_EQ(input.scale, 0.0078125f);
  EXPECT_EQ(input.zero_point, 128);
  EXPECT_EQ(input.layout, WEIR_LAYOUT_NHWC);
  EXPECT_EQ(model->metadata().substr(0, 16), "{\"description\": ");
  std::filesystem::remove(path);
}

TEST(ModelApi, InvokesVectorsArraysAndSpans) {
  Model model = open(engine("fake"));
  ASSERT_TRUE(model.reshape({{1, 4}}));
  EXPECT_EQ(model.outputs()[0].elements(), 4);
  const std::array<float, 4> array{1, 2, 3, 4};
  Values vector(array.begin(), array.end());
  for (const TensorView& view :
       {TensorView(array), TensorView(vector), TensorView(std::span(vector)),
        TensorView(std::span<const float>(vector), {1, 4})}) {
    const auto outputs = model.invoke({view});
    ASSERT_TRUE(outputs) << outputs.error().message();
    EXPECT_EQ(values((*outputs)[0]), (Values{2, 3, 4, 5}));
    ASSERT_TRUE(outputs->find("y"));
    EXPECT_EQ(values(*outputs->find("y")), (Values{2, 3, 4, 5}));
    EXPECT_FALSE(outputs->find("z"));
  }
}

TEST(ModelApi, InvokesIntoTheCallersMemory) {
  Model model = open(engine("scaling"));
  Values y(3);
  const auto filled = model.invoke_into({TensorView(Values{1, 2, 3}, {3})}, {y});
  ASSERT_TRUE(filled) << filled.error().message();
  EXPECT_TRUE(*filled);
  EXPECT_EQ(y, (Values{1, 2, 3}));
  std::vector<int32_t> wrong(3);
  EXPECT_REFUSED(model.invoke_into({TensorView(Values{1, 2, 3}, {3})}, {wrong}), SPEC_MISMATCH,
                 "output 0 (values) has a different type than the model's\n  offered: int32");
}

TEST(ModelApi, PassesOptionsToTheEngine) {
  auto options = engine("scaling");
  options.options = {{"factor", "2.5"}};
  options.timeout = std::chrono::hours(1);
  Model model = open(options);
  const auto outputs = model.invoke({TensorView(Values{2, 4}, {2})});
  ASSERT_TRUE(outputs) << outputs.error().message();
  EXPECT_EQ(values((*outputs)[0]), (Values{5, 10}));
  options.options = {{"factor", "much"}};
  EXPECT_REFUSED(Model::open(std::span<const std::string>(), options), OPTION_VALUE,
                 "factor is no number");
}

TEST(ModelApi, InvokesABatch) {
  Model model = open(engine("fake"));
  const Values a{1, 2, 3, 4}, b{5, 6, 7, 8};
  const std::vector<std::vector<TensorView>> frames{{TensorView(a)}, {TensorView(b)}};
  const auto outputs = model.invoke_batch(frames);
  ASSERT_TRUE(outputs) << outputs.error().message();
  EXPECT_EQ(outputs->frames(), 2u);
  EXPECT_EQ((*outputs)[0].info().shape, (weir::TensorShape{2, 4}));
  EXPECT_EQ(values(outputs->of_frame(1, 0)), (Values{6, 7, 8, 9}));
  const std::vector<std::vector<TensorView>> uneven{{TensorView(a)}, {}};
  EXPECT_REFUSED(model.invoke_batch(uneven), SPEC_MISMATCH, "1 tensors for 2 frames");
}

TEST(ModelApi, ReportsThatTheModelReturnedNothing) {
  auto options = engine("fake");
  options.options = {{"drop-at", "0"}};
  Model model = open(options);
  const auto outputs = model.invoke({TensorView(Values{1, 2, 3, 4}, {1, 4})});
  ASSERT_TRUE(outputs) << outputs.error().message();
  EXPECT_TRUE(outputs->dropped());
  EXPECT_EQ(outputs->size(), 0u);
  const auto next = model.invoke({TensorView(Values{1, 2, 3, 4}, {1, 4})});
  ASSERT_TRUE(next);
  EXPECT_FALSE(next->dropped());
}

TEST(ModelApi, PassesOnTheEnginesError) {
  auto options = engine("fake");
  options.options = {{"fail-at", "0"}};
  EXPECT_REFUSED(open(options).invoke({TensorView(Values{1, 2, 3, 4}, {1, 4})}), INVOKE_FAILED,
                 "WEIR-3006: ordered to fail\n  fix: drop the option");
}

TEST(ModelApi, RejectsMissingFilesAndEngines) {
  EXPECT_REFUSED(Model::open("/no/such/model.bin2"), MODEL_NOT_FOUND,
                 "the model file does not exist");
  EXPECT_REFUSED(Model::open("/no/such/model", engine("fake")), MODEL_NOT_FOUND,
                 "the model file does not exist\n  offered: /no/such/model");
  EXPECT_REFUSED(Model::open("x.tvn"), ENGINE_NOT_INSTALLED, "Weir has no engine trix-engine");
  EXPECT_REFUSED(Model::open(std::span<const std::string>()), ENGINE_UNKNOWN, "no model");
}

TEST(ModelApi, RejectsShapesBeyondTheLimits) {
  Model model = open(engine("fake"));
  const weir::TensorShape deep(17, 1);
  EXPECT_REFUSED(model.invoke({TensorView(Values{1}, deep)}), SPEC_MISMATCH,
                 "rank 16 instead of 2");
  EXPECT_REFUSED(model.reshape({deep}), SPEC_MISMATCH, "rank 16 instead of 2");
  EXPECT_REFUSED(model.reshape({{1, 5}}), SPEC_MISMATCH, "axis 1 is 5 instead of 4");
}

TEST(ModelApi, RejectsReadingATensorAsADifferentType) {
  Model model = open(engine("fake"));
  const auto outputs = model.invoke({TensorView(Values{1, 2, 3, 4}, {1, 4})});
  ASSERT_TRUE(outputs);
  EXPECT_REFUSED((*outputs)[0].as<int32_t>(), SPEC_MISMATCH,
                 "the tensor has a different type\n  offered: float32 (1, 4) y\n  needed: int32");
}

// The demo's network, if its engine is installed: a uniform picture gives the same result in each
// frame of a batch.
TEST(ModelApi, RunsANetwork) {
  const char* folder = std::getenv("WEIR_MODELS");
  auto model = Model::open(std::string(folder ? folder : "models") + "/clock_digits.onnx");
  if (!model && model.error().code == Code::ENGINE_NOT_INSTALLED)
    GTEST_SKIP() << model.error().message();
  ASSERT_TRUE(model) << model.error().message();
  const auto input = model->inputs()[0];
  auto shape = input.shape;
  for (auto& extent : shape) extent = extent < 0 ? 1 : extent;
  ASSERT_TRUE(model->reshape({shape}));
  const Values picture(static_cast<size_t>(model->inputs()[0].elements()), 0.5f);
  const auto outputs = model->invoke({TensorView(picture)});
  ASSERT_TRUE(outputs) << outputs.error().message();
  EXPECT_EQ((*outputs)[0].bytes().size(),
            static_cast<size_t>(model->outputs()[0].elements()) * sizeof(float));
  EXPECT_REFUSED(model->invoke({TensorView(Values{1}, shape)}), FRAME_SIZE, "4 bytes");
}

TEST(TensorInfoText, ShowOpenParts) {
  weir_tensor_info info{};
  info.type = WEIR_TYPE_END;
  info.rank = WEIR_RANK_UNKNOWN;
  EXPECT_EQ(weir::TensorInfo(info).to_string(), "any type any shape");
  EXPECT_EQ(weir::TensorInfo(info).elements(), -1);
  info.type = WEIR_FLOAT16;
  info.rank = 1;
  info.shape[0] = 3;
  info.name = "h";
  EXPECT_EQ(weir::TensorInfo(info).to_string(), "float16 (3,) h");
}

}  // namespace model_test
