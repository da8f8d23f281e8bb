// A small host for tests of engine modules: loads the module, drives the C table, owns the memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "weir/abi.h"
#include "weir/result.hpp"

struct weir_error {
  weir::Error error;
};

namespace weir::engine_test {

// Loads the module file, which stays loaded, and returns its engine. On failure: null, with the
// reason on standard error.
const weir_engine* load_module(const char* path);
// Sets the engine that others find by this name; null: none.
void let_find(const std::string& name, const weir_engine* engine);
// Whether the host keeps the memory of frames (weir_frame_holder), and how many it keeps now.
void let_hold_frames(bool holds);
int held_frames();
// Returns the lines that the module logged since the last call.
std::vector<std::string> take_log();

// The peak resident memory of this process.
uint64_t peak_resident_bytes();

// The path in ../shared of the checkout, or in WEIR_DATA; "" when the file does not exist.
std::string shared_file(const std::string& relative);
// The sorted paths of all files under `relative` with this extension.
std::vector<std::string> shared_files(const std::string& relative, const std::string& extension);
std::vector<std::byte> read_bytes(const std::string& path);
// The first channel of a PNG, decoded by Python; empty on failure.
std::vector<float> read_png(const std::string& path);
// The rows of a CSV file of numbers.
std::vector<std::vector<float>> read_csv(const std::string& path);

// A tensor of a model as ../shared/MANIFEST.md lists it; open dimensions have names instead of
// sizes.
struct ListedTensor {
  std::string name, type;
  std::vector<std::string> shape;
  // "float32[1, 224]", with these sizes for the names and -1 for other names.
  std::string text(const std::map<std::string, int64_t>& sizes = {}) const;
};
struct ListedModel {
  std::vector<ListedTensor> inputs, outputs;
};
// The model `relative` of ../shared; both lists are empty when it is not listed.
ListedModel listed_model(const std::string& relative);

// A temporary folder, deleted with the object.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string path(const std::string& name) const { return path_ + "/" + name; }
  std::string write(const std::string& name, const std::vector<std::byte>& bytes) const;

 private:
  std::string path_;
};

// One tensor with its own memory.
struct TestTensor {
  weir_tensor_info info{};
  std::vector<std::byte> bytes;

  template <class T>
  std::vector<T> values() const {
    const auto* begin = reinterpret_cast<const T*>(bytes.data());
    return std::vector<T>(begin, begin + bytes.size() / sizeof(T));
  }
};
TestTensor make_tensor(uint32_t type, const std::vector<int64_t>& shape, const void* data = nullptr,
                       size_t bytes = 0);
template <class T>
TestTensor make_tensor(uint32_t type, const std::vector<int64_t>& shape,
                       const std::vector<T>& values) {
  return make_tensor(type, shape, values.data(), values.size() * sizeof(T));
}
std::vector<int64_t> to_shape(const weir_tensor_info& info);
std::string to_string(const weir_tensor_info& info);  // "float32[1, 224, 224, 3]"; -1 stays -1

// A model with one session, used only through the C table.
class OpenEngine {
 public:
  using Options = std::vector<std::pair<std::string, std::string>>;
  static Result<std::unique_ptr<OpenEngine>> open(const weir_engine& engine,
                                                  const std::string& path,
                                                  const Options& options = {}, int threads = 0);
  ~OpenEngine();
  OpenEngine(const OpenEngine&) = delete;
  OpenEngine& operator=(const OpenEngine&) = delete;

  const weir_model_info& info() const { return info_; }
  std::vector<weir_tensor_info> inputs() const {
    return {info_.inputs, info_.inputs + info_.n_inputs};
  }
  std::vector<weir_tensor_info> outputs() const {
    return {info_.outputs, info_.outputs + info_.n_outputs};
  }
  Result<std::vector<weir_tensor_info>> resolve(const std::vector<weir_tensor_info>& inputs);
  // Resolves the outputs first; the engine allocates those whose shape stays open.
  Result<std::vector<TestTensor>> invoke(const std::vector<TestTensor>& inputs);
  // Invokes with frames that the test made, unchanged.
  Status invoke(const weir_frame& in, weir_frame& out);
  Status control(int op);
  // How many outputs of the last invoke the engine allocated.
  size_t engine_allocated() const { return engine_allocated_; }
  // How the engine runs the model; all 0 when it does not report this.
  weir_execution execution() const {
    weir_execution out{sizeof out, 0, 0};
    const auto* calls = static_cast<const weir_execution_calls*>(engine_.extension(WEIR_EXECUTION));
    return calls && calls->describe(model_, &out) == 0 ? out : weir_execution{};
  }

 private:
  explicit OpenEngine(const weir_engine& engine) : engine_(engine) {}
  const weir_engine& engine_;
  weir_model* model_ = nullptr;
  weir_session* session_ = nullptr;
  weir_model_info info_{};
  size_t engine_allocated_ = 0;
};

// Frames of one float32 tensor each, in the test's memory. The frames point into this object, so it
// must not move.
struct OneToOne {
  OneToOne(const std::vector<int64_t>& shape, std::span<float> x);  // without memory for the output
  OneToOne(const std::vector<int64_t>& shape, std::span<float> x,
           const std::vector<int64_t>& out_shape, std::span<float> y);
  OneToOne(const OneToOne&) = delete;
  OneToOne& operator=(const OneToOne&) = delete;

  Status through(OpenEngine& model) { return model.invoke(in_frame, out_frame); }
  Code get_code(OpenEngine& model);  // INTERNAL on success

  weir_tensor in{}, out{};
  weir_frame in_frame{}, out_frame{};
};

// Zeros in the model's own shapes; open dimensions become 1.
std::vector<TestTensor> zero_inputs(const OpenEngine& model);
size_t argmax(const std::vector<float>& values);

}  // namespace weir::engine_test
