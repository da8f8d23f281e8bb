// SharedModel: an open model that several filters use and that is replaced for all of them at once.
//
//   auto use = ModelLease::create(shared, 1);      // one filter's sessions
//   use->resolve(inputs);                        // the stream's shapes
//   auto frame = use->begin();                   // reopens a suspended model
//   (*frame).session().invoke(in, out);          // the same model for the whole frame
//
// Lock order: SharedModel::opening_, SharedModel::mutex_, ModelLease::mutex_, Sessions::mutex_.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <typeindex>
#include <vector>

#include "core/infer/model/model.hpp"
#include "core/tensor/model_tensor.hpp"

namespace weir::infer {

// Identifies a model: models with the same source are the same.
struct ModelConfig {
  const weir_engine* engine = nullptr;
  OpenOptions options;
  // Compares engine, resolved file paths, options in any order and accelerator. Ignores the number
  // of threads, which the first user chooses.
  bool same_as(const ModelConfig& other) const;
  std::string to_string() const;  // "model.tflite, framework=tensorflow-lite"
};

class SharedModel;

// The sessions of a model used by one filter (or one batch of filters). Thread-safe.
class ModelLease {
  friend class SharedModel;
  // One user's sessions of one model. Immutable except for the number of frames that hold it.
  class Sessions {
   public:
    static Result<std::shared_ptr<Sessions>> create(std::shared_ptr<Model> model, size_t count);
    const Model& model() const noexcept { return *model_; }
    const std::vector<std::shared_ptr<Session>>& all() const noexcept { return all_; }
    uint64_t number() const noexcept { return number_; }  // unique in the process

    void hold();
    void release();
    bool held() const;
    // Returns false if frames still hold it after `limit`.
    bool wait_until_free(std::chrono::milliseconds limit) const;

   private:
    explicit Sessions(std::shared_ptr<Model> model);
    std::shared_ptr<Model> model_;
    const uint64_t number_;
    std::vector<std::shared_ptr<Session>> all_;
    mutable std::mutex mutex_;  // guards holds_
    mutable std::condition_variable free_;
    int holds_ = 0;
  };

 public:
  // Others: the lease of a batch, whose filters have leases of their own.
  enum class For { Itself, Others };
  // `sessions`: the number of concurrent frames; 0 = none, the lease only keeps the model open.
  static Result<std::unique_ptr<ModelLease>> create(const std::shared_ptr<SharedModel>& shared,
                                                    size_t sessions, For user = For::Itself);
  ~ModelLease();  // no Frame may be left
  ModelLease(const ModelLease&) = delete;
  ModelLease& operator=(const ModelLease&) = delete;

  // Keeps one model from the beginning to the end of a frame.
  class Frame {
   public:
    Frame(Frame&& other) noexcept : set_(std::move(other.set_)) {}
    Frame& operator=(Frame&&) = delete;
    ~Frame() {
      if (set_) set_->release();
    }
    const Model& model() const noexcept { return set_->model(); }
    // Changes when the sessions are replaced.
    uint64_t sessions_number() const noexcept { return set_->number(); }
    // `worker` counts from 0; workers share sessions if the engine allows fewer.
    Session& session(size_t worker = 0) const noexcept {
      return *set_->all()[worker % set_->all().size()];
    }

   private:
    friend class ModelLease;
    explicit Frame(std::shared_ptr<Sessions> set) : set_(std::move(set)) {}
    std::shared_ptr<Sessions> set_;
  };
  // Resumes or reopens a suspended model. Errors of the engine.
  Result<Frame> begin();

  // Session::resolve on all sessions. Precondition: no frame is in progress. Replacement models
  // must have the same outputs for these inputs.
  Result<std::vector<ModelTensor>> resolve(const std::vector<ModelTensor>& inputs);
  // The same on the session of one worker, within its frame.
  Result<std::vector<ModelTensor>> resolve(const Frame& frame, size_t worker,
                                           const std::vector<ModelTensor>& inputs);

  // Asks the engine to free memory. If it cannot, closes this lease's sessions, and the model
  // unless another lease needs it. Returns false while a frame is in progress.
  bool suspend();
  bool suspended() const;
  const std::shared_ptr<SharedModel>& shared() const noexcept { return shared_; }

