// Implements the engine table and the policy after the end of a process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/isolated_engine.hpp"

#include <atomic>
#include <exception>
#include <new>
#include <string_view>

#include "core/custom/process_bound.hpp"
#include "core/infer/module/host.hpp"
#include "core/isolate/crash_file.hpp"
#include "core/isolate/supervisor.hpp"
#include "weir/abi.h"

namespace weir::isolate {
namespace {

constexpr uint64_t kMaxFilesKept = 16;

Error other_model() {
  return Error{.code = Code::MODEL_DIFFERS,
               .what = "the model's tensors have changed since it was opened",
               .offered = "another worker process of the same model",
               .needed = "unchanged model files"};
}

Error cancelled() {
  return Error{.code = Code::CANCELLED, .what = "the element that uses the model was stopped"};
}

struct IsolatedModel {
  Isolation isolation;
  WorkerSettings settings;
  std::unique_ptr<Supervisor> first;  // until a session takes it
  std::shared_ptr<const WorkerModelInfo> facts;
  std::shared_ptr<SharedArena> arena;
  std::atomic<uint32_t> threads{0}, spins{0};  // of the engine in the process; any thread

  Result<std::unique_ptr<Supervisor>> supervisor() {
    if (first) return std::move(first);
    auto made = Supervisor::start(settings, isolation.on_crash, isolation.monitor);
    if (made && facts && !same_tensors(*facts, *(*made)->facts())) return other_model();
    return made;
  }
};

class IsolatedSession {
 public:
  IsolatedSession(IsolatedModel* model, std::unique_ptr<Supervisor> supervisor)
      : model_(*model), supervisor_(std::move(supervisor)) {}

  Status resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out) {
    return with_worker([&](Worker& worker) {
      auto status = worker.resolve(in, out);
      model_.threads = worker.execution().threads;
      model_.spins = worker.execution().spins;
      return status;
    });
  }
  Status control(int op, const weir_option* option) {
    auto status = with_worker([&](Worker& worker) { return worker.control(op, option); });
    if (status && option) supervisor_->remember(op, *option);
    return status;
  }
  Result<int> invoke(const weir_frame& in, weir_frame& out);

 private:
  template <class Call>
  Status with_worker(Call&& call);
  Result<int> lose_frame(const Error& error);
  Error ended(Error error, const weir_frame* frame);
  Error no_worker() const;

