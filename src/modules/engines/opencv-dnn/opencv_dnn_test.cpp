// Tests Caffe, TensorFlow and Darknet networks in OpenCV against closed forms and plain loops.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <barrier>
#include <cmath>
#include <regex>
#include <thread>

#include "opencv-dnn/dnn_test_support.hpp"
#include "says.hpp"
#include "usable_cores.hpp"

namespace weir::engine_test {
namespace opencv_dnn_test {

class OpencvDnn : public DnnTest {};

TEST_F(OpencvDnn, CaffeComputesAProduct) {
  const auto model = open_caffe(kProduct, product_weights());
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ(to_string((*model)->inputs()[0]), "float32[1, 3]");
  EXPECT_STREQ((*model)->inputs()[0].name, "data");
  EXPECT_STREQ((*model)->outputs()[0].name, "fc");
  EXPECT_EQ(to_string((*model)->outputs()[0]), "float32[1, 2]");
  const auto out = invoke(model, {floats({1, 3}, {1, 0, -1})});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].values<float>(), (std::vector<float>{8, 18}));
}

TEST_F(OpencvDnn, EitherCaffeFileLocatesTheOther) {
  ASSERT_TRUE(open_caffe(kProduct, product_weights()));
  for (const char* name : {"net.prototxt", "net.caffemodel"}) {
    const auto model = OpenEngine::open(engine("caffe"), folder_.path(name));
    EXPECT_TRUE(model) << model.error().message();
  }
}

TEST_F(OpencvDnn, TheUserChangesTheInputsSizeAndType) {
  const auto model =
      open_caffe(kProduct, product_weights(), {{"input", "3:2"}, {"inputtype", "uint8"}});
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ(to_string((*model)->inputs()[0]), "uint8[2, 3]");
  const std::vector<uint8_t> bytes{1, 1, 1, 200, 0, 0};
  const auto out = invoke(model, {make_tensor<uint8_t>(WEIR_UINT8, {2, 3}, bytes)});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].values<float>(), (std::vector<float>{16, 35, 210, 820}));
}

const char* const kTwoInputs =
    "layer { name: \"a\" type: \"Input\" top: \"a\" input_param { shape { dim: [1, 2] } } }\n"
    "layer { name: \"b\" type: \"Input\" top: \"b\" input_param { shape: { dim: 1 dim: 2 } } }\n"
    "layer { name: \"less\" type: \"Eltwise\" bottom: \"a\" bottom: \"b\" top: \"less\"\n"
    "  eltwise_param { operation: SUM coeff: 1 coeff: -1 } }\n"
    "layer { name: \"twice\" type: 'Power' bottom: \"less\" top: \"twice\" power_param { scale: 2 "
    "} }\n";
std::string no_weights() {
  return caffemodel({caffe_layer("none", "Power", {})});
}

TEST_F(OpencvDnn, NamesChooseInputsAndOutputs) {
  const auto a = floats({1, 2}, {10, 20}), b = floats({1, 2}, {1, 2});
  auto model = open_caffe(kTwoInputs, no_weights());
  ASSERT_TRUE(model) << model.error().message();
  ASSERT_EQ((*model)->outputs().size(), 1u);
  EXPECT_EQ(invoke(model, {a, b})[0].values<float>(), (std::vector<float>{18, 36}));
  model =
      open_caffe(kTwoInputs, no_weights(), {{"inputname", "b,a"}, {"outputname", "twice,less"}});
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_STREQ((*model)->inputs()[0].name, "b");
  const auto out = invoke(model, {b, a});
  ASSERT_EQ(out.size(), 2u);
  EXPECT_EQ(out[0].values<float>(), (std::vector<float>{18, 36}));
  EXPECT_EQ(out[1].values<float>(), (std::vector<float>{9, 18}));
}

TEST_F(OpencvDnn, TensorflowComputesAProductOfAnyBatch) {
  const auto net =
      graph({placeholder("x", {-1, 3}), constant("w", {3, 2}, {1, 4, 2, 5, 3, 6}),
             TensorflowNode("xw", "MatMul", {"x", "w"}).type("T"), constant("c", {2}, {10, 20}),
             TensorflowNode("y", "BiasAdd", {"xw", "c"}).type("T")});
  const auto model = open_tensorflow(net, {{"inputname", "x:0"}, {"outputname", "y:0"}});
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ(to_string((*model)->inputs()[0]), "float32[-1, 3]");
  EXPECT_STREQ((*model)->outputs()[0].name, "xw") << "OpenCV adds the bias in the product";
  const auto shapes = (*model)->resolve({make_tensor(WEIR_FLOAT32, {2, 3}).info});
  ASSERT_TRUE(shapes) << shapes.error().message();
  EXPECT_EQ(to_string((*shapes)[0]), "float32[2, 2]");
  const auto out = invoke(model, {floats({2, 3}, {1, 0, -1, 1, 1, 1})});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].values<float>(), (std::vector<float>{8, 18, 16, 35}));
}

