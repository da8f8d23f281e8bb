// OipModel: a model on one or several inference servers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "oip/oip_options.hpp"
#include "oip/oip_signature.hpp"
#include "weir/abi.h"

namespace weir::engine {

// Thread-safe after open().
class OipModel {
 public:
  // Asks every server for its description of the model. A server that does not answer joins when a
  // probe finds it. SERVER_UNREACHABLE when none answers and the user declared no tensors.
  static Result<std::unique_ptr<OipModel>> open(const weir_open& request);
  ~OipModel();
  OipModel(const OipModel&) = delete;
  OipModel& operator=(const OipModel&) = delete;

  void describe(weir_model_info* info) const;
  std::vector<weir_statistic> statistics() const;
  std::vector<weir_server> servers() const;
  const std::vector<weir_tensor_info>& inputs() const noexcept { return inputs_; }
  const std::vector<weir_tensor_info>& outputs() const noexcept { return outputs_; }
  const OipSignature& signature() const noexcept { return signature_; }

  // Sends a frame and waits for its end. `server` gets the index of the server that answered.
  net::Outcome request(const weir_frame& in, const weir_frame& out, size_t* server) const;
  // Valid as long as the model.
  const char* get_address(size_t server) const { return servers_->address(server).text.c_str(); }

 private:
  explicit OipModel(OipOptions options) : options_(std::move(options)) {}
  Result<std::vector<net::ServerSet::Server>> open_links(const weir_open& request) const;
  Status connect(const weir_open& request);
  Status read_signature(const std::vector<net::ServerSet::Server>& servers);
  Result<OipSignature> fetch(const net::ServerSet::Server& server,
                             net::Link::Clock::time_point deadline) const;
  bool probe(size_t server, net::Link::Clock::time_point deadline);
  // Reads from the server whether it answers times.
  void read_extensions(net::Link& link, size_t server, net::Link::Clock::time_point deadline);
  bool fits(const net::ServerAddress& address, const Result<OipSignature>& found) const;
  net::ServerSet::Ended send(const weir_frame& in, const weir_frame& out,
                             net::Contents contents) const;
  void report(const net::ServerSet::Ended& ended) const;

  const OipOptions options_;
  OipSignature signature_;
  std::vector<weir_tensor_info> inputs_, outputs_;
  std::vector<char> described_;  // by server: it has described the model; of the probing thread
  std::vector<std::atomic<bool>> has_times_;  // by server: it answers times when asked for them
  mutable std::atomic<net::Contents> contents_{net::Contents::Raw};
  mutable std::atomic<bool> answered_{false};
  mutable std::atomic<uint64_t> copied_out_{0}, copied_in_{0};
  // The outcome of the last report, so that it is not repeated.
  mutable std::atomic<int> reported_{0};
  std::unique_ptr<net::ServerSet> servers_;  // last member: its thread uses the others
};

// Thread-safe: the server that answered is kept for each thread.
class OipSession {
 public:
  static Result<std::unique_ptr<OipSession>> create(const OipModel& model,
                                                    std::span<const weir_option>) {
    return std::make_unique<OipSession>(model);
  }
  explicit OipSession(const OipModel& model);
  Status resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out) const;
  // 0, or a weir_no_result.
  int invoke(const weir_frame& in, weir_frame& out);
  // Of the last invoke by the calling thread.
  const char* answered_by() const;

 private:
  const OipModel& model_;
  const uint64_t number_;  // among the sessions of the process
};

}  // namespace weir::engine
