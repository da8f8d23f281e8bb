// SPDX-License-Identifier: LGPL-2.1-or-later
#include "oip/oip_model.hpp"

#include <algorithm>

#include "tensor_check.hpp"
#include "weir/engine_tools.hpp"

namespace weir::engine {
namespace {

using net::CallStatus;
using net::Outcome;
using net::ServerSet;

constexpr size_t kMaxInFlight = 1024;

Error unreachable(const ServerSet::Server& server, const net::Reply& reply) {
  return {.code = Code::SERVER_UNREACHABLE,
          .what = "the inference server cannot be reached",
          .offered = server.address.text + ": " + reply.message,
          .needed =
              "a server that describes the model; or input, inputtype, inputname, output, "
              "outputtype, outputname, to start without one",
          .fix = "start the server, or correct model=" + server.address.text};
}

Error refused(const ServerSet::Server& server, const net::Reply& reply) {
  return {
      .code = Code::SERVER_REFUSED,
      .what = "the inference server refused to describe the model",
      .offered = server.address.text + ": " + reply.message + " (gRPC status " +
                 std::to_string(reply.status) + ")",
      .needed = "a model " + server.address.model +
                (server.address.version.empty() ? "" : " of version " + server.address.version) +
                " on this server",
      .fix = "model=grpc://HOST:PORT/NAME/VERSION with a name that the server has"};
}

Error differs(const net::ServerAddress& address, const std::string& offered,
              const std::string& needed) {
  return {.code = Code::SPEC_MISMATCH,
          .what = "two servers have different models",
          .offered = address.text + ": " + offered,
          .needed = needed,
          .fix = "name servers of the same model in model="};
}

std::vector<weir_tensor_info> to_infos(const std::vector<OipTensor>& tensors) {
  std::vector<weir_tensor_info> out;
  out.reserve(tensors.size());
  for (const auto& tensor : tensors) out.push_back(tensor.info());
  return out;
}

bool is_open_batch(const weir_tensor_info& info) {
  return info.rank > 1 && info.shape[0] == -1;
}

// A server that fails in these ways may answer later.
bool may_come_back(const Error& error) {
  return error.code == Code::SERVER_UNREACHABLE;
}

}  // namespace

OipModel::~OipModel() {
  if (!servers_) return;
  const auto counts = servers_->counts();
  log(WEIR_LOG_INFO, "requests: " + std::to_string(counts.sent) +
                         " sent = " + std::to_string(counts.of(Outcome::Answered)) +
                         " answered + " + std::to_string(counts.of(Outcome::Late)) + " late + " +
                         std::to_string(counts.of(Outcome::Refused)) + " refused + " +
                         std::to_string(counts.of(Outcome::Lost)) + " lost");
}

Result<std::unique_ptr<OipModel>> OipModel::open(const weir_open& request) {
  auto options = OipOptions::read(request);
  if (!options) return options.error();
  // Not as warnings, which may go to standard error: requests that fail are reported on their own.
  net::Link::set_log([](bool error, const std::string& text) {
    log(error ? WEIR_LOG_INFO : WEIR_LOG_DEBUG, text);
  });
  std::unique_ptr<OipModel> out(new OipModel(*std::move(options)));
  if (auto status = out->connect(request); !status) return status.error();
  return out;
}

Result<std::vector<ServerSet::Server>> OipModel::open_links(const weir_open& request) const {
  std::vector<ServerSet::Server> servers;
  for (uint32_t i = 0; i < request.n_models; ++i) {
    auto address = net::ServerAddress::parse(text_or_empty(request.paths[i]));
    if (!address) return address.error();
    auto link = net::Link::open(*address, options_.security, options_.max_bytes);
    if (!link) return link.error();
    servers.push_back({*std::move(address), *std::move(link)});
  }
  if (servers.empty())
    return Error{.code = Code::MODEL_NOT_FOUND,
                 .what = "no server is set",
                 .offered = "model=\"\"",
                 .needed = "the address of a model on a server",
                 .fix = "model=grpc://127.0.0.1:8001/resnet/1"};
  return servers;
}

Status OipModel::connect(const weir_open& request) {
  auto links = open_links(request);
  if (!links) return links.error();
  auto& servers = *links;
  contents_ = options_.contents.value_or(net::Contents::Raw);
  described_.resize(servers.size());
  has_times_ = std::vector<std::atomic<bool>>(servers.size());
  if (auto status = read_signature(servers); !status) return status;
  inputs_ = to_infos(signature_.inputs);
  outputs_ = to_infos(signature_.outputs);
  const bool batches =
      !inputs_.empty() && std::all_of(inputs_.begin(), inputs_.end(), is_open_batch) &&
      !outputs_.empty() && std::all_of(outputs_.begin(), outputs_.end(), is_open_batch);
  for (auto* list : {&inputs_, &outputs_})
    for (auto& info : *list)
      if (batches) info.batch_axis = 0;
  servers_ = std::make_unique<ServerSet>(
      std::move(servers), options_.limits,
      [this](size_t server, auto deadline) { return probe(server, deadline); });
  for (size_t i = 0; i < described_.size(); ++i)
    if (!described_[i]) servers_->open_circuit(i);
  return ok();
}

// The description of the first server that gives one, which those of the others must equal.
Status OipModel::read_signature(const std::vector<ServerSet::Server>& servers) {
  const auto declared = OipSignature::from(options_.declared);
  std::optional<Error> first_problem;
  bool found = false;
  for (size_t i = 0; i < servers.size(); ++i) {
    const auto deadline = net::Link::Clock::now() + options_.limits.timeout;
    auto signature = fetch(servers[i], deadline);
    if (!signature) {
      if (!may_come_back(signature.error())) return signature.error();
      if (!first_problem) first_problem = signature.error();
      log(WEIR_LOG_WARNING, signature.error().message());
      continue;
    }
    described_[i] = 1;
    read_extensions(*servers[i].link, i, deadline);
    if (found && !(*signature == signature_))
      return differs(servers[i].address, signature->to_string(), signature_.to_string());
    signature_ = *std::move(signature);
    found = true;
  }
  if (found) return ok();
  if (declared.inputs.empty()) return *first_problem;
  signature_ = declared;
  return ok();
}

Result<OipSignature> OipModel::fetch(const ServerSet::Server& server,
                                     net::Link::Clock::time_point deadline) const {
  const auto reply = server.link->call(
      "ModelMetadata", net::encode_model_request(server.address.model, server.address.version),
      nullptr, deadline);
  const auto declared = OipSignature::from(options_.declared);
  if (reply.status == static_cast<int>(CallStatus::Unimplemented) && !declared.inputs.empty())
    return declared;
  const auto outcome = net::to_outcome(reply.status);
  if (outcome == Outcome::Refused) return refused(server, reply);
  if (outcome != Outcome::Answered) return unreachable(server, reply);
  const auto metadata = net::parse_model_metadata(reply.chunks);
  if (!metadata) return metadata.error();
  auto out = OipSignature::from(*metadata);
  if (!out) return out.error();
  if (!out->inputs.empty() && !out->outputs.empty()) return out;
  if (!declared.inputs.empty()) return declared;
  auto error = refused(server, reply);
  error.offered = server.address.text + ": a description without inputs or outputs";
  return error;
}

void OipModel::read_extensions(net::Link& link, size_t server,
                               net::Link::Clock::time_point deadline) {
  const auto reply = link.call("ServerMetadata", {}, nullptr, deadline);
  const auto found = reply.status == 0
                         ? net::parse_has_extension(reply.chunks, net::kTimesExtension)
                         : Result<bool>(false);
  has_times_[server] = found && *found;
}

bool OipModel::fits(const net::ServerAddress& address, const Result<OipSignature>& found) const {
  if (!found) {
    log(WEIR_LOG_DEBUG, found.error().message());
    return false;
  }
  if (found->is_compatible(signature_)) return true;
  log(WEIR_LOG_WARNING, differs(address, found->to_string(), signature_.to_string()).message());
  return false;
}

bool OipModel::probe(size_t server, net::Link::Clock::time_point deadline) {
  const auto& address = servers_->address(server);
  auto& link = servers_->link(server);
  const auto request = net::encode_model_request(address.model, address.version);
  const auto reply = link.call_when_connected("ModelReady", request, deadline);
  if (reply.status != static_cast<int>(CallStatus::Unimplemented)) {
    if (reply.status != 0) return false;
    const auto ready = net::parse_model_ready(reply.chunks);
    if (!ready || !*ready) return false;
  }
  read_extensions(link, server, deadline);  // another server may have taken the place of the last
  if (described_[server]) return true;
  const auto metadata = link.call("ModelMetadata", request, nullptr, deadline);
  if (metadata.status == static_cast<int>(CallStatus::Unimplemented)) return true;
  if (metadata.status != 0) return false;
  const auto parsed = net::parse_model_metadata(metadata.chunks);
  const bool describes = parsed && fits(address, OipSignature::from(*parsed));
  described_[server] = describes ? 1 : 0;
  return describes;
}

void OipModel::describe(weir_model_info* info) const {
  info->flags = WEIR_MODEL_THREAD_SAFE | WEIR_MODEL_FORK_UNSAFE;
  const size_t window = options_.limits.in_flight * servers_->size();
  info->max_in_flight =
      options_.idempotent ? static_cast<uint32_t>(std::min<size_t>(window, kMaxInFlight)) : 1;
  info->n_inputs = static_cast<uint32_t>(inputs_.size());
  info->n_outputs = static_cast<uint32_t>(outputs_.size());
  info->inputs = inputs_.data();
  info->outputs = outputs_.data();
}

std::vector<weir_statistic> OipModel::statistics() const {
  const auto counts = servers_->counts();
  return {{"requests-sent", counts.sent},
          {"requests-answered", counts.of(Outcome::Answered)},
          {"requests-late", counts.of(Outcome::Late)},
          {"requests-refused", counts.of(Outcome::Refused)},
          {"requests-lost", counts.of(Outcome::Lost)},
          {"request-attempts", counts.attempts},
          {"request-bytes-copied", copied_out_},
          {"answer-bytes-copied", copied_in_}};
}

std::vector<weir_server> OipModel::servers() const {
  using std::chrono::microseconds;
  const auto us = [](const auto& duration) -> int64_t {
    return duration ? std::chrono::duration_cast<microseconds>(*duration).count() : -1;
  };
  std::vector<weir_server> out;
  for (size_t i = 0; i < servers_->size(); ++i) {
    const auto statistics = servers_->statistics(i);
    const auto ended = [&](Outcome outcome) {
      return statistics.ended[static_cast<size_t>(outcome)];
    };
    const auto clock = statistics.clock.value_or(net::ClockOffset::Estimate{0, -1});
    out.push_back({.address = servers_->address(i).text.c_str(),
                   .circuit = static_cast<int32_t>(statistics.circuit),
                   .in_flight = static_cast<uint32_t>(statistics.in_flight),
                   .answered = ended(Outcome::Answered),
                   .late = ended(Outcome::Late),
                   .refused = ended(Outcome::Refused),
                   .lost = ended(Outcome::Lost),
                   .bytes_sent = statistics.bytes_sent,
                   .bytes_received = statistics.bytes_received,
                   .p50_us = us(statistics.p50),
                   .p95_us = us(statistics.p95),
                   .p99_us = us(statistics.p99),
                   .queue_us = statistics.queue_us.value_or(-1),
                   .compute_us = statistics.compute_us.value_or(-1),
                   .clock_offset_ns = clock.offset,
                   .clock_error_ns = clock.error});
  }
  return out;
}

}  // namespace weir::engine