// TensorFlow pictures keep their order: rows, columns, channels.
TEST_F(OpencvDnn, TensorflowsPicturesStayInItsOrder) {
  constexpr int64_t kRows = 4, kColumns = 5, kIn = 2, kOut = 3;
  std::vector<float> weights, pixels;  // of [2, 2, kIn, kOut], of [1, kRows, kColumns, kIn]
  for (int i = 0; i < 2 * 2 * kIn * kOut; ++i) weights.push_back(std::sin(static_cast<float>(i)));
  for (int i = 0; i < kRows * kColumns * kIn; ++i)
    pixels.push_back(std::cos(static_cast<float>(i)));
  const auto net = graph({placeholder("picture", {1, kRows, kColumns, kIn}),
                          constant("w", {2, 2, kIn, kOut}, weights),
                          TensorflowNode("conv", "Conv2D", {"picture", "w"})
                              .type("T")
                              .numbers("strides", {1, 1, 1, 1})
                              .text("padding", "VALID")
                              .text("data_format", "NHWC"),
                          TensorflowNode("out", "Relu", {"conv"}).type("T")});
  const auto model = open_tensorflow(net);
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ((*model)->inputs()[0].layout, uint32_t{WEIR_LAYOUT_NHWC});
  EXPECT_EQ(to_string((*model)->outputs()[0]), "float32[1, 3, 4, 3]");
  const auto out = invoke(model, {floats({1, kRows, kColumns, kIn}, pixels)});
  ASSERT_EQ(out.size(), 1u);
  const auto got = out[0].values<float>();
  for (int64_t y = 0; y < kRows - 1; ++y)
    for (int64_t x = 0; x < kColumns - 1; ++x)
      for (int64_t o = 0; o < kOut; ++o) {
        float sum = 0;
        for (int64_t ky = 0; ky < 2; ++ky)
          for (int64_t kx = 0; kx < 2; ++kx)
            for (int64_t i = 0; i < kIn; ++i)
              sum += pixels[static_cast<size_t>(((y + ky) * kColumns + x + kx) * kIn + i)] *
                     weights[static_cast<size_t>(((ky * 2 + kx) * kIn + i) * kOut + o)];
        EXPECT_NEAR(got[static_cast<size_t>((y * (kColumns - 1) + x) * kOut + o)],
                    std::max(sum, 0.0f), 1e-5);
      }
}

// A 1x1 convolution of two planes to one, with a bias.
TEST_F(OpencvDnn, DarknetComputesAConvolution) {
  const char* const cfg =
      "# two channels\n[net]\nbatch=1\nwidth=3\nheight=2\nchannels=2\n\n"
      "[convolutional]\nfilters=1\nsize=1\nstride=1\npad=0\nactivation=linear\n";
  const auto model = open_darknet(cfg, darknet_weights({0.5f, 2, -1}));
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ(to_string((*model)->inputs()[0]), "float32[1, 2, 2, 3]");
  const auto out = invoke(model, {floats({1, 2, 2, 3}, {1, 2, 3, 4, 5, 6, 1, 1, 1, 2, 2, 2})});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(to_string(out[0].info), "float32[1, 1, 2, 3]");
  EXPECT_EQ(out[0].values<float>(), (std::vector<float>{1.5f, 3.5f, 5.5f, 6.5f, 8.5f, 10.5f}));
}

TEST_F(OpencvDnn, MnistReadsTheNine) {
  const auto path = shared_file("models/tf/mnist.pb");
  if (path.empty()) GTEST_SKIP() << "../shared/models/tf is not there";
  auto pixels = read_png(shared_file("media/image/9.png"));
  ASSERT_EQ(pixels.size(), 28u * 28u);
  for (auto& pixel : pixels) pixel /= 255;
  const auto model = OpenEngine::open(engine("tensorflow"), path);  // owns the names
  const auto out = invoke(model, {floats({1, 784}, pixels)});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(to_string(out[0].info), "float32[1, 10]");
  EXPECT_EQ(argmax(out[0].values<float>()), 9u);
}

// MANIFEST: P-Net's map is ceil((H-2)/2) - 4 high; the same rule gives the width.
TEST_F(OpencvDnn, PnetFollowsTheSizeThatTheUserSets) {
  const auto path = shared_file("models/face/mtcnn/caffe/det1.caffemodel");
  if (path.empty()) GTEST_SKIP() << "../shared/models/face/mtcnn is not there";
  const auto model = OpenEngine::open(engine("caffe"), path, {{"input", "51:37:3:1"}});
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ(to_string((*model)->outputs()[0]), "float32[1, 4, 14, 21]");
  const auto out = invoke(model, {make_tensor(WEIR_FLOAT32, {1, 3, 37, 51})});
  ASSERT_EQ(out.size(), 2u);
  const auto p = out[1].values<float>();
  for (size_t i = 0; i < p.size() / 2; ++i) EXPECT_NEAR(p[i] + p[p.size() / 2 + i], 1, 1e-5);
}

