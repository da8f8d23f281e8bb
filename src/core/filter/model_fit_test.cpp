// Whether streams fit models, and the error texts if they do not.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/filter/model_fit.hpp"

#include <gtest/gtest.h>

#include "says.hpp"

namespace weir {
namespace model_fit_test {

const ModelTensor kMobilenet{ElementType::UInt8, true, {1, 224, 224, 3}, "input"};
const ModelTensor kDynamic{ElementType::Float32, true, {-1, 3, -1, -1}, "images"};

TensorSpec spec(ElementType type, std::initializer_list<uint32_t> dims) {
  return {type, Shape(dims), ""};
}

TEST(Fit, AcceptsAMatchingStream) {
  const auto r = fit({kMobilenet}, {spec(ElementType::UInt8, {3, 224, 224})});
  ASSERT_TRUE(r);
  EXPECT_EQ((*r)[0].shape, (std::vector<int64_t>{1, 224, 224, 3}));
}

TEST(Fit, FillsOpenDimensionsAndKeepsTheRank) {
  const auto r = fit({kDynamic}, {spec(ElementType::Float32, {640, 480, 3})});
  ASSERT_TRUE(r);
  EXPECT_EQ((*r)[0].shape, (std::vector<int64_t>{1, 3, 480, 640}));
}

TEST(Fit, GivesAScalarItsRankZero) {
  const auto r =
      fit({ModelTensor{ElementType::Float32, true, {}, "t"}}, {spec(ElementType::Float32, {1})});
  ASSERT_TRUE(r);
  EXPECT_TRUE((*r)[0].shape.empty());
  EXPECT_EQ(to_spec((*r)[0]).shape.to_string(), "1");
}

TEST(Fit, ReportsTheFirstDifferenceOfAWrongSizeWithAFix) {
  const auto r = fit({kMobilenet}, {spec(ElementType::UInt8, {3, 100, 224, 1})});
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().code, Code::SPEC_MISMATCH);
  EXPECT_EQ(r.error().difference, "tensor 0 (input): dimension 1 is 100, needed is 224");
  EXPECT_EQ(r.error().fix,
            "videoconvert ! videoscale ! video/x-raw,format=RGB,width=224,height=224 ! "
            "tensor_converter ! tensor_filter");
}

TEST(Fit, SaysHowAModelOfOnePictureRunsOnSeveral) {
  const auto many = fit({kMobilenet}, {spec(ElementType::UInt8, {3, 224, 224, 5})});
  ASSERT_FALSE(many);
  EXPECT_EQ(many.error().fix, "tensor_filter invoke-rows=1");
  const auto other = fit({kMobilenet}, {spec(ElementType::UInt8, {3, 100, 224, 5})});
  ASSERT_FALSE(other);
  EXPECT_SAYS(other.error().fix, "videoscale");
}

TEST(Fit, ReportsAWrongType) {
  const auto r = fit({kMobilenet}, {spec(ElementType::Float32, {3, 224, 224, 1})});
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().difference, "tensor 0 (input): type is float32, needed is uint8");
  EXPECT_EQ(r.error().fix, "") << "as integers, values from -1 to 1 would be 0 or 1";
  ModelTensor real = kMobilenet;
  real.type = ElementType::Float32;
  EXPECT_EQ(fit({real}, {spec(ElementType::UInt8, {3, 224, 224, 1})}).error().fix,
            "tensor_transform mode=typecast option=float32 ! tensor_filter");
}

TEST(Fit, ConvertsVideoOfAnotherSizeToTheTypeOfTheModel) {
  const std::string video =
      "videoconvert ! videoscale ! video/x-raw,format=RGB,width=224,height=224 ! tensor_converter";
  EXPECT_EQ(fit({kMobilenet}, {spec(ElementType::Float32, {3, 100, 224, 1})}).error().fix,
            video + " ! tensor_filter");
  ModelTensor real = kMobilenet;
  real.type = ElementType::Float32;
  EXPECT_EQ(fit({real}, {spec(ElementType::Float32, {3, 100, 224, 1})}).error().fix,
            video + " ! tensor_transform mode=typecast option=float32 ! tensor_filter");
}

TEST(Fit, TurnsATensorWhoseDimensionsHaveAnotherOrder) {
  const auto fix_for = [](std::initializer_list<uint32_t> dims, std::vector<int64_t> shape) {
    return fit({{ElementType::Float32, true, std::move(shape), "x"}},
               {spec(ElementType::Float32, dims)})
        .error()
        .fix;
  };
  EXPECT_EQ(fix_for({3, 28, 28, 16}, {1, 3, 16, 28, 28}),
            "tensor_transform mode=transpose option=1:2:3:0:4 ! tensor_filter");
  EXPECT_EQ(fix_for({6, 128}, {1, 6, 128}),
            "tensor_transform mode=transpose option=1:0:2:3 ! tensor_filter");
  EXPECT_EQ(fix_for({5, 7, 6, 2}, {5, 2, 6, 7}),
            "tensor_transform mode=transpose option=1:2:3:0:4 ! tensor_filter");
  EXPECT_SAYS(fix_for({3, 640, 480, 1}, {1, 640, 480, 3}), "videoscale") << "not on its side";
}

