// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/model/shared_model.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>

#include "core/infer/model/declared_options.hpp"
#include "weir/join.hpp"

namespace weir::infer {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> resolved(const std::vector<std::string>& paths) {
  std::vector<std::string> out;
  for (const auto& path : paths) {
    std::error_code failed;
    const auto whole = fs::weakly_canonical(path, failed);
    out.push_back(failed ? path : whole.string());
  }
  return out;
}

std::vector<std::pair<std::string, std::string>> sorted(
    std::vector<std::pair<std::string, std::string>> options) {
  std::sort(options.begin(), options.end());
  return options;
}

// How long a replacement waits for frames in progress, so that the old model is closed on its
// thread and not on a streaming thread.
constexpr std::chrono::milliseconds kDrainTimeout{1000};

// What a model leaves open, such as a TorchScript, is as `known` has it: the frames of the stream
// decide it, and a session of the model is prepared for them before it replaces another.
std::vector<ModelTensor> completed(std::vector<ModelTensor> tensors,
                                   const std::vector<ModelTensor>& known) {
  for (size_t i = 0; i < std::min(tensors.size(), known.size()); ++i) {
    ModelTensor& tensor = tensors[i];
    if (tensor.type == ElementType::End) tensor.type = known[i].type;
    if (!tensor.rank_known) tensor.shape = known[i].shape;
    if (!tensor.rank_known) tensor.rank_known = known[i].rank_known;
    if (tensor.shape.size() != known[i].shape.size()) continue;
    for (size_t d = 0; d < tensor.shape.size(); ++d)
      if (tensor.shape[d] < 0) tensor.shape[d] = known[i].shape[d];
  }
  return tensors;
}

bool all_fixed(const std::vector<ModelTensor>& tensors) {
  return std::all_of(tensors.begin(), tensors.end(), [](const auto& t) { return t.fixed(); });
}

}  // namespace

bool ModelConfig::same_as(const ModelConfig& other) const {
  return engine && engine == other.engine && options.accelerator == other.options.accelerator &&
         sorted(get_identity(*engine, options)) == sorted(get_identity(*engine, other.options)) &&
         resolved(options.paths) == resolved(other.options.paths);
}

std::string ModelConfig::to_string() const {
  std::string out = "model=" + join(options.paths, ",");
  if (engine && engine->name) out += std::string(" framework=") + engine->name;
  for (const auto& [key, value] : options.options)
    out.append(out.find(" custom=") == std::string::npos ? " custom=" : ",")
        .append(key)
        .append(":")
        .append(value);
  if (!options.accelerator.empty()) out += " accelerator=" + options.accelerator;
  return out;
}

ModelConfig SharedModel::source() const {
  std::lock_guard lock(mutex_);
  return source_;
}

size_t SharedModel::users() const {
  std::lock_guard lock(mutex_);
  return static_cast<size_t>(std::count_if(uses_.begin(), uses_.end(), [](const ModelLease* use) {
    return use->user_ == ModelLease::For::Itself;
  }));
}

uint64_t SharedModel::reloads() const {
  std::lock_guard lock(mutex_);
  return reloads_;
}

std::shared_ptr<Model> SharedModel::model() const {
  std::lock_guard lock(mutex_);
  return model_;
}

Status SharedModel::open() {
  std::lock_guard opening(opening_);
  const auto model = ensure_open();
  return model ? ok() : Status(model.error());
}

Result<std::shared_ptr<Model>> SharedModel::ensure_open() {
  ModelConfig source;
  {
    std::lock_guard lock(mutex_);
    if (model_) return model_;
    source = source_;
  }
  auto model = open_candidate(source);
  if (!model) return model.error();
  std::lock_guard lock(mutex_);
  inputs_ = model_tensors((*model)->inputs());
  outputs_ = model_tensors((*model)->outputs());
  known_ = true;
  model_ = *model;
  return model;
}

Result<std::shared_ptr<Model>> SharedModel::open_candidate(const ModelConfig& source) const {
  auto model = Model::open(*source.engine, source.options);
  if (!model) return model.error();
  if (auto status = check_same(**model, source); !status) return status.error();
  return model;
}

