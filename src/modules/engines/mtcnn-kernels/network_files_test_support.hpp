// Networks with random weights for tests, as ONNX files and as plain loops over doubles.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cmath>
#include <random>

#include "networks.hpp"
#include "onnxruntime/onnx_builder_test_support.hpp"

namespace mtcnn::kernels::test {

// One layer in the order of the files: [outputs][inputs][y][x], or [outputs][inputs].
struct PlainLayer {
  size_t kernel = 1, inputs = 0, outputs = 0, pool = 0;
  std::vector<float> weights, bias, slope;
};

inline std::vector<float> chance(size_t count, float max, std::mt19937* random) {
  std::uniform_real_distribution<float> uniform(-max, max);
  std::vector<float> out(count);
  for (auto& number : out) number = uniform(*random);
  return out;
}

// The convolutions, the fully connected layer and each head.
inline std::vector<PlainLayer> plain_layers(const NetworkPlan& plan) {
  std::mt19937 random(7);
  std::vector<PlainLayer> out;
  const auto add = [&](size_t kernel, size_t inputs, size_t outputs, size_t pool, bool bent) {
    const size_t count = inputs * kernel * kernel;
    const float max = 1.5f / std::sqrt(static_cast<float>(count));
    out.push_back({kernel, inputs, outputs, pool, chance(count * outputs, max, &random),
                   chance(outputs, 0.2f, &random),
                   bent ? chance(outputs, 0.5f, &random) : std::vector<float>()});
  };
  for (const auto& one : plan.convolutions)
    add(one.kernel, one.inputs, one.outputs, one.pool, true);
  if (plan.dense) add(1, plan.features, plan.dense, 0, true);
  for (const uint32_t outputs : plan.heads)
    add(1, plan.dense ? plan.dense : plan.features, outputs, 0, false);
  return out;
}

using Planes = std::vector<std::vector<double>>;  // [channel][y * width + x]
struct Map {
  size_t width, height;
  Planes planes;
};

inline Map convolved(const Map& in, const PlainLayer& layer) {
  Map out{in.width - layer.kernel + 1, in.height - layer.kernel + 1, Planes(layer.outputs)};
  for (size_t o = 0; o < layer.outputs; ++o)
    for (size_t y = 0; y < out.height; ++y)
      for (size_t x = 0; x < out.width; ++x) {
        double sum = layer.bias[o];
        for (size_t i = 0; i < layer.inputs; ++i)
          for (size_t v = 0; v < layer.kernel; ++v)
            for (size_t u = 0; u < layer.kernel; ++u)
              sum += in.planes[i][(y + v) * in.width + x + u] *
                     layer.weights[((o * layer.inputs + i) * layer.kernel + v) * layer.kernel + u];
        out.planes[o].push_back(sum < 0 && !layer.slope.empty() ? sum * layer.slope[o] : sum);
      }
  return out;
}

inline Map pooled(const Map& in, size_t kernel) {
  const auto counted = [&](size_t extent) {
    return static_cast<size_t>(std::ceil((double(extent) - double(kernel)) / 2)) + 1;
  };
  Map out{counted(in.width), counted(in.height), Planes(in.planes.size())};
  for (size_t c = 0; c < in.planes.size(); ++c)
    for (size_t y = 0; y < out.height; ++y)
      for (size_t x = 0; x < out.width; ++x) {
        double max = -INFINITY;
        for (size_t v = 2 * y; v < std::min(2 * y + kernel, in.height); ++v)
          for (size_t u = 2 * x; u < std::min(2 * x + kernel, in.width); ++u)
            max = std::max(max, in.planes[c][v * in.width + u]);
        out.planes[c].push_back(max);
      }
  return out;
}

// The expected output of Runner::run for one picture: the values of each head, [y][x][outputs].
inline std::vector<std::vector<double>> plain_run(const NetworkPlan& plan, const uint8_t* picture,
                                                  size_t width, size_t height) {
  const auto layers = plain_layers(plan);
  Map map{width, height, Planes(3, std::vector<double>(width * height))};
  for (size_t i = 0; i < width * height * 3; ++i)
    map.planes[i % 3][i / 3] = (picture[i] - 127.5) / 128;
  size_t at = 0;
  for (; at < plan.convolutions.size(); ++at) {
    map = convolved(map, layers[at]);
    if (layers[at].pool) map = pooled(map, layers[at].pool);
  }
  if (plan.dense) {
    Map features{1, 1, {}};
    for (size_t x = 0; x < map.width; ++x)  // the original networks order features as [x][y]
      for (size_t y = 0; y < map.height; ++y)
        for (const auto& plane : map.planes) features.planes.push_back({plane[y * map.width + x]});
    map = convolved(features, layers[at++]);
  }
  std::vector<std::vector<double>> out;
  for (; at < layers.size(); ++at) {
    const Map head = convolved(map, layers[at]);
    std::vector<double> numbers;
    for (size_t i = 0; i < head.width * head.height; ++i)
      for (size_t o = 0; o < layers[at].outputs; ++o) {
        const double value = head.planes[o][i];
        double both = 0;
        for (size_t other = 0; out.empty() && other < 2; ++other)
          both += std::exp(head.planes[other][i]);
        numbers.push_back(out.empty() ? std::exp(value) / both : value);
      }
    out.push_back(std::move(numbers));
  }
  return out;
}

// `turned`: a file for pictures with rows and columns exchanged and interleaved colours.
inline std::vector<std::byte> network_file(const NetworkPlan& plan, bool turned) {
  weir::engine_test::OnnxBuilder file;
  const auto layers = plain_layers(plan);
  if (turned)
    file.node("Transpose", {"in"}, {"x"}).attribute("perm", std::vector<int64_t>{0, 3, 1, 2});
  for (size_t i = 0; i < layers.size(); ++i) {
    const PlainLayer& layer = layers[i];
    const std::string n = std::to_string(i);
    const auto outputs = static_cast<int64_t>(layer.outputs);
    const auto inputs = static_cast<int64_t>(layer.inputs);
    const auto kernel = static_cast<int64_t>(layer.kernel);
    auto weights = layer.weights;
    file.constant("b" + n, {outputs}, layer.bias);
    if (plan.dense && i >= plan.convolutions.size()) {
      if (turned) {
        for (size_t o = 0; o < layer.outputs; ++o)
          for (size_t k = 0; k < layer.inputs; ++k)
            weights[k * layer.outputs + o] = layer.weights[o * layer.inputs + k];
        file.constant("w" + n, {inputs, outputs}, weights);
        file.node("MatMul", {"x", "w" + n}, {"m" + n}).node("Add", {"m" + n, "b" + n}, {"x"});
      } else {
        file.constant("w" + n, {outputs, inputs}, weights);
        file.node("Gemm", {"x", "w" + n, "b" + n}, {"x"});
      }
    } else {
      if (turned)
        for (size_t a = 0; a < layer.outputs * layer.inputs; ++a)
          for (size_t y = 0; y < layer.kernel; ++y)
            for (size_t x = 0; x < layer.kernel; ++x)
              weights[(a * layer.kernel + x) * layer.kernel + y] =
                  layer.weights[(a * layer.kernel + y) * layer.kernel + x];
      file.constant("w" + n, {outputs, inputs, kernel, kernel}, weights);
      file.node("Conv", {"x", "w" + n, "b" + n}, {"x"});
    }
    if (!layer.slope.empty())
      file.constant("s" + n, {outputs, 1, 1}, layer.slope).node("PRelu", {"x", "s" + n}, {"x"});
    if (layer.pool) file.node("MaxPool", {"x"}, {"x"});
  }
  return file.bytes();
}

}  // namespace mtcnn::kernels::test
