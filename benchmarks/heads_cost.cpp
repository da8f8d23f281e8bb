// Decodes the output of a detector: the cost of finding and choosing its objects against copying
// the output once.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "core/heads/families.hpp"
#include "core/results/object_selection.hpp"
#include "core/tensor/geometry.hpp"
#include "rounds.hpp"

namespace {

using weir::Size;

constexpr size_t kCells = 8400, kClasses = 80, kValues = 4 + kClasses, kObjects = 100;
constexpr Size kInput{640, 640};
constexpr int kFrames = 20;

// kObjects boxes that do not overlap, each found by one cell; other scores are below 0.2.
std::vector<float> make_head(bool cells_are_inner) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> low(0, 0.2f);
  std::vector<float> out(kCells * kValues);
  const auto at = [&](size_t cell, size_t value) -> float& {
    return out[cells_are_inner ? value * kCells + cell : cell * kValues + value];
  };
  for (size_t cell = 0; cell < kCells; ++cell) {
    const auto object = static_cast<float>(cell / (kCells / kObjects));
    at(cell, 0) = 64 * (static_cast<float>(static_cast<int>(object) % 10) + 0.5f);
    at(cell, 1) = 64 * (static_cast<float>(static_cast<int>(object) / 10) + 0.5f);
    at(cell, 2) = at(cell, 3) = 50;
    for (size_t c = 0; c < kClasses; ++c) at(cell, 4 + c) = low(random);
    if (cell % (kCells / kObjects) == 0) at(cell, 4 + cell % kClasses) = 0.9f;
  }
  return out;
}

void measure(const std::string& name, bool cells_are_inner, int rounds) {
  using namespace weir;
  const std::vector<float> numbers = make_head(cells_are_inner);
  std::vector<float> copy(numbers.size());
  const TensorSpec output{ElementType::Float32,
                          cells_are_inner ? Shape{kCells, kValues, 1} : Shape{kValues, kCells, 1},
                          {}};
  const heads::ModelSignature model{
      .outputs = {{output}}, .input = kInput, .metadata = {}, .labels = kClasses};
  const auto head = heads::recognise(model, heads::kDetection).open(model, {.threshold = 0.25f});
  weir_tensor tensor{};
  tensor.data = const_cast<float*>(numbers.data());
  tensor.bytes = tensor.capacity = numbers.size() * sizeof(float);
  tensor.info = tensor_info(nullptr, WEIR_FLOAT32,
                            {1, cells_are_inner ? int64_t{kValues} : int64_t{kCells},
                             cells_are_inner ? int64_t{kCells} : int64_t{kValues}});
  heads::OutputValues values;
  size_t objects = 0;
  const auto decode = [&] {
    for (int i = 0; i < kFrames; ++i) {
      values.begin({&tensor, 1});
      objects = results::select(head->find(values, kInput), {.max_objects = 300}).size();
    }
  };
  const auto copy_once = [&] {
    for (int i = 0; i < kFrames; ++i) {
      std::memcpy(copy.data(), numbers.data(), numbers.size() * sizeof(float));
      asm volatile("" ::"r"(copy.data()) : "memory");
    }
  };
  const auto costs = bench::medians({copy_once, decode}, rounds);
  if (objects != kObjects) {
    std::fprintf(stderr, "%s: %zu objects instead of %zu\n", name.c_str(), objects, kObjects);
    std::exit(1);
  }
  const int us = static_cast<int>(costs[0].cpu / kFrames * 1e6);
  bench::report(name, "memcpy of the output, " + std::to_string(us) + " us",
                costs[1].cpu / costs[0].cpu, "x", 2);
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 31;
  measure("head of YOLOv8, 84 x 8400, 100 boxes, planes of classes: CPU time", true, rounds);
  measure("head of YOLOv8, 8400 x 84, 100 boxes, rows of cells: CPU time", false, rounds);
}
