// Test fixture of the three engines that OpenCV runs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "engine_host_test_support.hpp"
#include "opencv-dnn/dnn_builders_test_support.hpp"
#include "says.hpp"

namespace weir::engine_test {

class DnnTest : public ::testing::Test {
 protected:
  using Options = OpenEngine::Options;

  // "caffe", "tensorflow" or "darknet".
  static const weir_engine& engine(const std::string& name) {
    static std::map<std::string, const weir_engine*> loaded;
    auto& engine = loaded[name];
    if (!engine) engine = load_module((WEIR_DNN_MODULES "/libweir-engine-" + name + ".so").c_str());
    if (!engine) std::abort();
    return *engine;
  }
  void SetUp() override { take_log(); }

  std::string write(const std::string& name, const std::string& text) {
    const auto* begin = reinterpret_cast<const std::byte*>(text.data());
    return folder_.write(name, {begin, begin + text.size()});
  }
  // Writes and opens net.prototxt and net.caffemodel.
  Result<std::unique_ptr<OpenEngine>> open_caffe(const std::string& prototxt,
                                                 const std::string& weights,
                                                 const Options& options = {}) {
    write("net.prototxt", prototxt);
    return OpenEngine::open(engine("caffe"), write("net.caffemodel", weights), options);
  }
  Result<std::unique_ptr<OpenEngine>> open_tensorflow(const std::string& graph,
                                                      const Options& options = {}) {
    return OpenEngine::open(engine("tensorflow"), write("net.pb", graph), options);
  }
  Result<std::unique_ptr<OpenEngine>> open_darknet(const std::string& cfg,
                                                   const std::string& weights,
                                                   const Options& options = {}) {
    write("net.weights", weights);
    return OpenEngine::open(engine("darknet"), write("net.cfg", cfg), options);
  }
  template <class Opened>
  static std::vector<TestTensor> invoke(const Opened& model, const std::vector<TestTensor>& in) {
    if (!model) {
      ADD_FAILURE() << model.error().message();
      return {};
    }
    auto out = (*model)->invoke(in);
    if (!out) ADD_FAILURE() << out.error().message();
    return out ? *std::move(out) : std::vector<TestTensor>{};
  }
  static Error get_error(const Result<std::unique_ptr<OpenEngine>>& model) {
    return model ? Error{.code = Code::INTERNAL, .what = "it opened"} : model.error();
  }

  TemporaryFolder folder_;
};

inline TestTensor floats(const std::vector<int64_t>& shape, const std::vector<float>& values) {
  return make_tensor<float>(WEIR_FLOAT32, shape, values);
}

// y = W x + b from three values to two.
inline const char* const kProduct =
    "name: \"product\"  # a comment\n"
    "input: \"data\"\ninput_shape { dim: 1 dim: 3 }\n"
    "layer { name: \"fc\" type: \"InnerProduct\" bottom: \"data\" top: \"fc\"\n"
    "  inner_product_param { num_output: 2 } }\n";
inline std::string product_weights() {
  return caffemodel(
      {caffe_layer("fc", "InnerProduct", {{{2, 3}, {1, 2, 3, 4, 5, 6}}, {{2}, {10, 20}}})});
}

}  // namespace weir::engine_test
