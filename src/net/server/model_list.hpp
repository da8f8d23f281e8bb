// ModelList: the models of one address, and who watches their health.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "net/server/served_model.hpp"

namespace weir::net {

// The states of gRPC's health service, by its numbers.
enum class Health { Serving = 1, NotServing = 2, Unknown = 3 };

// Thread-safe.
class ModelList : public std::enable_shared_from_this<ModelList> {
 public:
  using Models = std::vector<std::shared_ptr<ServedModel>>;
  // OPTION_VALUE when a model of this name and version is here; `address` is for its text.
  Status add(const std::shared_ptr<ServedModel>& model, const std::string& address);
  // Its name stays known: see was_here().
  void remove(const ServedModel& model);
  Models all() const;
  // Returns null when there is none; a request without a version fits any.
  std::shared_ptr<ServedModel> find(const ModelRequest& wanted) const;
  // Whether a model that is not here now was here before, and may come back.
  bool was_here(const ModelRequest& wanted) const;
  // All that are here, and those that may come back.
  std::vector<IndexedModel> index() const;
  // "a version 1, b version 1".
  std::string names() const;

  // Returns the health of a service: "" and the protocol's name are all models, any other name is
  // that of a model. NotServing also for a model that was removed, and for "" without any model.
  Health health(const std::string& service) const;
  // Sends the health of a service, now and when it changes, until the call ends.
  void watch(std::shared_ptr<Call> call, const std::string& service);
  // Ends all watching, which has NOT_SERVING as its last message.
  void close();

 private:
  struct Watcher {
    std::shared_ptr<Call> call;
    std::string service;
    Health sent;
  };
  bool has_version_locked(const std::string& name) const;
  Health health_locked(const std::string& service) const;
  void update();

  mutable std::mutex mutex_;  // guards the rest
  Models models_;
  std::vector<ModelRequest> gone_;
  std::vector<Watcher> watchers_;
  bool closed_ = false;
};

}  // namespace weir::net
