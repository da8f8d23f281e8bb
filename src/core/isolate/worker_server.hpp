// The worker's side of the protocol: one model, one session, one call at a time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/infer/model/model.hpp"
#include "core/isolate/calls.hpp"
#include "core/isolate/channel.hpp"
#include "core/isolate/confinement.hpp"
#include "core/isolate/shared_block.hpp"
#include "core/isolate/worker_model_info.hpp"

namespace weir::isolate {

class WorkerServer {
 public:
  explicit WorkerServer(io::Descriptor socket) : channel_(std::move(socket)) {}
  ~WorkerServer();
  WorkerServer(const WorkerServer&) = delete;
  WorkerServer& operator=(const WorkerServer&) = delete;

  // Sends Hello, then handles calls until the other end is closed. False: a protocol error.
  bool serve(const Confinement& confinement);

 private:
  // Each fills writer_ with its reply; an Error is sent as Failed.
  Status handle_message(Message* message);
  Status open(MessageReader* call);
  Status resolve(MessageReader* call);
  Status invoke(MessageReader* call);
  Status fetch(MessageReader* call);
  Status control(MessageReader* call);
  void keep_block(Message* message);
  void forget_block(MessageReader* call);

  Status read_frame(MessageReader* call);
  void set_frames(const FrameCall& frame);
  Status read_inputs(MessageReader* call);
  Status read_outputs(MessageReader* call);
  void respond_to_invoke(int result);
  void write_outputs(Mapping& block);
  void release_outputs();
  std::byte* at(uint64_t block, uint64_t offset, uint64_t bytes);

  Channel channel_;
  MessageWriter writer_;
  std::shared_ptr<infer::Model> model_;
  weir_session* session_ = nullptr;
  std::map<uint64_t, Mapping> blocks_;
  std::vector<weir_tensor> inputs_, outputs_;
  std::vector<uint64_t> places_;  // of outputs_ in the block for outputs
  std::vector<bool> given_;       // those whose memory is in that block
  weir_frame in_{}, out_{};
  std::vector<weir_source_map> maps_;  // referenced by in_
  uint64_t output_block_ = 0;
};

}  // namespace weir::isolate
