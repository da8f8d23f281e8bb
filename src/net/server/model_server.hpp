// ModelServer: the models that are served on one address, and the services of the Open Inference
// Protocol and of gRPC's health checking for them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "net/server/listener.hpp"
#include "net/server/model_list.hpp"

namespace weir::net {

// Thread-safe.
class ModelServer {
 public:
  // The server of this address: a new one, or the one that listens there already in this process
  // with the same options. It listens until its last user has gone. Errors: those of
  // Listener::open(); OPTION_VALUE when the options differ.
  static Result<std::shared_ptr<ModelServer>> share(const ListenOptions& options);

  // Adds a user to the server that listens on an address in this process, "127.0.0.1:8001" or
  // "unix:PATH"; null when there is none.
  static std::shared_ptr<ModelServer> listening_on(const std::string& address);

  explicit ModelServer(const ListenOptions& options) : options_(options) {}
  ~ModelServer() { models_->close(); }
  ModelServer(const ModelServer&) = delete;
  ModelServer& operator=(const ModelServer&) = delete;

  // OPTION_VALUE when a model of this name and version is served here.
  Status add(const std::shared_ptr<ServedModel>& model);
  void remove(const ServedModel& model) { models_->remove(model); }
  uint32_t port() const noexcept { return listener_->port(); }
  // Calls refused for all models: tokens, certificates, limits of connections.
  uint64_t refused() const noexcept { return listener_->refused(); }

  // Public for tests: what a call is answered with.
  void handle(const std::shared_ptr<Call>& call);

 private:
  std::shared_ptr<ServedModel> find(const ModelRequest& wanted, const std::shared_ptr<Call>& call);
  void server_metadata(const std::shared_ptr<Call>& call);
  void model_ready(const std::shared_ptr<Call>& call);
  void model_metadata(const std::shared_ptr<Call>& call);
  void model_infer(const std::shared_ptr<Call>& call);
  void model_statistics(const std::shared_ptr<Call>& call);
  void server_ready(const std::shared_ptr<Call>& call);
  void server_live(const std::shared_ptr<Call>& call);
  void health(const std::shared_ptr<Call>& call);
  void watch_health(const std::shared_ptr<Call>& call);
  // Returns false when it is not enabled, and the call has ended.
  bool can_control(const std::shared_ptr<Call>& call) const;
  void set_loaded(const std::shared_ptr<Call>& call, bool loaded);
  void repository_index(const std::shared_ptr<Call>& call);
  void load(const std::shared_ptr<Call>& call) { set_loaded(call, true); }
  void unload(const std::shared_ptr<Call>& call) { set_loaded(call, false); }
  void reflection(const std::shared_ptr<Call>& call);

  const ListenOptions options_;
  const std::shared_ptr<ModelList> models_ = std::make_shared<ModelList>();
  std::unique_ptr<Listener> listener_;  // last: it ends before what its calls use
};

}  // namespace weir::net
