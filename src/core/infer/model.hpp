// Model and Session: an opened model of any engine, and one invocation context of it.
#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::infer {

struct OpenOptions {
  std::vector<std::string> paths;
  std::vector<std::pair<std::string, std::string>> options;  // key, value; the engine's own
  std::string accelerator;
  int threads = 0;  // 0 = the engine's own choice
};

class Model {
 public:
  // MODEL_NOT_FOUND when a path is no regular file; else what the engine says.
  static Result<std::shared_ptr<Model>> open(const weir_engine& engine, const OpenOptions& options);
  ~Model();
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;

  const weir_engine& engine() const noexcept { return engine_; }
  weir_model* handle() const noexcept { return handle_; }
  const weir_model_info& info() const noexcept { return info_; }
  // Live as long as the model.
  const std::vector<weir_tensor_info>& inputs() const noexcept { return inputs_; }
  const std::vector<weir_tensor_info>& outputs() const noexcept { return outputs_; }

 private:
  Model(const weir_engine& engine, weir_model* handle) : engine_(engine), handle_(handle) {}
  Status read_info();

  const weir_engine& engine_;
  weir_model* handle_;
  weir_model_info info_{};
  std::vector<weir_tensor_info> inputs_, outputs_;
};

class Session {
 public:
  static Result<std::unique_ptr<Session>> create(std::shared_ptr<Model> model);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  const Model& model() const noexcept { return *model_; }
  // The outputs' shapes for these inputs; what stays unknown is -1.
  Result<std::vector<weir_tensor_info>> resolve(const std::vector<weir_tensor_info>& inputs);
  // true: the frame is filled; false: the engine drops it.
  Result<bool> invoke(const weir_frame& in, weir_frame& out);

 private:
  Session(std::shared_ptr<Model> model, weir_session* handle)
      : model_(std::move(model)), handle_(handle) {}
  std::shared_ptr<Model> model_;
  weir_session* handle_;
};

}  // namespace weir::infer
