// Model and Session: an open model of any engine, and one of its invocation contexts.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/infer/module/async_request.hpp"
#include "core/infer/queue/invoke_end.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::infer {

struct OpenOptions {
  std::vector<std::string> paths;
  std::vector<std::pair<std::string, std::string>> options;  // key and value; the engine's own
  // The properties input, inputtype, inputname, output... by name; passed to engines whose
  // options_json lists them.
  std::vector<std::pair<std::string, std::string>> declared;
  std::string accelerator;
  int threads = 0;                           // 0 = the engine's own choice
  std::shared_ptr<const void> host_context;  // weir_open::host_ctx; kept while the engine opens
};

class Session;

class Model : public std::enable_shared_from_this<Model> {
 public:
  // MODEL_NOT_FOUND if a path is not a regular file; otherwise errors of the engine.
  static Result<std::shared_ptr<Model>> open(const weir_engine& engine, const OpenOptions& options);
  ~Model();
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;

  const weir_engine& engine() const noexcept { return engine_; }
  weir_model* handle() const noexcept { return handle_; }
  const weir_model_info& info() const noexcept { return info_; }
  // Valid as long as the model.
  const std::vector<weir_tensor_info>& inputs() const noexcept { return inputs_; }
  const std::vector<weir_tensor_info>& outputs() const noexcept { return outputs_; }
  // The calls of an engine whose models are on servers; otherwise null.
  const weir_engine_servers* servers() const noexcept { return servers_; }
  // How the engine currently runs the model; nullopt if it does not report that. Any thread.
  std::optional<weir_execution> execution() const;

  // Any thread: a new session, or at the engine's limit (max_sessions) the one with the fewest
  // users, whose calls are serialised unless several threads may invoke a session
  // (WEIR_MODEL_THREAD_SAFE).
  Result<std::shared_ptr<Session>> shared_session();
  // Any thread: a new session; null at the limit.
  Result<std::shared_ptr<Session>> own_session();
  // Opens the same model again, for sessions beyond the limit of this one.
  Result<std::shared_ptr<Model>> open_again() const { return open(engine_, options_); }

 private:
  Model(const weir_engine& engine, weir_model* handle, OpenOptions options);
  Status read_info();
  Result<std::shared_ptr<Session>> make_session();  // sessions_mutex_ is held; null at the limit

  const weir_engine& engine_;
  weir_model* handle_;
  const weir_engine_servers* const servers_;
  weir_model_info info_{};
  std::vector<weir_tensor_info> inputs_, outputs_;
  const OpenOptions options_;
  std::mutex sessions_mutex_;                     // guards sessions_
  std::vector<std::weak_ptr<Session>> sessions_;  // made by shared_session() and own_session()
};

class Session {
 public:
  // Sessions with the same `turn` are serialised; null: used by one thread at a time.
  static Result<std::unique_ptr<Session>> create(std::shared_ptr<Model> model,
                                                 const std::shared_ptr<std::mutex>& turn = nullptr);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  const Model& model() const noexcept { return *model_; }
  // The outputs' shapes for these inputs, -1 = unknown. Also the only source of the number of
  // outputs for a model that describes none.
  Result<std::vector<weir_tensor_info>> resolve(const std::vector<weir_tensor_info>& inputs);
  // True: the frame is filled; false: the engine drops it. `end` may be null.
  Result<bool> invoke(const weir_frame& in, weir_frame& out, InvokeEnd* end = nullptr);
  // MODEL_UNSUPPORTED if the engine has no control; otherwise its result.
  Status control(weir_control op);
  // True if the engine has submit() and the model supports it.
  bool is_asynchronous() const noexcept;
  // Submits a frame. Returns false between abandon() and Requests::resume(); `receiver` is then not
  // called. Precondition: is_asynchronous(), and the caller has waited for a free slot.
  Result<bool> submit(const weir_frame& in, const std::shared_ptr<RequestReceiver>& receiver);
  // Abandons and cancels all requests in flight. Returns the number of receivers that are not
  // called when their request ends.
  size_t abandon();
  // For asynchronous engines (async_request.hpp).
  Requests& requests() noexcept { return requests_; }
  weir_session* handle() const noexcept { return handle_; }

 private:
  Session(std::shared_ptr<Model> model, weir_session* handle, std::shared_ptr<std::mutex> turn)
      : model_(std::move(model)),
        handle_(handle),
        turn_(std::move(turn)),
        requests_(std::max<size_t>(model_->info().max_in_flight, 1)) {}
  void cancel(weir_request* request) const;
  std::unique_lock<std::mutex> take_turn() const {
    return turn_ ? std::unique_lock(*turn_) : std::unique_lock<std::mutex>();
  }

  std::shared_ptr<Model> model_;
  weir_session* handle_;
  std::shared_ptr<std::mutex> turn_;  // held while the engine uses this session; may be null
  Requests requests_;
};

}  // namespace weir::infer
