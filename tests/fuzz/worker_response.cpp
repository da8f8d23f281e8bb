// Fuzz target: parses what a worker process, possibly compromised by its model, sends to a
// pipeline. The input is the worker's data; the first byte selects whether a valid greeting and
// model precede it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/isolate/worker.hpp"
#include "fuzz_input.hpp"

namespace {

using namespace weir::isolate;
using weir::fuzz::FuzzInput;
using weir::fuzz::require;

std::string& responses_path() {
  static auto& path = *new std::string(std::filesystem::temp_directory_path() /
                                       ("weir-fuzz-answers-" + std::to_string(getpid())));
  return path;
}

void add(MessageWriter* writer, std::string* out) {
  const auto bytes = writer->finish();
  out->append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

weir_tensor_info make_info(uint32_t type, int64_t extent) {
  weir_tensor_info info{};
  info.type = type;
  info.rank = 1;
  info.shape[0] = extent;
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  return info;
}

void add_model(std::string* out) {
  weir_tensor_info input = make_info(WEIR_UINT8, -1), output = make_info(WEIR_UINT64, 2);
  weir_model_info info{};
  info.struct_size = sizeof info;
  info.n_inputs = info.n_outputs = 1;
  info.inputs = &input;
  info.outputs = &output;
  MessageWriter writer;
  writer.begin(Kind::Opened);
  put_model("adding", {}, info, &writer);
  add(&writer, out);
}

void add_greeting(std::string* out) {
  MessageWriter writer;
  writer.begin(Kind::Hello);
  writer.put(kProtocol);
  writer.text("nothing");
  add(&writer, out);
}

std::string make_responses(FuzzInput* input) {
  std::string out;
  const uint8_t first = input->byte();
  if (first & 1) add_greeting(&out);
  if (first & 2) add_model(&out);
  while (!input->empty()) {
    MessageWriter writer;
    writer.begin(static_cast<Kind>(input->byte()));
    for (const std::byte b : input->bytes(input->take<uint16_t>())) writer.put(b);
    add(&writer, &out);
  }
  return out;
}

// One frame: its first output has memory, the engine allocates the second.
void invoke(Worker* worker, const SharedArena& arena) {
  std::vector<uint8_t> bytes(100, 3);
  uint64_t sums[2] = {};
  weir_tensor input{}, outputs[2]{};
  input.data = bytes.data();
  input.bytes = input.capacity = bytes.size();
  input.info = make_info(WEIR_UINT8, 100);
  outputs[0].data = sums;
  outputs[0].bytes = outputs[0].capacity = sizeof sums;
  outputs[0].info = outputs[1].info = make_info(WEIR_UINT64, 2);
  weir_frame in{}, out{};
  in.struct_size = out.struct_size = sizeof in;
  in.n_tensors = 1;
  in.tensors = &input;
  out.n_tensors = 2;
  out.tensors = outputs;
  uint64_t copied = 0;
  const auto done = worker->invoke(in, out, arena, &copied);
  if (done) require(outputs[0].bytes <= sizeof sums, "an output fits its memory");
  if (outputs[1].release) outputs[1].release(outputs[1].owner);
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  // In the same folder as this program.
  const auto worker =
      std::filesystem::read_symlink("/proc/self/exe").parent_path() / "scripted_worker";
  setenv("WEIR_WORKER", worker.c_str(), 1);
  setenv("WEIR_FUZZ_RESPONSES", responses_path().c_str(), 1);
  std::atexit([] { unlink(responses_path().c_str()); });
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzInput input(data, size);
  std::ofstream(responses_path(), std::ios::binary) << make_responses(&input);
  WorkerSettings settings;
  settings.open.engine = "adding";
  auto worker = Worker::start(settings, -1);
  if (!worker) {
    require(!worker.error().what.empty(), "an error has a text");
    return 0;
  }
  const auto arena = SharedArena::make(0);
  auto in = make_info(WEIR_UINT8, 100);
  auto out = make_info(WEIR_UINT64, -1);
  const auto resolved = (*worker)->resolve({&in, 1}, {&out, 1});
  if (resolved)
    require(out.rank <= WEIR_RANK_LIMIT || out.rank == WEIR_RANK_UNKNOWN, "a rank is legal");
  if ((*worker)->alive()) invoke(worker->get(), *arena);
  if ((*worker)->alive()) (void)(*worker)->control(WEIR_WARM, nullptr);
  return 0;
}