TEST_F(OpencvDnn, ReportsItsProperties) {
  for (const char* name : {"caffe", "tensorflow", "darknet"}) {
    EXPECT_STREQ(engine(name).name, name);
    const auto* library = static_cast<const char* const*>(engine(name).extension("weir.library/1"));
    ASSERT_NE(library, nullptr);
    EXPECT_SAYS(std::string(library[0]), "opencv");
    EXPECT_TRUE(std::regex_match(library[1], std::regex("4\\.[0-9]+\\.[0-9]+"))) << library[1];
  }
  const auto model = open_caffe(kProduct, product_weights(), {{"NumThread", "2"}});
  ASSERT_TRUE(model);
  EXPECT_SAYS(std::string((*model)->info().metadata_json), R"("operators":["InnerProduct"])");
  const auto log = take_log();
  ASSERT_EQ(log.size(), 1u);
  EXPECT_SAYS(log[0], "NumThread is unknown");
}

TEST_F(OpencvDnn, OnlySmallNetworksGetOneThread) {
  const auto product = [](int64_t values) {
    const std::vector<float> weights(static_cast<size_t>(values) * 400, 1);
    return graph({placeholder("x", {1, values}), constant("w", {values, 400}, weights),
                  TensorflowNode("y", "MatMul", {"x", "w"}).type("T")});
  };
  const auto small = product(3), large = product(1000);
  const auto cores = static_cast<uint32_t>(usable_cores());
  struct Case {
    const std::string& network;
    Options options;
    int threads;
    uint32_t expected;
  };
  const Case cases[] = {{small, {}, 0, 1},     {large, {}, 0, cores},
                        {small, {}, 3, 3},     {large, {}, 3, 3},
                        {small, {}, 0, 1},     {small, {{"NumThreads", "2"}}, 0, 2},
                        {large, {}, 0, cores}, {large, {{"NumThreads", "1"}}, 3, 1}};
  for (const auto& [network, options, threads, expected] : cases) {
    const auto opened =
        OpenEngine::open(engine("tensorflow"), write("net.pb", network), options, threads);
    ASSERT_TRUE(opened) << opened.error().message();
    EXPECT_EQ((*opened)->execution().threads, expected);
  }
}

// OpenCV has one number of threads for the process, and ends all of them to change it.
TEST_F(OpencvDnn, NetworksWithDifferentThreadCountsRunAtOnce) {
  constexpr int kRuns = 1000;
  const auto sums = graph({placeholder("x", {1, 42, 42, 4}),
                           constant("w", {3, 3, 4, 2}, std::vector<float>(3 * 3 * 4 * 2, 1)),
                           TensorflowNode("y", "Conv2D", {"x", "w"})
                               .type("T")
                               .numbers("strides", {1, 1, 1, 1})
                               .text("padding", "VALID")
                               .text("data_format", "NHWC")});
  const auto ones = floats({1, 42, 42, 4}, std::vector<float>(42 * 42 * 4, 1));
  // Newer versions of OpenCV convolve by Winograd's algorithm, which rounds.
  const auto is_sum = [](float value) { return std::abs(value - 3 * 3 * 4) < 1e-3F; };
  std::vector<Result<std::unique_ptr<OpenEngine>>> models;
  for (const char* threads : {"1", "2", "3", "1", "2", "3"})
    models.push_back(open_tensorflow(sums, {{"NumThreads", threads}}));
  for (const auto& model : models) ASSERT_TRUE(model) << model.error().message();
  std::vector<int> right(models.size(), 0);
  std::barrier start(static_cast<std::ptrdiff_t>(models.size()));
  std::vector<std::thread> threads;
  for (size_t i = 0; i < models.size(); ++i)
    threads.emplace_back([&, i] {
      start.arrive_and_wait();
      for (int run = 0; run < kRuns; ++run) {
        const auto out = invoke(models[i], {ones});
        const auto values = out.size() == 1 ? out[0].values<float>() : std::vector<float>();
        right[i] +=
            values.size() == 40 * 40 * 2 && std::all_of(values.begin(), values.end(), is_sum);
      }
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(right, std::vector<int>(models.size(), kRuns));
}

// The modules of the formats share it, too.
TEST_F(OpencvDnn, FormatsWithDifferentThreadCountsRunAtOnce) {
  const auto product = graph({placeholder("x", {1, 3}), constant("w", {3, 2}, {1, 4, 2, 5, 3, 6}),
                              TensorflowNode("y", "MatMul", {"x", "w"}).type("T")});
  const auto caffe = open_caffe(kProduct, product_weights(), {{"NumThreads", "2"}});
  const auto tensorflow = open_tensorflow(product, {{"NumThreads", "3"}});
  ASSERT_TRUE(caffe && tensorflow);
  int right = 0;
  std::thread other([&] {
    for (int run = 0; run < 300; ++run) invoke(caffe, {floats({1, 3}, {1, 0, -1})});
  });
  for (int run = 0; run < 300; ++run)
    right += invoke(tensorflow, {floats({1, 3}, {1, 0, -1})})[0].values<float>() ==
             std::vector<float>{-2, -2};
  other.join();
  EXPECT_EQ(right, 300);
}

}  // namespace opencv_dnn_test
}  // namespace weir::engine_test