  IsolatedModel& model_;  // outlives its sessions
  std::unique_ptr<Supervisor> supervisor_;
  Error last_end_;
};

Error IsolatedSession::no_worker() const {
  return Error{.code = Code::WORKER_ENDED,
               .what = "the model no longer has a worker process",
               .offered = last_end_.what,
               .needed = "on-crash=restart to continue with the next frames",
               .fix = "on-crash=restart"};
}

// Counts the end, saves the frame that caused it, and applies the policy.
Error IsolatedSession::ended(Error error, const weir_frame* frame) {
  Monitor& monitor = *model_.isolation.monitor;
  monitor.add(error.code == Code::WORKER_TIMEOUT ? &MonitorCounts::timed_out
                                                 : &MonitorCounts::ended);
  const std::string& folder = model_.isolation.crash_folder;
  if (frame && !folder.empty() && monitor.counts().frames_saved < kMaxFilesKept) {
    const auto file = save_frame(folder, *frame);
    if (file) {
      monitor.add(&MonitorCounts::frames_saved);
      error.fix = file->line(model_.isolation.repeat);
    } else {
      error.difference = file.error().what + ": " + file.error().offered;
    }
  }
  last_end_ = error;
  supervisor_->ended();
  monitor.report(error);
  return error;
}

Result<int> IsolatedSession::lose_frame(const Error& error) {
  if (model_.isolation.on_crash == OnCrash::Error) return error;
  model_.isolation.monitor->add(&MonitorCounts::frames_lost);
  return kFrameLost;
}

template <class Call>
Status IsolatedSession::with_worker(Call&& call) {
  if (model_.isolation.monitor->stopped()) return cancelled();
  Worker* worker = supervisor_->wait();
  if (worker && worker->ended_idle()) {
    ended(worker->idle_end(), nullptr);
    worker = supervisor_->wait();
  }
  if (!worker) return model_.isolation.monitor->stopped() ? cancelled() : no_worker();
  Status status = call(*worker);
  if (!status && !worker->alive() && status.error().code != Code::CANCELLED)
    return ended(status.error(), nullptr);
  return status;
}

Result<int> IsolatedSession::invoke(const weir_frame& in, weir_frame& out) {
  if (model_.isolation.monitor->stopped()) return cancelled();
  const bool waits = model_.isolation.on_crash == OnCrash::Wait;
  Worker* worker = waits ? supervisor_->wait() : supervisor_->ready();
  if (worker && worker->ended_idle()) {
    const Error error = ended(worker->idle_end(), nullptr);
    if (!waits) return lose_frame(error);
    worker = supervisor_->wait();
  }
  if (!worker && model_.isolation.monitor->stopped()) return cancelled();
  if (!worker) return lose_frame(no_worker());
  uint64_t copied = 0;
  auto result = worker->invoke(in, out, *model_.arena, &copied);
  model_.isolation.monitor->add(&MonitorCounts::bytes_copied, copied);
  if (result || worker->alive() || result.error().code == Code::CANCELLED) return result;
  return lose_frame(ended(result.error(), &in));
}

int give(weir_error* to, const Error& error) {
  if (to) *to = weir_error{error, true};
  return -static_cast<int>(error.code);
}

// No exception may leave the table.
template <class Body>
int guarded(weir_error* error, Body&& body) noexcept {
  try {
    return body();
  } catch (const std::bad_alloc&) {
    return give(error, {.code = Code::OUT_OF_MEMORY, .what = "no memory for a worker process"});
  } catch (const std::exception& e) {
    return give(error, {.code = Code::INTERNAL, .what = e.what()});
  }
}

IsolatedModel& to_model(weir_model* handle) {
  return *reinterpret_cast<IsolatedModel*>(handle);
}
IsolatedSession& to_session(weir_session* handle) {
  return *reinterpret_cast<IsolatedSession*>(handle);
}

OpenCall make_call(const weir_open& request, const std::string& engine) {
  OpenCall call;
  call.engine = engine;
  call.paths.assign(request.paths, request.paths + request.n_models);
  for (uint32_t i = 0; i < request.n_options; ++i)
    call.options.emplace_back(request.options[i].key, request.options[i].value);
  call.accelerator = request.accelerator ? request.accelerator : "";
  call.threads = request.threads;
  return call;
}

int open_model(const weir_open* request, weir_model** out, weir_error* error) {
  *out = nullptr;
  return guarded(error, [&] {
    auto model = std::make_unique<IsolatedModel>();
    model->isolation = *static_cast<const Isolation*>(request->host_ctx);
    if (!model->isolation.monitor) model->isolation.monitor = std::make_shared<Monitor>();
    model->settings.open = make_call(*request, model->isolation.engine);
    model->settings.open.declared = model->isolation.declared;
    const OpenCall& call = model->settings.open;
    if (const auto bound = custom::bound_to_this_process(call.engine, call.paths))
      return give(error, *bound);
    model->settings.timeout = model->isolation.timeout;
    model->settings.min_for_start = model->isolation.min_for_start;
    model->settings.memory_mib = model->isolation.memory_mib;
    model->settings.stop = model->isolation.monitor->stop_descriptor();
    auto first = model->supervisor();
    if (!first) return give(error, first.error());
    model->first = *std::move(first);
    model->facts = model->first->facts();
    model->arena = SharedArena::make(std::min(model->facts->info.input_padding, 65536u));
    *out = reinterpret_cast<weir_model*>(model.release());
    return 0;
  });
}

int info(weir_model* handle, weir_model_info* out, weir_error*) {
  const WorkerModelInfo& facts = *to_model(handle).facts;
  *out = facts.info;
  out->struct_size = sizeof *out;
  constexpr uint32_t kStay = WEIR_MODEL_STATEFUL | WEIR_MODEL_ALLOCATES_OUTPUT |
                             WEIR_MODEL_DYNAMIC_OUTPUT | WEIR_MODEL_EMPTY_INPUT;
  out->flags = facts.info.flags & kStay;
  out->inputs = facts.inputs.list().data();
  out->outputs = facts.outputs.list().data();
  out->n_inputs = static_cast<uint32_t>(facts.inputs.list().size());
  out->n_outputs = static_cast<uint32_t>(facts.outputs.list().size());
  out->alignment = 1;
  out->input_padding = 0;
  out->memory_kinds = uint64_t{1} << WEIR_MEMORY_HOST;
  out->max_sessions = 0;  // no limit
  out->max_in_flight = 1;
  out->metadata_json = facts.metadata_json.empty() ? nullptr : facts.metadata_json.c_str();
  return 0;
}

int session_new(weir_model* handle, const weir_option*, uint32_t, weir_session** out,
                weir_error* error) {
  *out = nullptr;
  return guarded(error, [&] {
    auto supervisor = to_model(handle).supervisor();
    if (!supervisor) return give(error, supervisor.error());
    auto session = std::make_unique<IsolatedSession>(&to_model(handle), *std::move(supervisor));
    *out = reinterpret_cast<weir_session*>(session.release());
    return 0;
  });
}

int resolve(weir_session* session, const weir_tensor_info* in, uint32_t n_in, weir_tensor_info* out,
            uint32_t n_out, weir_error* error) {
  return guarded(error, [&] {
    const Status status = to_session(session).resolve({in, n_in}, {out, n_out});
    return status ? 0 : give(error, status.error());
  });
}

int invoke(weir_session* session, const weir_frame* in, weir_frame* out, weir_error* error) {
  return guarded(error, [&] {
    const auto result = to_session(session).invoke(*in, *out);
    return result ? *result : give(error, result.error());
  });
}

int control(weir_session* session, int op, const weir_option* option, weir_error* error) {
  return guarded(error, [&] {
    const Status status = to_session(session).control(op, option);
    return status ? 0 : give(error, status.error());
  });
}

int execution(weir_model* handle, weir_execution* out) {
  const IsolatedModel& model = to_model(handle);
  if (model.threads == 0) return -WEIR_MODEL_UNSUPPORTED;
  out->threads = model.threads;
  out->spins = model.spins;
  return WEIR_OK;
}

const void* extension(const char* id) {
  static constexpr weir_execution_calls calls{sizeof calls, execution};
  return id && std::string_view(id) == WEIR_EXECUTION ? &calls : nullptr;
}

weir_engine table() {
  weir_engine out{};
  out.struct_size = sizeof out;
  out.abi_major = WEIR_ABI_MAJOR;
  out.abi_minor = WEIR_ABI_MINOR;
  out.name = "isolated";
  out.version = "1";
  // The engine in the process decides whether it needs a file.
  out.flags = WEIR_ENGINE_NEEDS_NO_MODEL | WEIR_ENGINE_MODEL_IS_NO_FILE;
  out.open = open_model;
  out.close = [](weir_model* handle) {
    const std::unique_ptr<IsolatedModel> end(&to_model(handle));
  };
  out.info = info;
  out.session_new = session_new;
  out.session_free = [](weir_session* handle) {
    const std::unique_ptr<IsolatedSession> end(&to_session(handle));
  };
  out.resolve = resolve;
  out.invoke = invoke;
  out.control = control;
  out.extension = extension;
  return out;
}

IsolatedModel* isolated(const infer::Model& model) {
  return &model.engine() == &isolated_engine() ? &to_model(model.handle()) : nullptr;
}

}  // namespace

const weir_engine& isolated_engine() noexcept {
  static const weir_engine kTable = table();
  return kTable;
}

std::shared_ptr<SharedArena> get_arena(const infer::Model& model) {
  const auto* own = isolated(model);
  return own ? own->arena : nullptr;
}
std::shared_ptr<Monitor> get_monitor(const infer::Model& model) {
  const auto* own = isolated(model);
  return own ? own->isolation.monitor : nullptr;
}
AcceleratorChoice accelerator_in(const infer::Model& model) {
  const auto* own = isolated(model);
  return own ? own->facts->accelerator : AcceleratorChoice{};
}
std::string engine_in(const infer::Model& model) {
  const auto* own = isolated(model);
  return own ? own->facts->engine : "";
}

}  // namespace weir::isolate
