// Test fixture that writes scripts into its own folder and opens and invokes them through Weir's
// core.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/infer/model/model.hpp"
#include "core/infer/module/module_library.hpp"
#include "says.hpp"

namespace weir::python_test {

inline weir_tensor_info make_info(weir_type type, std::vector<int64_t> shape) {
  weir_tensor_info info{};
  info.type = type;
  info.rank = static_cast<uint32_t>(shape.size());
  std::copy(shape.begin(), shape.end(), info.shape);
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  return info;
}

// The values of one tensor, with one dimension or more.
struct Values {
  weir_tensor_info info{};
  std::vector<std::byte> bytes;

  template <class T>
  std::vector<T> as() const {
    std::vector<T> out(bytes.size() / sizeof(T));
    std::memcpy(out.data(), bytes.data(), out.size() * sizeof(T));
    return out;
  }
};
template <class T>
Values make_values(weir_type type, const std::vector<T>& values, std::vector<int64_t> shape = {}) {
  if (shape.empty()) shape = {static_cast<int64_t>(values.size())};
  Values out{make_info(type, shape), std::vector<std::byte>(values.size() * sizeof(T))};
  std::memcpy(out.bytes.data(), values.data(), out.bytes.size());
  return out;
}
inline Values floats(const std::vector<float>& values) {
  return make_values(WEIR_FLOAT32, values);
}

class Filter {
 public:
  static Result<Filter> open(const std::string& path, const std::string& custom = "") {
    static infer::ModuleLibrary library;
    const auto engine = library.engine("python3");
    if (!engine) return engine.error();
    infer::OpenOptions options;
    options.paths = {path};
    if (!custom.empty()) options.options = {{"custom", custom}};
    auto model = infer::Model::open(**engine, options);
    if (!model) return model.error();
    auto session = infer::Session::create(*model);
    if (!session) return session.error();
    Filter out;
    out.model_ = *model;
    out.session_ = *std::move(session);
    return out;
  }

  const infer::Model& model() const { return *model_; }
  infer::Session& session() { return *session_; }
  Result<std::vector<weir_tensor_info>> resolve(const std::vector<weir_tensor_info>& inputs) {
    return session_->resolve(inputs);
  }
  // `own`: the engine allocates the outputs.
  Result<std::vector<Values>> invoke(const std::vector<Values>& inputs, bool own = false) {
    std::vector<weir_tensor> in(inputs.size());
    std::vector<weir_tensor_info> infos;
    for (size_t i = 0; i < in.size(); ++i) {
      in[i].data = const_cast<std::byte*>(inputs[i].bytes.data());
      in[i].bytes = in[i].capacity = inputs[i].bytes.size();
      in[i].flags = WEIR_TENSOR_READONLY;
      in[i].info = inputs[i].info;
      infos.push_back(inputs[i].info);
    }
    const auto resolved = resolve(infos);
    if (!resolved) return resolved.error();
    std::vector<weir_tensor> out(resolved->size());
    std::vector<Values> made(resolved->size());
    for (size_t i = 0; i < out.size(); ++i) {
      made[i].info = out[i].info = (*resolved)[i];
      made[i].bytes.resize(count_bytes((*resolved)[i]));
      if (own) continue;
      out[i].data = made[i].bytes.data();
      out[i].bytes = out[i].capacity = made[i].bytes.size();
    }
    weir_frame from{}, to{};
    from.struct_size = to.struct_size = sizeof from;
    from.tensors = in.data();
    from.n_tensors = static_cast<uint32_t>(in.size());
    to.tensors = out.data();
    to.n_tensors = static_cast<uint32_t>(out.size());
    const auto filled = session_->invoke(from, to);
    places_.clear();
    for (size_t i = 0; own && i < out.size(); ++i) {
      places_.push_back(reinterpret_cast<uint64_t>(out[i].data));
      if (filled) {
        made[i].info = out[i].info;
        const auto* data = static_cast<const std::byte*>(out[i].data);
        made[i].bytes.assign(data, data + out[i].bytes);
      }
      if (out[i].release) out[i].release(out[i].owner);
    }
    if (!filled) return filled.error();
    return made;
  }
  // The addresses of the outputs of the last invoke that the engine allocated.
  const std::vector<uint64_t>& places() const { return places_; }
  std::string get_error(const std::vector<Values>& inputs) {
    const auto made = invoke(inputs);
    return made ? "" : made.error().message();
  }

 private:
  static size_t count_bytes(const weir_tensor_info& info) {
    constexpr size_t kBytes[WEIR_TYPE_END] = {4, 4, 2, 2, 1, 1, 8, 4, 8, 8, 2};
    size_t bytes = kBytes[info.type];
    for (uint32_t i = 0; i < info.rank; ++i) bytes *= static_cast<size_t>(info.shape[i]);
    return bytes;
  }
  std::shared_ptr<infer::Model> model_;
  std::unique_ptr<infer::Session> session_;
  std::vector<uint64_t> places_;
};

// Skipped where Python or NumPy is missing.
class Python3 : public testing::Test {
 protected:
  void SetUp() override {
    const auto opened =
        Filter::open(write("weir_probe", kHead + kSame + "  def invoke(s, a): return a\n"));
    if (!opened && opened.error().code == Code::ENGINE_NOT_INSTALLED)
      GTEST_SKIP() << opened.error().message();
    ASSERT_TRUE(opened) << opened.error().message();
  }
  ~Python3() override { std::filesystem::remove_all(folder_); }

  // Writes a script; use `folder` for scripts with the same name.
  std::string write(const std::string& name, const std::string& text,
                    const std::string& folder = ".") const {
    std::filesystem::create_directories(folder_ + "/" + folder);
    const std::string path = folder_ + "/" + folder + "/" + name + ".py";
    std::ofstream(path) << text;
    return path;
  }
  // A filter of a float32 vector of 4 whose invoke() has these lines.
  std::string invoking(const std::string& lines) const {
    std::string text = kHead + kFour + "  def invoke(self, input_array):\n";
    for (size_t at = 0; at < lines.size();) {
      const size_t end = std::min(lines.find('\n', at), lines.size());
      text += "    " + lines.substr(at, end - at) + "\n";
      at = end + 1;
    }
    static int number = 0;
    return write("weir_filter_" + std::to_string(++number), text);
  }
  static Filter opened(const std::string& path, const std::string& custom = "") {
    auto filter = Filter::open(path, custom);
    if (!filter) ADD_FAILURE() << filter.error().message();
    return filter ? *std::move(filter) : Filter();
  }
  static std::string open_error(const std::string& path, const std::string& custom = "") {
    const auto filter = Filter::open(path, custom);
    return filter ? "" : filter.error().message();
  }
  std::string invoke_error(const std::string& lines) const {
    return opened(invoking(lines)).get_error({floats({1, 2, 3, 4})});
  }

  // The first lines of scripts.
  inline static const std::string kHead =
      "import numpy as np\nfrom nnstreamer_python import TensorShape\n"
      "class CustomFilter(object):\n";
  inline static const std::string kSame =
      "  def setInputDim(self, input_dims):\n    return input_dims\n";
  inline static const std::string kFour =
      "  def getInputDim(self):\n    return [TensorShape([4], np.float32)]\n"
      "  def getOutputDim(self):\n    return [TensorShape([4], np.float32)]\n";

 private:
  static std::string new_folder() {
    std::string name = testing::TempDir() + "weir-python-XXXXXX";
    return mkdtemp(name.data());
  }
  const std::string folder_ = new_folder();
};

}  // namespace weir::python_test