 private:
  // The state to restore in replacement sessions.
  struct Shapes {
    uint64_t version = 0;  // of the members below
    bool resolved = false;
    std::vector<ModelTensor> inputs, outputs;
  };
  ModelLease(std::shared_ptr<SharedModel> shared, size_t sessions, For user)
      : shared_(std::move(shared)), sessions_(sessions), user_(user) {}
  static Result<std::shared_ptr<Sessions>> prepared(std::shared_ptr<Model> model, size_t sessions,
                                                    const Shapes& shapes, bool warm);
  static Status prepare(Session& session, const Shapes& shapes, bool warm);
  Status reopen();

  const std::shared_ptr<SharedModel> shared_;
  const size_t sessions_;
  const For user_;
  mutable std::mutex mutex_;       // guards the rest
  std::shared_ptr<Sessions> set_;  // null: closed by suspension
  bool asleep_ = false;            // the engine has suspended the sessions of set_
  bool closing_ = false;           // the previous set_ is about to be freed
  Shapes shapes_;
};

// Thread-safe.
class SharedModel : public std::enable_shared_from_this<SharedModel> {
 public:
  // Opens nothing. `key` is "" for a model that is not shared.
  SharedModel(std::string key, ModelConfig source)
      : key_(std::move(key)), source_(std::move(source)) {}

  // Opens the model unless it is open. Errors of the engine; MODEL_DIFFERS if the files contain
  // another model than when they were first opened.
  Status open();
  const std::string& key() const noexcept { return key_; }
  ModelConfig source() const;
  // The number of leases, except those that batches hold for others.
  size_t users() const;
  uint64_t reloads() const;
  // The current model; null while it is closed by suspension.
  std::shared_ptr<Model> model() const;

  // Opens the model of `source` beside the present one, creates, resolves and warms the sessions of
  // every user, then switches all users at once: frames that begin afterwards use the new model,
  // frames in progress keep the old one. The same model may be reopened. On an error nothing
  // changes: MODEL_DIFFERS if inputs or outputs differ, otherwise errors of the engine. Call it on
  // any thread, but not within a frame.
  Status replace(const ModelConfig& source);

  // An object attached to the model while it has users, one per type:
  //   shared->attached<Collector>([&] { return std::make_shared<Collector>(...); })
  template <class T, class Make>
  std::shared_ptr<T> attached(Make&& make) {
    std::lock_guard lock(attached_mutex_);
    auto& slot = attached_[std::type_index(typeid(T))];
    if (auto there = std::static_pointer_cast<T>(slot.lock())) return there;
    std::shared_ptr<T> made = make();
    slot = made;
    return made;
  }

 private:
  friend class ModelLease;
  Result<std::shared_ptr<Model>> ensure_open();  // opening_ is held
  Result<std::shared_ptr<Model>> open_candidate(const ModelConfig& source) const;
  Status check_same(const Model& candidate, const ModelConfig& source) const;
  ModelLease::Shapes shapes_for(const Model& candidate, const ModelLease::Shapes& shapes) const;
  struct Replacement;
  struct Requirement;
  std::optional<Requirement> next_requirement(std::vector<Replacement>* prepared,
                                              std::vector<std::unique_lock<std::mutex>>* locks);
  std::vector<std::shared_ptr<ModelLease::Sessions>> switch_sessions(
      std::vector<Replacement>* prepared);
  void remove(ModelLease* use);
  void close_if_unused();

  const std::string key_;
  std::mutex opening_;        // held while a model is opened or replaced
  mutable std::mutex mutex_;  // guards the rest except attached_
  ModelConfig source_;
  std::shared_ptr<Model> model_;  // null: closed
  std::vector<ModelTensor> inputs_, outputs_;
  bool known_ = false;  // inputs_ and outputs_ come from a model that was open
  std::vector<ModelLease*> uses_;
  uint64_t reloads_ = 0;
  std::mutex attached_mutex_;  // guards attached_; held while an object is made
  std::map<std::type_index, std::weak_ptr<void>> attached_;
};

}  // namespace weir::infer
