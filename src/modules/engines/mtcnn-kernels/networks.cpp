// SPDX-License-Identifier: LGPL-2.1-or-later
#include "networks.hpp"

#include <array>
#include <optional>
#include <vector>

#include "onnx_graph.hpp"
#include "weir/join.hpp"

namespace mtcnn::kernels {
namespace {

// Ranges: the values that the layers gave on photos and video, with a small margin.
constexpr ConvolutionPlan kProposal[] = {
    {3, 3, 10, 2, {-3.2f, 13.f}}, {3, 10, 16, 0, {-8.8f, 14.2f}}, {3, 16, 32, 0, {-6.3f, 16.f}}};
constexpr ConvolutionPlan kRefinement[] = {
    {3, 3, 28, 3, {-4.1f, 4.7f}}, {3, 28, 48, 3, {-2.8f, 4.f}}, {2, 48, 64, 0, {-0.35f, 3.f}}};
constexpr ConvolutionPlan kLandmarks[] = {{3, 3, 32, 3, {-1.7f, 6.4f}},
                                          {3, 32, 64, 3, {-2.8f, 5.6f}},
                                          {3, 64, 64, 2, {-1.1f, 4.4f}},
                                          {2, 64, 128, 0, {-0.2f, 3.1f}}};
constexpr uint32_t kTwoHeads[] = {2, 4}, kThreeHeads[] = {2, 4, 10};
constexpr NetworkPlan kPlans[] = {
    {"P-Net", 12, kProposal, 32, 0, {0, 1}, kTwoHeads},
    {"R-Net", 24, kRefinement, 9 * 64, 128, {-0.05f, 2.1f}, kTwoHeads},
    {"O-Net", 48, kLandmarks, 9 * 128, 256, {-0.2f, 2.6f}, kThreeHeads},
};

using weir::Code;
using weir::Error;

Error unsupported(const std::string& what, const std::string& offered, const std::string& needed,
                  const std::string& difference) {
  return {.code = Code::MODEL_UNSUPPORTED,
          .what = what,
          .offered = offered,
          .needed = needed,
          .difference = difference,
          .fix = "--framework onnxruntime runs other networks"};
}

// The operators of a plan, "Conv PRelu MaxPool ...", without those that only move values.
std::string operators(const NetworkPlan& plan) {
  std::string out;
  for (const auto& one : plan.convolutions) out += one.pool ? "Conv PRelu MaxPool " : "Conv PRelu ";
  if (plan.dense) out += "Dense PRelu ";
  for (size_t i = 0; i < plan.heads.size(); ++i) out += plan.dense ? "Dense " : "Conv ";
  out.pop_back();
  return out;
}

class Reader {
 public:
  Reader(const OnnxGraph& graph, const std::string& name) : graph_(graph), name_(name) {}

  weir::Result<Network> read() {
    std::vector<std::string> words;
    for (const auto& node : graph_.nodes)
      if (std::string word = get_name(node); !word.empty()) words.push_back(std::move(word));
    const std::string found = weir::join(words, " ");
    for (const auto& plan : kPlans)
      if (operators(plan) == found) return read(plan);
    const std::string known = weir::join(kPlans, "; or ", [](const auto& plan) {
      return std::string(plan.name) + ": " + operators(plan);
    });
    return unsupported("this is not one of MTCNN's networks", name_ + ": " + found, known, "");
  }

 private:
  static std::string get_name(const OnnxNode& node) {
    if (node.type == "Gemm" || node.type == "MatMul") return "Dense";
    return node.type == "Conv" || node.type == "PRelu" || node.type == "MaxPool" ? node.type : "";
  }

  weir::Result<Network> read(const NetworkPlan& plan) {
    plan_ = &plan;
    for (const auto& node : graph_.nodes) turned_ = turned_ || node.type == "Transpose_0312";
    Network out{&plan, {}};
    for (const auto& one : plan.convolutions)
      out.layers.push_back(convolution(one.kernel, one.inputs, one.outputs));
    if (plan.dense) out.layers.push_back(dense(plan.features, plan.dense));
    for (auto& layer : out.layers) layer.slope = slopes(layer.outputs);
    out.layers.push_back(heads());
    if (fault_) return *fault_;
    return out;
  }

  // Returns the next node of the type, whose weights must have this many values. Empty after a
  // fault.
  const OnnxNode* next(size_t* at, std::initializer_list<std::string_view> types) {
    for (; *at < graph_.nodes.size(); ++*at)
      for (const auto type : types)
        if (graph_.nodes[*at].type == type) return &graph_.nodes[(*at)++];
    return nullptr;
  }
  std::vector<float> numbers(const OnnxNode* node, size_t input,
                             const std::vector<int64_t>& shape) {
    const OnnxTensor* tensor = nullptr;
    if (node && node->inputs.size() > input) tensor = graph_.tensor(node->inputs[input]);
    if (tensor && tensor->shape == shape) return tensor->numbers;
    fault(node ? node->type : "an operator", tensor ? &tensor->shape : nullptr, shape);
    size_t count = 1;
    for (const auto extent : shape) count *= static_cast<size_t>(extent);
    return std::vector<float>(count);
  }
  void fault(const std::string& of, const std::vector<int64_t>* offered,
             const std::vector<int64_t>& needed) {
    if (fault_) return;
    fault_ = unsupported(std::string("weights of ") + plan_->name + " have a different shape",
                         name_ + ": " + (offered ? format_shape(*offered) : "none"),
                         format_shape(needed), of + " " + std::to_string(convolutions_at_));
  }
  static std::string format_shape(const std::vector<int64_t>& shape) {
    std::string out = "[";
    out += weir::join(shape, ", ", [](int64_t extent) { return std::to_string(extent); });
    return out + "]";
  }

