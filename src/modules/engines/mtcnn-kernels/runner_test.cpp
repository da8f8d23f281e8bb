// Tests networks read from files against plain loops, and files that are not networks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "runner.hpp"

#include <gtest/gtest.h>

#include "engine_host_test_support.hpp"
#include "layers.hpp"
#include "network_files_test_support.hpp"
#include "says.hpp"

namespace mtcnn::kernels {
namespace runner_test {

using test::network_file;

std::vector<uint8_t> picture(size_t width, size_t height, uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<uint8_t> out(width * height * 3);
  for (auto& byte : out) byte = static_cast<uint8_t>(random());
  return out;
}

std::vector<std::vector<float>> run(const Network& network, Precision precision,
                                    const std::vector<uint8_t>& pictures, size_t count,
                                    size_t width, size_t height) {
  const auto runner = make_runner(network, precision);
  const auto size = runner->map_size(width, height);
  std::vector<std::vector<float>> out;
  for (const uint32_t outputs : network.plan->heads)
    out.emplace_back(count * size.width * size.height * outputs);
  std::vector<float*> data;
  for (auto& numbers : out) data.push_back(numbers.data());
  runner->run(pictures.data(), count, width, height, data.data());
  return out;
}

void runs_like_plain_loops(const NetworkPlan& plan, bool turned, size_t width, size_t height,
                           size_t count) {
  SCOPED_TRACE(std::string(plan.name) + (turned ? " turned " : " ") + std::to_string(width) + "x" +
               std::to_string(height));
  const auto network = read_network(network_file(plan, turned), "test");
  ASSERT_TRUE(network) << network.error().message();
  const auto pictures = picture(width, height * count, 3);
  const auto out = run(*network, Precision::Float32, pictures, count, width, height);
  for (size_t n = 0; n < count; ++n) {
    const auto wanted = test::plain_run(plan, &pictures[n * width * height * 3], width, height);
    ASSERT_EQ(out.size(), wanted.size());
    for (size_t h = 0; h < out.size(); ++h) {
      ASSERT_EQ(out[h].size(), wanted[h].size() * count);
      for (size_t i = 0; i < wanted[h].size(); ++i)
        ASSERT_NEAR(out[h][n * wanted[h].size() + i], wanted[h][i], 1e-4) << h << ", " << i;
    }
  }
}

TEST(Runner, FloatNetworksAgreeWithPlainLoops) {
  const auto plans = network_plans();
  for (const bool turned : {false, true}) {
    for (const auto& [width, height] : {std::pair<size_t, size_t>{12, 12}, {13, 17}, {37, 51}})
      runs_like_plain_loops(plans[0], turned, width, height, 2);
    runs_like_plain_loops(plans[1], turned, 24, 24, 2);
    runs_like_plain_loops(plans[2], turned, 48, 48, 1);
  }
}

TEST(Runner, FramesOfDifferentSizesAreIndependent) {
  const auto network = read_network(network_file(network_plans()[0], false), "test");
  ASSERT_TRUE(network);
  const auto runner = make_runner(*network, Precision::Float32);
  for (const size_t width : {40, 15, 33, 40}) {
    const auto pixels = picture(width, 21, 1);
    const auto size = runner->map_size(width, 21);
    std::vector<float> face(2 * size.width * size.height), box(2 * face.size());
    float* const out[] = {face.data(), box.data()};
    runner->run(pixels.data(), 1, width, 21, out);
    EXPECT_EQ(face, run(*network, Precision::Float32, pixels, 1, width, 21)[0]);
  }
}

// With 8 bits, each weight adds at most half a unit of error to a sum, which is rounded at the end.
TEST(Layers, EightBitsDifferOnlyByRounding) {
  const size_t inputs = 10, outputs = 17, pixels = 5, step = get_step<uint8_t>(inputs);
  std::mt19937 random(5);
  Layer layer{3,
              inputs,
              outputs,
              test::chance(9 * inputs * outputs, 0.3f, &random),
              test::chance(outputs, 1, &random),
              test::chance(outputs, 0.5f, &random)};
  const Scale in = Scale::of({-2, 6}), out = Scale::of({-20, 20});
  const PackedLayer<uint8_t> packed(layer, in, out);
  const auto bytes = picture(100, 1, 9);
  const uint8_t* rows[] = {&bytes[0], &bytes[100], &bytes[200]};
  std::vector<uint8_t> found(pixels * padded(outputs));
  packed.apply(rows, step, pixels, found.data());
  for (size_t p = 0; p < pixels; ++p)
    for (size_t o = 0; o < outputs; ++o) {
      double sum = layer.bias[o], of_inputs = 0, max = 0;
      for (size_t k = 0; k < 9 * inputs; ++k) {
        const size_t row = k / (3 * inputs), x = k / inputs % 3, c = k % inputs;
        const double value = (rows[row][(p + x) * step + c] - in.zero) * in.step;
        const double weight = layer.weights[o * 9 * inputs + k];
        sum += value * weight;
        of_inputs += std::abs(value);
        max = std::max(max, std::abs(weight));
      }
      const double wanted = sum < 0 ? sum * layer.slope[o] : sum;
      const double given = (found[p * padded(outputs) + o] - out.zero) * out.step;
      EXPECT_NEAR(given, wanted, of_inputs * max / 254 + out.step * 0.51) << p << ", " << o;
    }
}

// The bound is the error measured on patches of photos (docs/guide/evaluation.md) plus a margin.
TEST(Runner, EightBitsScoreNearlyLikeFloats) {
  const char* kFiles[] = {"pnet", "rnet", "onet"};
  for (size_t i = 0; i < 3; ++i) {
    const auto path = weir::engine_test::shared_file("models/face/mtcnn/onnx/" +
                                                     std::string(kFiles[i]) + ".onnx");
    if (path.empty()) GTEST_SKIP() << "../shared/models/face is not there";
    const auto network = read_network(weir::engine_test::read_bytes(path), path);
    ASSERT_TRUE(network) << network.error().message();
    const size_t side = network->plan->side, width = i == 0 ? 5 * side : side;
    std::vector<uint8_t> smooth(width * side * 3);  // waves, because photos are smooth
    for (size_t at = 0; at < smooth.size(); ++at)
      smooth[at] =
          static_cast<uint8_t>(127 + 100 * std::sin(static_cast<double>(at / 3 % width) * 0.7 +
                                                    static_cast<double>(at / (3 * width)) * 0.4));
    const auto whole = run(*network, Precision::Float32, smooth, 1, width, side);
    const auto bytes = run(*network, Precision::Int8, smooth, 1, width, side);
    for (size_t h = 0; h < whole.size(); ++h)
      for (size_t n = 0; n < whole[h].size(); ++n)
        EXPECT_NEAR(bytes[h][n], whole[h][n], 0.1) << kFiles[i] << ", " << h << ", " << n;
  }
}

weir::Error get_error(const std::vector<std::byte>& file) {
  const auto network = read_network(file, "pnet.onnx");
  return network ? weir::Error{.code = weir::Code::INTERNAL, .what = "it was read"}
                 : network.error();
}

TEST(NetworkFile, TruncatedIsDamaged) {
  const auto whole = network_file(network_plans()[0], false);
  for (size_t size = 0; size < whole.size(); size += 97) {
    const auto error = get_error({whole.begin(), whole.begin() + static_cast<ptrdiff_t>(size)});
    EXPECT_EQ(error.code, weir::Code::MODEL_INVALID) << size;
    EXPECT_EQ(error.what, "the file of a network is damaged");
    EXPECT_EQ(error.offered, "pnet.onnx, " + std::to_string(size) + " bytes");
  }
}

TEST(NetworkFile, OfAnotherNetworkIsDescribedByItsLayers) {
  const auto error = get_error(weir::engine_test::OnnxBuilder()
                                   .node("Conv", {"x", "w"}, {"y"})
                                   .node("Relu", {"y"}, {"z"})
                                   .node("MaxPool", {"z"}, {"out"})
                                   .bytes());
  EXPECT_EQ(error.code, weir::Code::MODEL_UNSUPPORTED);
  EXPECT_EQ(error.what, "this is not one of MTCNN's networks");
  EXPECT_EQ(error.offered, "pnet.onnx: Conv MaxPool");
  EXPECT_SAYS(error.needed, "P-Net: Conv PRelu MaxPool Conv PRelu Conv PRelu Conv Conv");
  EXPECT_SAYS(error.fix, "onnxruntime");
}

TEST(NetworkFile, WithWeightsOfADifferentShapeIsRejected) {
  const uint32_t heads[] = {2, 4};
  const ConvolutionPlan wider[] = {{3, 3, 10, 2, {}}, {3, 10, 16, 0, {}}, {3, 16, 40, 0, {}}};
  const NetworkPlan plan{"wider", 12, wider, 40, 0, {}, heads};
  const auto error = get_error(network_file(plan, false));
  EXPECT_EQ(error.code, weir::Code::MODEL_UNSUPPORTED);
  EXPECT_EQ(error.what, "weights of P-Net have a different shape");
  EXPECT_EQ(error.offered, "pnet.onnx: [40, 16, 3, 3]");
  EXPECT_EQ(error.needed, "[32, 16, 3, 3]");
}

TEST(NetworkFile, WithMissingOrInvalidWeightsIsRejected) {
  weir::engine_test::OnnxBuilder empty;
  for (const char* op :
       {"Conv", "PRelu", "MaxPool", "Conv", "PRelu", "Conv", "PRelu", "Conv", "Conv"})
    empty.node(op, {"x", "w", "b"}, {"x"});
  const auto none = get_error(empty.bytes());
  EXPECT_EQ(none.what, "weights of P-Net have a different shape");
  EXPECT_EQ(none.offered, "pnet.onnx: none");
  EXPECT_EQ(none.needed, "[10, 3, 3, 3]");
  empty.constant("w", {10, 3, 3, 3}, std::vector<float>(270, NAN));
  EXPECT_EQ(get_error(empty.bytes()).code, weir::Code::MODEL_INVALID);
  weir::engine_test::OnnxBuilder few;
  few.constant("w", {10, 3, 3, 3}, std::vector<float>(200, 1.f));
  EXPECT_EQ(get_error(few.bytes()).code, weir::Code::MODEL_INVALID);
}

}  // namespace runner_test
}  // namespace mtcnn::kernels