TEST(Fit, CollectsFramesForAWindow) {
  const auto fix_for = [](std::initializer_list<uint32_t> dims, std::vector<int64_t> shape) {
    return fit({{ElementType::Float32, true, std::move(shape), "x"}},
               {spec(ElementType::Int16, dims)})
        .error()
        .fix;
  };
  const std::string cast = "tensor_transform mode=typecast option=float32 ! ";
  EXPECT_EQ(fix_for({6, 1}, {1, 128, 6}),
            cast + "tensor_aggregator frames-out=128 frames-dim=1 ! tensor_filter");
  EXPECT_EQ(fix_for({6, 32}, {1, 128, 6}),
            cast + "tensor_aggregator frames-out=4 frames-dim=1 ! tensor_filter");
  EXPECT_EQ(fix_for({3, 28, 28, 1}, {1, 3, 16, 28, 28}),
            cast +
                "tensor_aggregator frames-out=16 frames-dim=3 ! "
                "tensor_transform mode=transpose option=1:2:3:0:4 ! tensor_filter");
}

TEST(Fit, ReadsTheSameNumberOfValuesAsTheModelsDimensions) {
  const auto flat = fit({{ElementType::Float32, true, {-1, 784}, "x"}},
                        {spec(ElementType::Float32, {1, 28, 28, 1})});
  ASSERT_FALSE(flat);
  EXPECT_EQ(flat.error().fix,
            "tensor_decoder mode=octet_stream ! tensor_converter input-dim=784:1 "
            "input-type=float32 ! tensor_filter");
}

TEST(Fit, ProposesNoVideoForTensorsThatAreNone) {
  const ModelTensor gray{ElementType::Float32, true, {1, 1, 128, 6}, "x"};
  const auto sensor = fit({gray}, {spec(ElementType::Int16, {6, 100})});
  ASSERT_FALSE(sensor);
  EXPECT_EQ(sensor.error().fix, "");
  EXPECT_EQ(suggested_fix(spec(ElementType::UInt8, {3, 64, 64}), gray, false), "");
  EXPECT_SAYS(suggested_fix(spec(ElementType::UInt8, {3, 64, 64}), gray, true), "GRAY8");
}

TEST(Fit, MovesThePixelsOfAQuantisedModelOfSignedIntegers) {
  ModelTensor model = kMobilenet;
  model.type = ElementType::Int8;
  const std::string cast = "tensor_transform mode=typecast option=int8 ! tensor_filter";
  const auto fix_for = [&model] {
    return fit({model}, {spec(ElementType::UInt8, {3, 224, 224, 1})}).error().fix;
  };
  EXPECT_EQ(fix_for(), cast) << "not quantised";
  model.scale = 1.0F / 255;
  model.zero_point = -128;
  EXPECT_EQ(fix_for(), "tensor_transform mode=arithmetic option=typecast:int16,add:-128 ! " + cast);
}

// Nothing makes values of none.
TEST(Fit, ProposesNothingForATensorWithoutElements) {
  TensorSpec none = spec(ElementType::Float32, {5, 0});
  none.shape.set_rank(2);
  const auto fitted = fit({{ElementType::Float32, true, {128, 6}, ""}}, {none});
  ASSERT_FALSE(fitted);
  EXPECT_EQ(fitted.error().fix, "");
}

TEST(Fit, RejectsAWrongNumberOfTensors) {
  const ModelTensor gain{ElementType::Float32, true, {1}, "gain"};
  const auto few = fit({gain, kMobilenet, {ElementType::Float32, true, {}, "offset"}},
                       {spec(ElementType::UInt8, {3, 224, 224})});
  ASSERT_FALSE(few);
  EXPECT_EQ(few.error().difference, "no tensor for gain, offset");
  EXPECT_SAYS(few.error().needed, "joined by tensor_mux");
  const auto one = spec(ElementType::UInt8, {3, 224, 224});
  const auto many = fit({kMobilenet}, {one, one});
  ASSERT_FALSE(many);
  EXPECT_EQ(many.error().fix, "tensor_filter input-combination=0");
  const auto other =
      fit({gain, kMobilenet}, {spec(ElementType::Int8, {3}), one, spec(ElementType::Float32, {1})});
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().fix, "tensor_filter input-combination=2,1");
}

TEST(Fit, AcceptsAnyTensorsIfTheModelDeclaresNone) {
  const auto r = fit({}, {spec(ElementType::UInt8, {3, 2}), spec(ElementType::Int16, {5})});
  ASSERT_TRUE(r);
  ASSERT_EQ(r->size(), 2u);
  EXPECT_EQ((*r)[0].to_string(), "uint8 3:2");
  EXPECT_EQ((*r)[1].to_string(), "int16 5");
}

TEST(Fit, RejectsAdditionalDimensionsOtherThanOne) {
  EXPECT_TRUE(fit({kMobilenet}, {spec(ElementType::UInt8, {3, 224, 224, 1, 1})}));
  EXPECT_FALSE(fit({kMobilenet}, {spec(ElementType::UInt8, {3, 224, 224, 1, 2})}));
}

TEST(UserSettings, FillWhatTheModelLeavesOpen) {
  const auto r = with_user_settings({kDynamic}, "64:48:3:1", "", "input");
  ASSERT_TRUE(r);
  EXPECT_EQ((*r)[0].shape, (std::vector<int64_t>{1, 3, 48, 64}));
}

TEST(UserSettings, DefineTheTensorsOfAModelThatDeclaresNone) {
  const auto r = with_user_settings({}, "10:1,4", "float32,int8", "input");
  ASSERT_TRUE(r);
  ASSERT_EQ(r->size(), 2u);
  EXPECT_EQ((*r)[1].to_string(), "int8 4");
}

TEST(UserSettings, MustNotContradictTheModel) {
  const auto r = with_user_settings({kMobilenet}, "3:192:192:1", "", "input");
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().what, "input contradicts the model");
  EXPECT_FALSE(with_user_settings({kMobilenet}, "", "float32", "input"));
  EXPECT_FALSE(with_user_settings({kMobilenet}, "3:224:224:1,4", "", "input"));
}

}  // namespace model_fit_test
}  // namespace weir
