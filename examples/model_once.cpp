// Opens a model of any engine, runs it once, and prints the index of the largest value of its first
// output. Reads its input from a file of raw bytes, or uses zeros.
//
//   model_once MODEL [BYTES] [ENGINE]
//   c++ -std=c++20 model_once.cpp -o model_once $(pkg-config --cflags --libs weir)
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>

#include "weir/model.hpp"

namespace {

int complain(const weir::Error& error) {
  std::fprintf(stderr, "%s\n", error.message().c_str());
  return 1;
}

// Replaces open dimensions with 1.
std::vector<weir::TensorShape> closed_shapes(const weir::Model& model) {
  std::vector<weir::TensorShape> shapes;
  for (const auto& input : model.inputs()) {
    shapes.push_back(input.shape);
    for (auto& extent : shapes.back()) extent = std::max<int64_t>(extent, 1);
  }
  return shapes;
}

template <class T>
void say_largest(std::span<const T> values) {
  if (values.empty()) return;
  const auto largest = std::max_element(values.begin(), values.end());
  std::printf("largest: %td, %g\n", largest - values.begin(), static_cast<double>(*largest));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "model_once MODEL [BYTES] [ENGINE]\n"), 2;
  weir::ModelOptions options;
  options.engine = argc > 3 ? argv[3] : "";
  options.timeout = std::chrono::seconds(30);
  auto model = weir::Model::open(argv[1], options);
  if (!model) return complain(model.error());
  std::printf("engine: %s\n", model->engine().c_str());
  const auto shapes = closed_shapes(*model);
  if (const auto status = model->reshape(shapes); !status) return complain(status.error());
  for (const auto& input : model->inputs()) std::printf("input: %s\n", input.to_string().c_str());
  for (const auto& output : model->outputs())
    std::printf("output: %s\n", output.to_string().c_str());

  std::vector<std::vector<char>> memory;
  std::vector<weir::TensorView> inputs;
  for (const auto& input : model->inputs()) {
    memory.emplace_back(static_cast<size_t>(input.elements()) * weir::element_bytes(input.type));
    if (argc > 2 && *argv[2] && memory.size() == 1) {
      std::ifstream file(argv[2], std::ios::binary);
      memory[0].assign(std::istreambuf_iterator<char>(file), {});
    }
    inputs.emplace_back(memory.back().data(), memory.back().size(), input.type);
  }
  const auto outputs = model->invoke(inputs);
  if (!outputs) return complain(outputs.error());
  if (outputs->size() == 0) return std::printf("the model gave nothing\n"), 0;
  const weir::Tensor first = (*outputs)[0];
  if (const auto values = first.as<float>()) say_largest(*values);
  if (const auto values = first.as<uint8_t>()) say_largest(*values);
  return 0;
}