Status SharedModel::check_same(const Model& candidate, const ModelConfig& source) const {
  const auto inputs = model_tensors(candidate.inputs()),
             outputs = model_tensors(candidate.outputs());
  std::lock_guard lock(mutex_);
  if (!known_) return ok();
  auto difference = first_difference(completed(inputs, inputs_), inputs_, "input");
  if (difference.empty())
    difference = first_difference(completed(outputs, outputs_), outputs_, "output");
  if (difference.empty()) return ok();
  const auto both = [](const auto& in, const auto& out) {
    return "in " + list_tensors(in) + "; out " + list_tensors(out);
  };
  return Error{
      .code = Code::MODEL_DIFFERS,
      .what = "the new model cannot replace the one that runs",
      .offered = join(source.options.paths, ",") + ": " + both(inputs, outputs),
      .needed = join(source_.options.paths, ",") + ": " + both(inputs_, outputs_),
      .difference = difference,
      .fix =
          "use a model with the same inputs and outputs, or set it while the element is stopped"};
}

// Sessions of the new model for a lease of the old one.
struct SharedModel::Replacement {
  ModelLease* use;   // compared only: may be dangling
  uint64_t version;  // of the shapes that they are prepared for
  std::shared_ptr<ModelLease::Sessions> set;
};

struct SharedModel::Requirement {
  ModelLease* use;
  size_t sessions;
  ModelLease::Shapes shapes;
};

// The first lease that needs other sessions than those in `prepared`; outdated ones are removed.
// mutex_ is held. `locks` gets the locks of the leases up to that one, of all if there is none.
std::optional<SharedModel::Requirement> SharedModel::next_requirement(
    std::vector<Replacement>* prepared, std::vector<std::unique_lock<std::mutex>>* locks) {
  for (ModelLease* use : uses_) {
    locks->emplace_back(use->mutex_);
    if (!use->set_ || use->asleep_) continue;
    const auto found = std::find_if(prepared->begin(), prepared->end(),
                                    [use](const auto& p) { return p.use == use; });
    if (found != prepared->end() && found->version == use->shapes_.version) continue;
    if (found != prepared->end()) prepared->erase(found);
    return Requirement{use, use->sessions_, use->shapes_};
  }
  return std::nullopt;
}

// Gives each lease its new sessions and returns the old ones. mutex_ and all leases are locked.
std::vector<std::shared_ptr<ModelLease::Sessions>> SharedModel::switch_sessions(
    std::vector<Replacement>* prepared) {
  std::vector<std::shared_ptr<ModelLease::Sessions>> old_sets;
  for (ModelLease* use : uses_) {
    old_sets.push_back(std::move(use->set_));
    use->set_ = nullptr;  // suspended users open the new model when they resume
    use->asleep_ = false;
    for (auto& p : *prepared)
      if (p.use == use) use->set_ = std::move(p.set);
  }
  return old_sets;
}

// The shapes to prepare a session of `candidate` for: a model with fixed ones is not resolved, and
// one that leaves them open needs them.
ModelLease::Shapes SharedModel::shapes_for(const Model& candidate,
                                           const ModelLease::Shapes& shapes) const {
  if (shapes.resolved || all_fixed(model_tensors(candidate.inputs()))) return shapes;
  std::lock_guard lock(mutex_);
  if (!all_fixed(inputs_) || !all_fixed(outputs_)) return shapes;
  return {shapes.version, true, inputs_, outputs_};
}

Status SharedModel::replace(const ModelConfig& source) {
  std::lock_guard opening(opening_);
  auto model = open_candidate(source);
  if (!model) return model.error();
  std::vector<Replacement> prepared;
  std::vector<std::shared_ptr<ModelLease::Sessions>> old_sets;
  std::shared_ptr<Model> old_model;
  // Users may come, go and change their shapes while sessions are created for the others.
  for (;;) {
    std::unique_lock lock(mutex_);
    std::vector<std::unique_lock<std::mutex>> leases;
    const auto required = next_requirement(&prepared, &leases);
    if (!required) {
      old_sets = switch_sessions(&prepared);
      old_model = std::exchange(model_, *model);
      source_ = source;
      ++reloads_;
      break;
    }
    leases.clear();
    lock.unlock();
    auto set = ModelLease::prepared(*model, required->sessions,
                                    shapes_for(**model, required->shapes), true);
    if (!set) return set.error();
    prepared.push_back({required->use, required->shapes.version, *std::move(set)});
  }
  for (const auto& set : old_sets)
    if (set) set->wait_until_free(kDrainTimeout);
  close_if_unused();
  return ok();
}

void SharedModel::remove(ModelLease* use) {
  {
    std::lock_guard lock(mutex_);
    std::erase(uses_, use);
  }
  close_if_unused();
}

// Closes the model if no lease has sessions; `closing` outlives the lock.
void SharedModel::close_if_unused() {
  std::shared_ptr<Model> closing;
  std::lock_guard lock(mutex_);
  for (const ModelLease* use : uses_) {
    std::lock_guard user(use->mutex_);
    if (use->set_) return;
  }
  closing.swap(model_);
}

}  // namespace weir::infer
