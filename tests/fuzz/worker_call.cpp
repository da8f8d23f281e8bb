// Fuzz target: parses what a worker process receives from its pipeline. The input is a sequence of
// messages, each with kind, length and body; the first byte selects what precedes them: an open
// model, a block of shared memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <sys/socket.h>

#include <string>
#include <thread>
#include <vector>

#include "adding_filter.hpp"
#include "core/isolate/shared_block.hpp"
#include "core/isolate/worker_server.hpp"

namespace {

using namespace weir::isolate;
using weir::fuzz::FuzzInput;
using weir::fuzz::require;
using weir::io::Descriptor;

constexpr uint64_t kBlock = 1;

void send_open(Channel* pipeline) {
  MessageWriter writer;
  writer.begin(Kind::Open);
  OpenCall call;
  call.engine = "custom-easy";
  call.paths = {"adding"};
  call.put(&writer);
  require(pipeline->send(writer.finish(), {}) == Passage::Done, "the worker reads");
}

void send_block(Channel* pipeline, const SharedBlock& block) {
  MessageWriter writer;
  writer.begin(Kind::Block);
  writer.put(BlockCall{kBlock, block.bytes(), 1});
  require(pipeline->send(writer.finish(), {}, block.descriptor()) == Passage::Done,
          "the worker reads");
}

void send_message(Channel* pipeline, FuzzInput* input) {
  const auto kind = static_cast<Kind>(input->byte());
  const auto body = input->bytes(input->take<uint16_t>());
  MessageWriter writer;
  writer.begin(kind);
  for (const std::byte b : body) writer.put(b);
  (void)pipeline->send(writer.finish(), {});
}

// Every response is a complete message.
void read_responses(int socket) {
  Channel channel{Descriptor(dup(socket))};
  Message response;
  Passage passage;
  while ((passage = channel.receive({}, &response)) == Passage::Done)
    require(response.kind == Kind::Hello || response.kind >= Kind::Opened,
            "a worker sends answers");
  require(passage == Passage::Ended, "answers are whole messages");
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  weir::fuzz::register_adding_filter();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzInput input(data, size);
  int ends[2];
  require(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) == 0, "a socket can be made");
  const auto block = SharedBlock::create(SharedBlock::kPage, Sharing::WrittenByWorker);
  require(static_cast<bool>(block), "memory can be shared");
  std::thread reader([socket = ends[0]] { read_responses(socket); });
  std::thread worker([socket = ends[1]] {
    WorkerServer server{Descriptor(socket)};
    (void)server.serve({"nothing", ""});
  });
  {
    Channel pipeline{Descriptor(dup(ends[0]))};
    const uint8_t first = input.byte();
    if (first & 1) send_open(&pipeline);
    if (first & 2) send_block(&pipeline, **block);
    while (!input.empty()) send_message(&pipeline, &input);
  }
  shutdown(ends[0], SHUT_WR);
  worker.join();
  reader.join();
  close(ends[0]);
  return 0;
}
