// SharedModel: an opened model that several filters use, replaced for all of them at once.
//
//   auto use = ModelUse::create(shared, 1);      // one filter's sessions
//   use->resolve(inputs);                        // the stream's shapes
//   auto frame = use->begin();                   // opens again what was suspended
//   (*frame).session().invoke(in, out);          // the same model for the whole frame
//
// Lock order: SharedModel::opening_, SharedModel::mutex_, ModelUse::mutex_, SessionSet::mutex_.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <typeindex>
#include <vector>

#include "core/infer/model_shapes.hpp"
#include "core/infer/session_pool.hpp"

namespace weir::infer {

// What is opened: two models with the same source are the same.
struct ModelSource {
  const weir_engine* engine = nullptr;
  OpenOptions options;
  // Same engine, files (by their resolved paths), options in any order, accelerator; how many
  // threads it is opened with is the first user's choice.
  bool same_as(const ModelSource& other) const;
  std::string to_string() const;  // "model.tflite, framework=tensorflow-lite"
};

// One user's sessions of one model. Immutable but for the count of frames that hold it.
class SessionSet {
 public:
  static Result<std::shared_ptr<SessionSet>> create(std::shared_ptr<SessionPool> pool,
                                                    size_t sessions);
  const SessionPool& pool() const noexcept { return *pool_; }
  const std::vector<std::shared_ptr<Session>>& sessions() const noexcept { return sessions_; }
  uint64_t number() const noexcept { return number_; }  // no two sets of the process have the same

  void hold();
  void release();
  bool held() const;
  // False when some frame held it longer.
  bool wait_until_free(std::chrono::milliseconds limit) const;

 private:
  explicit SessionSet(std::shared_ptr<SessionPool> pool);
  std::shared_ptr<SessionPool> pool_;  // outlives the sessions
  const uint64_t number_;
  std::vector<std::shared_ptr<Session>> sessions_;
  mutable std::mutex mutex_;  // guards holds_
  mutable std::condition_variable free_;
  int holds_ = 0;
};

class ModelUse;

// Thread-safe.
class SharedModel : public std::enable_shared_from_this<SharedModel> {
 public:
  // Nothing is opened yet. `key` "" for a model that only one filter uses.
  SharedModel(std::string key, ModelSource source)
      : key_(std::move(key)), source_(std::move(source)) {}

  // Opens the model unless it is open. What the engine says when it cannot; MODEL_DIFFERS when the
  // files have become another model since they were opened before.
  Status open();
  const std::string& key() const noexcept { return key_; }
  ModelSource source() const;
  // Uses that are there for themselves.
  size_t users() const;
  uint64_t reloads() const;
  // The model as it is now: null while it is closed by suspension.
  std::shared_ptr<Model> model() const;

  // Opens the model of `source` beside the present one, makes, resolves and warms the sessions of
  // every user, then puts them in place for all users at once: each frame that begins afterwards
  // has the new model, each that began before keeps the old one. The same model may be opened
  // again. On an error nothing has changed: MODEL_DIFFERS when inputs or outputs are not the same,
  // else what the engine says. Called from any thread but within a frame.
  Status replace(const ModelSource& source);

  // Something that lives beside the model as long as somebody holds it, one of each type:
  //   shared->attached<Gatherer>([&] { return std::make_shared<Gatherer>(...); })
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
  friend class ModelUse;
  Result<std::shared_ptr<SessionPool>> opened_pool();  // opening_ is held
  Result<std::shared_ptr<SessionPool>> open_candidate(const ModelSource& source) const;
  Status check_same(const Model& candidate, const ModelSource& source) const;
  void remove(ModelUse* use);
  void close_if_unused();

  const std::string key_;
  std::mutex opening_;        // held while a model is opened or replaced
  mutable std::mutex mutex_;  // guards the rest, but attached_
  ModelSource source_;
  std::shared_ptr<SessionPool> pool_;  // null: closed
  std::vector<ModelShape> inputs_, outputs_;
  bool known_ = false;  // inputs_ and outputs_ are those of a model that was open
  std::vector<ModelUse*> uses_;
  uint64_t reloads_ = 0;
  std::mutex attached_mutex_;  // guards attached_; held while something is made
  std::map<std::type_index, std::weak_ptr<void>> attached_;
};

// What one filter (or batch of filters) uses of a model. Thread-safe.
class ModelUse {
 public:
  // Batches work for filters that have uses of their own.
  enum class For { Itself, Others };
  // `sessions`: how many frames are worked on at a time; 0 = none, only the model is kept open.
  static Result<std::unique_ptr<ModelUse>> create(std::shared_ptr<SharedModel> shared,
                                                  size_t sessions, For user = For::Itself);
  ~ModelUse();  // after the last Frame is gone
  ModelUse(const ModelUse&) = delete;
  ModelUse& operator=(const ModelUse&) = delete;

  // The model of one frame, from its beginning to its end.
  class Frame {
   public:
    Frame(Frame&& other) noexcept : set_(std::move(other.set_)) {}
    Frame& operator=(Frame&&) = delete;
    ~Frame() {
      if (set_) set_->release();
    }
    const Model& model() const noexcept { return *set_->pool().model(); }
    // Another number: the sessions are other ones than those of an earlier frame.
    uint64_t sessions_number() const noexcept { return set_->number(); }
    // `worker` counts from 0; where the engine allows fewer sessions, workers share them.
    Session& session(size_t worker = 0) const noexcept {
      return *set_->sessions()[worker % set_->sessions().size()];
    }

   private:
    friend class ModelUse;
    explicit Frame(std::shared_ptr<SessionSet> set) : set_(std::move(set)) {}
    std::shared_ptr<SessionSet> set_;
  };
  // Resumes or opens the model again when it was suspended. What the engine says when it cannot.
  Result<Frame> begin();

  // Session::resolve on all sessions, while no frame is in work. Replacements must give the same
  // outputs for these inputs.
  Result<std::vector<ModelShape>> resolve(const std::vector<ModelShape>& inputs);
  // The same on the session of one worker, within its frame.
  Result<std::vector<ModelShape>> resolve(const Frame& frame, size_t worker,
                                          const std::vector<ModelShape>& inputs);

  // Asks the engine to free what it can; when it does not know how, this use's sessions are closed,
  // and the model when no other use needs it. False while a frame is in work.
  bool suspend();
  bool suspended() const;
  const std::shared_ptr<SharedModel>& shared() const noexcept { return shared_; }

 private:
  friend class SharedModel;
  // What sessions that take the place of others are made like.
  struct Shapes {
    uint64_t version = 0;  // of the two below
    bool resolved = false;
    std::vector<ModelShape> inputs, outputs;
  };
  ModelUse(std::shared_ptr<SharedModel> shared, size_t sessions, For user)
      : shared_(std::move(shared)), sessions_(sessions), user_(user) {}
  static Result<std::shared_ptr<SessionSet>> prepared(std::shared_ptr<SessionPool> pool,
                                                      size_t sessions, const Shapes& shapes,
                                                      bool warm);
  static Status prepare(Session& session, const Shapes& shapes, bool warm);
  Status reopen();

  const std::shared_ptr<SharedModel> shared_;
  const size_t sessions_;
  const For user_;
  mutable std::mutex mutex_;         // guards the rest
  std::shared_ptr<SessionSet> set_;  // null: closed by suspension
  bool asleep_ = false;              // the engine has suspended the sessions of set_
  bool closing_ = false;             // what was set_ is about to be freed
  Shapes shapes_;
};

}  // namespace weir::infer
