// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/model/model.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>

#include "core/infer/model/declared_options.hpp"
#include "core/infer/model/option_check.hpp"
#include "core/infer/module/engine_functions.hpp"
#include "core/infer/module/host.hpp"
#include "core/infer/module/model_file.hpp"

namespace weir::infer {
namespace {

weir_tensor_info unknown_tensor() {
  weir_tensor_info info{};
  info.type = WEIR_TYPE_END;
  info.rank = WEIR_RANK_UNKNOWN;
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  return info;
}

Status check_info(const weir_model_info& info) {
  if (info.n_inputs > WEIR_TENSOR_LIMIT || info.n_outputs > WEIR_TENSOR_LIMIT)
    return Error{.code = Code::MODEL_UNSUPPORTED,
                 .what = "the model has too many tensors",
                 .offered = std::to_string(info.n_inputs) + " inputs, " +
                            std::to_string(info.n_outputs) + " outputs",
                 .needed = "at most 256 each"};
  if ((info.n_inputs > 0 && !info.inputs) || (info.n_outputs > 0 && !info.outputs))
    return Error{.code = Code::MODEL_INVALID,
                 .what = "the engine returned a number of tensors without descriptions",
                 .offered = "a null list",
                 .needed = "a description of each tensor"};
  constexpr uint32_t kMaxAlignment = 4096, kMaxPadding = 65536;
  if (!std::has_single_bit(info.alignment) || info.alignment > kMaxAlignment ||
      info.input_padding > kMaxPadding)
    return Error{.code = Code::MODEL_UNSUPPORTED,
                 .what = "the engine requires memory that cannot be allocated",
                 .offered = "alignment " + std::to_string(info.alignment) + ", padding " +
                            std::to_string(info.input_padding),
                 .needed = "a power of two up to 4096, padding up to 65536"};
  return ok();
}

Status check_tensors(const std::vector<weir_tensor_info>& tensors) {
  for (const auto& info : tensors)
    if (info.type > WEIR_TYPE_END ||
        (info.rank > WEIR_RANK_LIMIT && info.rank != WEIR_RANK_UNKNOWN))
      return Error{.code = Code::MODEL_UNSUPPORTED,
                   .what = "a tensor of the model has a rank or type beyond the limits",
                   .offered = info.name ? info.name : "",
                   .needed = "rank at most 16"};
  return ok();
}

const weir_engine_servers* get_servers(const weir_engine& engine) {
  if (!engine.extension) return nullptr;
  const auto* calls =
      static_cast<const weir_engine_servers*>(engine.extension(WEIR_ENGINE_SERVERS));
  return calls && calls->struct_size >= sizeof *calls ? calls : nullptr;
}

}  // namespace

Result<std::shared_ptr<Model>> Model::open(const weir_engine& engine, const OpenOptions& options) {
  std::vector<const char*> paths;
  for (const auto& path : options.paths) {
    if (!(engine.flags & WEIR_ENGINE_MODEL_IS_NO_FILE))
      if (auto status = check_model_file(path); !status) return status.error();
    paths.push_back(path.c_str());
  }
  if (auto status = check_options(engine, options.options); !status) return status.error();
  std::vector<weir_option> pairs;
  const auto given = options_for(engine, options);
  pairs.reserve(given.size());
  for (const auto& [key, value] : given) pairs.push_back({key.c_str(), value.c_str()});
  weir_open request{};
  request.struct_size = sizeof request;
  request.n_models = static_cast<uint32_t>(paths.size());
  request.paths = paths.data();
  request.options = pairs.data();
  request.n_options = static_cast<uint32_t>(pairs.size());
  request.accelerator = options.accelerator.c_str();
  request.threads = options.threads;
  request.host_ctx = const_cast<void*>(options.host_context.get());
  weir_error error;
  weir_model* handle = nullptr;
  const int result = engine.open(&request, &handle, &error);
  if (result < 0 || !handle)
    return take_error(&error, result < 0 ? result : -WEIR_MODEL_INVALID,
                      "the model cannot be opened");
  std::shared_ptr<Model> model(new Model(engine, handle, options));
  if (auto status = model->read_info(); !status) return status.error();
  return model;
}

Model::Model(const weir_engine& engine, weir_model* handle, OpenOptions options)
    : engine_(engine),
      handle_(handle),
      servers_(get_servers(engine)),
      options_(std::move(options)) {}

Status Model::read_info() {
  weir_error error;
  info_.struct_size = sizeof info_;
  const int result = engine_.info(handle_, &info_, &error);
  if (result < 0) return take_error(&error, result, "the engine cannot describe the model");
  if (info_.alignment == 0) info_.alignment = 1;
  if (auto status = check_info(info_); !status) return status;
  inputs_.assign(info_.inputs, info_.inputs + info_.n_inputs);
  outputs_.assign(info_.outputs, info_.outputs + info_.n_outputs);
  for (const auto* list : {&inputs_, &outputs_})
    if (auto status = check_tensors(*list); !status) return status;
  return ok();
}

std::optional<weir_execution> Model::execution() const {
  if (!engine_.extension) return std::nullopt;
  const auto* calls = static_cast<const weir_execution_calls*>(engine_.extension(WEIR_EXECUTION));
  weir_execution out{sizeof out, 0, 0};
  if (!calls || calls->struct_size < sizeof *calls || calls->describe(handle_, &out) < 0)
    return std::nullopt;
  return out;
}

Model::~Model() {
  engine_.close(handle_);
}

Result<std::shared_ptr<Session>> Model::make_session() {
  std::erase_if(sessions_, [](const auto& session) { return session.expired(); });
  const bool limited = info_.max_sessions > 0;
  if (limited && sessions_.size() >= info_.max_sessions) return std::shared_ptr<Session>();
  std::shared_ptr<std::mutex> turn;
  if (limited && !(info_.flags & WEIR_MODEL_THREAD_SAFE)) turn = std::make_shared<std::mutex>();
  auto made = Session::create(shared_from_this(), turn);
  if (!made) return made.error();
  std::shared_ptr<Session> session = *std::move(made);
  sessions_.push_back(session);
  return session;
}

Result<std::shared_ptr<Session>> Model::own_session() {
  std::lock_guard lock(sessions_mutex_);
  return make_session();
}

Result<std::shared_ptr<Session>> Model::shared_session() {
  std::lock_guard lock(sessions_mutex_);
  for (;;) {
    auto made = make_session();
    if (!made || *made) return made;
    const auto min = std::min_element(
        sessions_.begin(), sessions_.end(),
        [](const auto& a, const auto& b) { return a.use_count() < b.use_count(); });
    if (auto session = min->lock()) return session;
  }
}

Result<std::unique_ptr<Session>> Session::create(std::shared_ptr<Model> model,
                                                 const std::shared_ptr<std::mutex>& turn) {
  const auto lock = turn ? std::unique_lock(*turn) : std::unique_lock<std::mutex>();
  weir_error error;
  weir_session* handle = nullptr;
  const int result = model->engine().session_new(model->handle(), nullptr, 0, &handle, &error);
  if (result < 0 || !handle)
    return take_error(&error, result < 0 ? result : -WEIR_INTERNAL, "no session could be created");
  return std::unique_ptr<Session>(new Session(std::move(model), handle, turn));
}

Session::~Session() {
  abandon();
  requests_.wait_until_quiet();
  const auto lock = take_turn();
  model_->engine().session_free(handle_);
}

Result<std::vector<weir_tensor_info>> Session::resolve(
    const std::vector<weir_tensor_info>& inputs) {
  std::vector<weir_tensor_info> outputs = model_->outputs();
  if (!model_->engine().resolve) return outputs;
  const bool counted = !outputs.empty();
  if (!counted) outputs.assign(WEIR_TENSOR_LIMIT, unknown_tensor());
  const auto lock = take_turn();
  weir_error error;
  const int result =
      model_->engine().resolve(handle_, inputs.data(), static_cast<uint32_t>(inputs.size()),
                               outputs.data(), static_cast<uint32_t>(outputs.size()), &error);
  if (result < 0) return take_error(&error, result, "the engine rejects these input shapes");
  if (!counted) {
    const auto untouched = [](const auto& info) {
      return info.type == WEIR_TYPE_END && info.rank == WEIR_RANK_UNKNOWN;
    };
    outputs.erase(std::find_if(outputs.begin(), outputs.end(), untouched), outputs.end());
  }
  return outputs;
}

Result<bool> Session::invoke(const weir_frame& in, weir_frame& out, InvokeEnd* end) {
  const auto lock = take_turn();
  weir_error error;
  const int result = model_->engine().invoke(handle_, &in, &out, &error);
  if (result < 0) return take_error(&error, result, "the engine failed on a frame");
  if (!end) return result == 0;
  end->reason = result;
  const auto* servers = model_->servers();
  const char* server = servers && result == 0 ? servers->answered_by(handle_) : nullptr;
  end->answered_by = server ? server : "";
  return result == 0;
}

Status Session::control(weir_control op) {
  const auto lock = take_turn();
  return give_order(model_->engine(), handle_, op, nullptr);
}

bool Session::is_asynchronous() const noexcept {
  return get_function(model_->engine(), &weir_engine::submit) &&
         (model_->info().flags & WEIR_MODEL_ASYNC) != 0;
}

Result<bool> Session::submit(const weir_frame& in,
                             const std::shared_ptr<RequestReceiver>& receiver) {
  weir_request* request = requests_.open(receiver);
  if (!request) return false;
  weir_error error;
  const int result = model_->engine().submit(handle_, &in, request, &error);
  if (result == 0) {
    if (requests_.begun(request)) cancel(request);
    return true;
  }
  if (!requests_.withdraw(request)) return true;
  if (result < 0) return take_error(&error, result, "the engine rejected a frame");
  receiver->end(result);  // it drops the frame
  return true;
}

void Session::cancel(weir_request* request) const {
  if (const auto call = get_function(model_->engine(), &weir_engine::cancel))
    call(handle_, request);
}

size_t Session::abandon() {
  const auto abandoned = requests_.abandon();
  for (weir_request* request : abandoned.cancel) cancel(request);
  return abandoned.count;
}

}  // namespace weir::infer