  Layer convolution(uint32_t kernel, uint32_t inputs, uint32_t outputs) {
    const OnnxNode* node = next(&convolutions_at_, {"Conv"});
    const auto weights = numbers(node, 1, {outputs, inputs, kernel, kernel});
    Layer out{kernel, inputs, outputs, std::vector<float>(weights.size()), {}, {}};
    out.bias = numbers(node, 2, {outputs});
    const size_t area = size_t{kernel} * kernel;
    for (size_t o = 0; o < outputs; ++o)
      for (size_t c = 0; c < inputs; ++c)
        for (size_t y = 0; y < kernel; ++y)
          for (size_t x = 0; x < kernel; ++x)
            out.weights[((o * kernel + y) * kernel + x) * inputs + c] =
                weights[(o * inputs + c) * area + (turned_ ? x * kernel + y : y * kernel + x)];
    return out;
  }

  Layer dense(uint32_t inputs, uint32_t outputs) {
    const OnnxNode* node = next(&dense_at_, {"Gemm", "MatMul"});
    const bool product = node && node->type == "MatMul";  // [inputs, outputs], followed by an Add
    const auto weights =
        product ? numbers(node, 1, {inputs, outputs}) : numbers(node, 1, {outputs, inputs});
    Layer out{1, inputs, outputs, std::vector<float>(weights.size()), {}, {}};
    out.bias = product ? numbers(find_adder(*node), 1, {outputs}) : numbers(node, 2, {outputs});
    for (size_t o = 0; o < outputs; ++o)
      for (size_t i = 0; i < inputs; ++i)
        out.weights[o * inputs + place(i)] =
            product ? weights[i * outputs + o] : weights[o * inputs + i];
    return out;
  }
  const OnnxNode* find_adder(const OnnxNode& product) {
    for (const auto& node : graph_.nodes)
      if (node.type == "Add" && !node.inputs.empty() && node.inputs[0] == product.output)
        return &node;
    return nullptr;
  }
  // The first fully connected layer of a file expects features as [x][y][channel]; ours are [y][x].
  size_t place(size_t i) const {
    if (dense_seen_ > 0) return i;
    constexpr size_t kMap = 3;  // width and height of the maps of both networks
    const size_t channels = plan_->features / (kMap * kMap);
    const size_t x = i / channels / kMap, y = i / channels % kMap;
    return (y * kMap + x) * channels + i % channels;
  }

  std::vector<float> slopes(uint32_t outputs) {
    const OnnxNode* node = next(&slopes_at_, {"PRelu"});
    const OnnxTensor* tensor =
        node && node->inputs.size() > 1 ? graph_.tensor(node->inputs[1]) : nullptr;
    if (tensor && tensor->numbers.size() == outputs) return tensor->numbers;
    fault("PRelu", tensor ? &tensor->shape : nullptr, {outputs});
    return std::vector<float>(outputs);
  }

  Layer heads() {
    Layer out{1, plan_->dense ? plan_->dense : plan_->features, plan_->head_outputs(), {}, {}, {}};
    out.weights.resize(size_t{out.inputs} * out.outputs);
    out.bias.resize(out.outputs);
    dense_seen_ = 1;
    for (size_t i = 0; i < plan_->heads.size(); ++i) {
      size_t convolution_at = convolutions_at_, dense_at = dense_at_;
      const uint32_t outputs = head_outputs_at(plan_->dense ? &dense_at : &convolution_at);
      size_t first = 0, known = 0;
      while (known < plan_->heads.size() && plan_->heads[known] != outputs)
        first += plan_->heads[known++];
      if (known == plan_->heads.size() || first >= out.outputs) known = 0, first = 0;
      const Layer one = plan_->dense ? dense(out.inputs, plan_->heads[known])
                                     : convolution(1, out.inputs, plan_->heads[known]);
      std::copy(one.weights.begin(), one.weights.end(),
                out.weights.begin() + static_cast<ptrdiff_t>(first * out.inputs));
      std::copy(one.bias.begin(), one.bias.end(), out.bias.begin() + static_cast<ptrdiff_t>(first));
    }
    return out;
  }
  // Files may list the heads in any order.
  uint32_t head_outputs_at(size_t* at) {
    const OnnxNode* node = next(at, {"Conv", "Gemm", "MatMul"});
    const OnnxTensor* tensor =
        node && node->inputs.size() > 1 ? graph_.tensor(node->inputs[1]) : nullptr;
    if (!tensor || tensor->shape.size() < 2) return 0;
    return static_cast<uint32_t>(tensor->shape[node->type == "MatMul" ? 1 : 0]);
  }

  const OnnxGraph& graph_;
  const std::string& name_;
  const NetworkPlan* plan_ = nullptr;
  bool turned_ = false;
  size_t convolutions_at_ = 0, dense_at_ = 0, slopes_at_ = 0, dense_seen_ = 0;
  std::optional<Error> fault_;
};

}  // namespace

std::span<const NetworkPlan> network_plans() {
  return kPlans;
}

weir::Result<Network> read_network(std::span<const std::byte> file, const std::string& name) {
  const auto graph = read_graph(file, name);
  if (!graph) return graph.error();
  return Reader(*graph, name).read();
}

}  // namespace mtcnn::kernels
