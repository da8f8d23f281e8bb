// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/server/model_server.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <mutex>

#include "net/server/reflection.hpp"
#include "net/server/server_security.hpp"

namespace weir::net {
namespace {

// The last only where model control is enabled.
constexpr std::array<std::string_view, 4> kExtensions{"weir_keepalive", "statistics",
                                                      kTimesExtension, "model_repository"};

struct Shared {
  std::unique_ptr<ModelServer> server;
  ListenOptions options;
  size_t users = 0;
};

std::mutex& shared_mutex() {
  static std::mutex mutex;  // guards shared_servers()
  return mutex;
}
std::map<std::string, Shared>& shared_servers() {
  static auto& servers = *new std::map<std::string, Shared>;  // lives as long as its users
  return servers;
}

// Ends the server under the lock, so that nothing listens there when another one starts.
void leave(const std::string& address) {
  std::lock_guard lock(shared_mutex());
  const auto found = shared_servers().find(address);
  if (found != shared_servers().end() && --found->second.users == 0) shared_servers().erase(found);
}

// shared_mutex() is held.
std::shared_ptr<ModelServer> use(const std::string& address, Shared* shared) {
  ++shared->users;
  return {shared->server.get(), [address](ModelServer*) { leave(address); }};
}

void refuse(const std::shared_ptr<Call>& call, const Error& error) {
  call->fail(CallStatus::InvalidArgument, error.message());
}

}  // namespace

Result<std::shared_ptr<ModelServer>> ModelServer::share(const ListenOptions& options) {
  std::lock_guard lock(shared_mutex());
  auto& servers = shared_servers();
  std::string address = address_text(options);
  auto found =
      options.port == 0 && options.unix_path.empty() ? servers.end() : servers.find(address);
  if (found != servers.end() && !(found->second.options == options))
    return Error{.code = Code::OPTION_VALUE,
                 .what = "elements that share an address have different options",
                 .offered = "another element listens on " + address,
                 .needed = "the same limits, certificates and tokens",
                 .fix = "another port, or port=0"};
  if (found == servers.end()) {
    auto server = std::make_unique<ModelServer>(options);
    auto listener = Listener::open(
        options, [raw = server.get()](const std::shared_ptr<Call>& call) { raw->handle(call); });
    if (!listener) return listener.error();
    server->listener_ = *std::move(listener);
    ListenOptions actual = options;
    if (options.unix_path.empty()) actual.port = server->port();
    address = address_text(actual);
    found = servers.emplace(address, Shared{std::move(server), actual, 0}).first;
  }
  return use(address, &found->second);
}

std::shared_ptr<ModelServer> ModelServer::listening_on(const std::string& address) {
  std::lock_guard lock(shared_mutex());
  const auto found = shared_servers().find(address);
  return found == shared_servers().end() ? nullptr : use(address, &found->second);
}

Status ModelServer::add(const std::shared_ptr<ServedModel>& model) {
  return models_->add(model, address_text(options_));
}

// Returns null when the call has ended: with NOT_FOUND, or for a model that may come back
// UNAVAILABLE.
std::shared_ptr<ServedModel> ModelServer::find(const ModelRequest& wanted,
                                               const std::shared_ptr<Call>& call) {
  auto model = models_->find(wanted);
  if (model) return model;
  if (models_->was_here(wanted))
    call->fail(CallStatus::Unavailable,
               "the pipeline of the model " + describe(wanted) + " does not run");
  else
    call->fail(CallStatus::NotFound, "there is no model " + describe(wanted) +
                                         " here; this server has: " + models_->names());
  return model;
}

void ModelServer::server_live(const std::shared_ptr<Call>& call) {
  call->respond(encode_flag(true), nullptr);
}

void ModelServer::server_ready(const std::shared_ptr<Call>& call) {
  call->respond(encode_flag(models_->health("") == Health::Serving), nullptr);
}

void ModelServer::server_metadata(const std::shared_ptr<Call>& call) {
  call->respond(
      encode_server_metadata("weir", WEIR_VERSION,
                             std::span(kExtensions).first(options_.model_control ? 4 : 3)),
      nullptr);
}

void ModelServer::model_ready(const std::shared_ptr<Call>& call) {
  const auto wanted = parse_model_request(call->request());
  if (!wanted) return refuse(call, wanted.error());
  if (models_->was_here(*wanted) && !models_->find(*wanted))
    call->respond(encode_flag(false), nullptr);
  else if (const auto model = find(*wanted, call))
    call->respond(encode_flag(model->ready()), nullptr);
}

void ModelServer::model_metadata(const std::shared_ptr<Call>& call) {
  const auto wanted = parse_model_request(call->request());
  if (!wanted) return refuse(call, wanted.error());
  const auto model = find(*wanted, call);
  if (!model) return;
  if (!model->ready())
    call->fail(CallStatus::Unavailable,
               "the pipeline of the model " + wanted->name + " does not run yet");
  else
    call->respond(encode_model_metadata(model->metadata(), model->model().version), nullptr);
}

void ModelServer::model_infer(const std::shared_ptr<Call>& call) {
  auto request = parse_infer_request(call->request());
  if (!request) return refuse(call, request.error());
  if (const auto model = find({request->model, request->version}, call))
    model->receive(call, *std::move(request));
}

void ModelServer::model_statistics(const std::shared_ptr<Call>& call) {
  const auto wanted = parse_model_request(call->request());
  if (!wanted) return refuse(call, wanted.error());
  std::vector<ModelStatistics> out;
  if (!wanted->name.empty() && !find(*wanted, call)) return;
  for (const auto& model : models_->all())
    if (wanted->name.empty() || fits(*wanted, model->model())) out.push_back(model->statistics());
  call->respond(encode_statistics(out), nullptr);
}

void ModelServer::health(const std::shared_ptr<Call>& call) {
  const auto service = parse_health_request(call->request());
  if (!service) return refuse(call, service.error());
  const Health health = models_->health(*service);
  if (health == Health::Unknown)
    call->fail(CallStatus::NotFound, "there is no service " + *service + " here");
  else
    call->respond(encode_health(static_cast<int>(health)), nullptr);
}

void ModelServer::watch_health(const std::shared_ptr<Call>& call) {
  const auto service = parse_health_request(call->request());
  if (!service) return refuse(call, service.error());
  models_->watch(call, *service);
}

bool ModelServer::can_control(const std::shared_ptr<Call>& call) const {
  if (!options_.model_control)
    call->fail(CallStatus::Unimplemented,
               "clients may not load or unload models on this server: start it with weir serve "
               "--model-control, or set model-control=true of tensor_query_serversrc");
  return options_.model_control;
}

void ModelServer::set_loaded(const std::shared_ptr<Call>& call, bool loaded) {
  if (!can_control(call)) return;
  const auto wanted = parse_load_request(call->request());
  if (!wanted) return refuse(call, wanted.error());
  if (loaded && wanted->has_parameters) {
    call->fail(CallStatus::InvalidArgument,
               "the server loads models with its own settings and does not accept parameters");
    return;
  }
  const auto model = find({wanted->model, ""}, call);
  if (!model) return;
  model->set_loaded(loaded);
  call->respond({}, nullptr);
}

void ModelServer::repository_index(const std::shared_ptr<Call>& call) {
  if (!can_control(call)) return;
  const auto ready_alone = parse_index_request(call->request());
  if (!ready_alone) return refuse(call, ready_alone.error());
  auto models = models_->index();
  if (*ready_alone) std::erase_if(models, [](const auto& model) { return !model.ready; });
  call->respond(encode_index(models), nullptr);
}

void ModelServer::reflection(const std::shared_ptr<Call>& call) {
  const auto& services = Reflection::of_this_server();
  if (services.empty()) {
    call->fail(CallStatus::Unimplemented,
               "this server was built without protoc and has no reflection service");
    return;
  }
  const auto response = services.respond(call->request());
  if (!response) return refuse(call, response.error());
  call->respond(*response, nullptr);
}

void ModelServer::handle(const std::shared_ptr<Call>& call) {
  using Method = void (ModelServer::*)(const std::shared_ptr<Call>&);
  static const std::map<std::string_view, Method> methods{
      {"/inference.GRPCInferenceService/ServerLive", &ModelServer::server_live},
      {"/inference.GRPCInferenceService/ServerReady", &ModelServer::server_ready},
      {"/inference.GRPCInferenceService/ServerMetadata", &ModelServer::server_metadata},
      {"/inference.GRPCInferenceService/ModelReady", &ModelServer::model_ready},
      {"/inference.GRPCInferenceService/ModelMetadata", &ModelServer::model_metadata},
      {"/inference.GRPCInferenceService/ModelInfer", &ModelServer::model_infer},
      {"/inference.GRPCInferenceService/ModelStatistics", &ModelServer::model_statistics},
      {"/inference.GRPCInferenceService/RepositoryIndex", &ModelServer::repository_index},
      {"/inference.GRPCInferenceService/RepositoryModelLoad", &ModelServer::load},
      {"/inference.GRPCInferenceService/RepositoryModelUnload", &ModelServer::unload},
      {"/grpc.health.v1.Health/Check", &ModelServer::health},
      {"/grpc.health.v1.Health/Watch", &ModelServer::watch_health},
      {"/grpc.reflection.v1.ServerReflection/ServerReflectionInfo", &ModelServer::reflection},
      {"/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo", &ModelServer::reflection},
  };
  const auto method = methods.find(call->method());
  if (method == methods.end())
    call->fail(CallStatus::Unimplemented, "there is no method " + call->method() + " here");
  else
    (this->*method->second)(call);
}

}  // namespace weir::net
