// Tests damaged model files of every format in their real engines, each in a worker process: each
// is rejected with a text, or runs with outputs of finite sizes; this process survives all of them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "core/isolate/isolated_engine.hpp"
#include "weir/module.hpp"

namespace weir::isolate {
namespace damaged_models_test {

namespace fs = std::filesystem;
constexpr int kFilesOfAFormat = 50;  // each in a worker of its own

std::string read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Truncates at a random offset, or flips one to eight bits, mostly at the ends of the file, where
// its structure is.
std::string damaged(const std::string& whole, std::mt19937& random) {
  const auto below = [&random](size_t limit) {
    return std::uniform_int_distribution<size_t>(0, limit - 1)(random);
  };
  if (below(4) == 0) return whole.substr(0, below(whole.size()));
  std::string out = whole;
  const size_t flips = 1 + below(8), end = std::min<size_t>(whole.size(), 4096);
  for (size_t i = 0; i < flips; ++i) {
    const size_t kind = below(3);
    const size_t at = kind == 0   ? below(end)
                      : kind == 1 ? whole.size() - 1 - below(end)
                                  : below(whole.size());
    out[at] = static_cast<char>(out[at] ^ (1 << below(8)));
  }
  return out;
}

// Invokes once on zeros. Returns "" on success, otherwise the error.
std::string run(infer::Model& model) {
  std::vector<std::vector<std::byte>> memory;
  std::vector<weir_tensor> inputs(model.inputs().size()), outputs(model.outputs().size());
  for (size_t i = 0; i < inputs.size(); ++i) {
    auto& info = inputs[i].info = model.inputs()[i];
    if (info.rank > WEIR_RANK_LIMIT) return "unknown rank";
    uint64_t bytes = element_bytes(info.type);
    for (uint32_t d = 0; d < info.rank; ++d) {
      if (info.shape[d] < 0) info.shape[d] = 1;
      bytes *= static_cast<uint64_t>(info.shape[d]);
      if (bytes > 1u << 28) return "an input beyond reason";
    }
    memory.emplace_back(bytes + 64);
    inputs[i].data = memory.back().data();
    inputs[i].bytes = bytes;
    inputs[i].capacity = bytes + 64;
    inputs[i].fence_fd = -1;
  }
  auto session = infer::Session::create(std::shared_ptr<infer::Model>(&model, [](auto*) {}));
  if (!session) return session.error().message();
  std::vector<weir_tensor_info> infos;
  for (const auto& input : inputs) infos.push_back(input.info);
  const auto resolved = (*session)->resolve(infos);
  if (!resolved) return resolved.error().message();
  for (size_t i = 0; i < outputs.size(); ++i) {
    outputs[i].info = (*resolved)[i];
    outputs[i].fence_fd = -1;
  }
  weir_frame in{}, out{};
  in.struct_size = out.struct_size = sizeof in;
  in.n_tensors = static_cast<uint32_t>(inputs.size());
  in.tensors = inputs.data();
  out.n_tensors = static_cast<uint32_t>(outputs.size());
  out.tensors = outputs.data();
  const auto made = (*session)->invoke(in, out);
  std::string text = made ? "" : made.error().message();
  for (auto& tensor : outputs) {
    EXPECT_LE(tensor.bytes, tensor.data ? uint64_t{1} << 32 : tensor.bytes);
    if (tensor.release) tensor.release(tensor.owner);
  }
  return text;
}

// A 3x3 convolution over two planes of 4x4, then pooling: writes two files and returns their common
// stem.
std::string darknet_network() {
  const std::string stem = testing::TempDir() + "weir-darknet";
  std::ofstream(stem + ".cfg")
      << "[net]\nbatch=1\nwidth=4\nheight=4\nchannels=2\n"
         "[convolutional]\nbatch_normalize=1\nfilters=3\nsize=3\nstride=1\n"
         "pad=1\nactivation=leaky\n[maxpool]\nsize=2\nstride=2\n";
  std::ofstream weights(stem + ".weights", std::ios::binary);
  const int32_t head[]{0, 2, 0, 0, 0};  // version 0.2, then the number of images seen in 64 bits
  weights.write(reinterpret_cast<const char*>(head), sizeof head);
  for (int i = 0; i < 4 * 3 + 3 * 2 * 9; ++i) {
    const float value = 1 + static_cast<float>(i % 7) / 8;
    weights.write(reinterpret_cast<const char*>(&value), sizeof value);
  }
  return stem;
}

// One model of each format that can run here: Weir's own, and those of installed data. Of a network
// with two files, the first is damaged.
using Files = std::vector<std::string>;
std::vector<Files> models() {
  std::vector<Files> out;
  if (const char* own = std::getenv("WEIR_TEST_MODEL")) out.push_back({own});
  const std::string darknet = darknet_network();
  out.push_back({darknet + ".weights", darknet + ".cfg"});
  out.push_back({darknet + ".cfg", darknet + ".weights"});
  const char* data = std::getenv("WEIR_DATA");
  const std::string folder = std::string(data ? data : WEIR_SHARED) + "/models/";
  const std::string caffe = folder + "face/mtcnn/caffe/det1";
  out.push_back({folder + "sensor/keypoint_classifier.tflite"});
  out.push_back({folder + "tf/mnist.pb"});
  out.push_back({folder + "torchscript/sample_4x4x4x4x4_two_input_one_output.pt"});
  out.push_back({caffe + ".caffemodel", caffe + ".prototxt"});
  out.push_back({caffe + ".prototxt", caffe + ".caffemodel"});
  return out;
}

class DamagedModels : public ::testing::TestWithParam<Files> {};

TEST_P(DamagedModels, AreRejectedOrRun) {
  const fs::path original(GetParam().front());
  if (!fs::is_regular_file(original)) GTEST_SKIP() << original << " is not there";
  const std::string whole = read(original);
  const auto isolation = std::make_shared<Isolation>();
  isolation->timeout = std::chrono::milliseconds(10000);
  isolation->memory_mib = 4096;
  isolation->on_crash = OnCrash::Error;
  isolation->monitor = std::make_shared<Monitor>();
  const fs::path file =
      fs::path(testing::TempDir()) / ("weir-damaged" + original.extension().string());
  infer::OpenOptions options;
  options.paths = {file.string()};
  options.paths.insert(options.paths.end(), GetParam().begin() + 1, GetParam().end());
  if (original.extension() == ".pt")  // the file does not declare its inputs
    options.options = {{"input", "4:4:4:4:4,4:4:4:4:4"}, {"inputtype", "float32,float32"}};
  options.threads = 1;
  options.host_context = isolation;
  const auto outcome = [&](const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
    auto model = infer::Model::open(isolated_engine(), options);
    return model ? run(**model) : model.error().message();
  };
  const std::string good = outcome(whole);
  if (good.find("WEIR-3002") != std::string::npos) GTEST_SKIP() << good;
  ASSERT_EQ(good, "");
  std::mt19937 random(20261121);
  int ran = 0;
  for (int i = 0; i < kFilesOfAFormat; ++i) {
    const std::string text = outcome(damaged(whole, random));
    ran += text.empty();
    EXPECT_TRUE(text.empty() || text.starts_with("WEIR-") || text.starts_with("an input")) << text;
  }
  const auto counts = isolation->monitor->counts();
  std::printf("%s: %d ran, %d were refused, of those %d by the end of the worker, %d by silence\n",
              original.filename().c_str(), ran, kFilesOfAFormat - ran,
              static_cast<int>(counts.ended), static_cast<int>(counts.timed_out));
  EXPECT_LT(ran, kFilesOfAFormat);
  fs::remove(file);
}

INSTANTIATE_TEST_SUITE_P(Each, DamagedModels, testing::ValuesIn(models()),
                         [](const auto& info) { return "model" + std::to_string(info.index); });
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(DamagedModels);

}  // namespace damaged_models_test
}  // namespace weir::isolate
