// What sessions of one model cost in memory: opened for each user, or once under a key.
//
// model_memory FRAMEWORK MODEL USERS shared|apart: prints the growth of this process in KiB (the
// pages that only it maps) from before the model was opened to after each user's warming invoke.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "core/infer/model_table.hpp"
#include "core/infer/module_library.hpp"

namespace {

using namespace weir;

long private_kib() {
  std::ifstream rollup("/proc/self/smaps_rollup");
  long sum = 0;
  for (std::string line; std::getline(rollup, line);)
    if (line.starts_with("Private_")) sum += std::atol(line.substr(line.find(':') + 1).c_str());
  return sum;
}

[[noreturn]] void fail(const Error& error) {
  std::fprintf(stderr, "%s\n", error.message().c_str());
  std::exit(1);
}

// A user whose session has invoked once.
std::unique_ptr<infer::ModelUse> warmed(const infer::ModelSource& source, const char* key) {
  auto found = infer::ModelTable::instance().find(key, source);
  auto use = infer::ModelUse::create(std::move(found.model), 1);
  if (!use) fail(use.error());
  const auto frame = (*use)->begin();
  if (!frame) fail(frame.error());
  auto inputs = model_shapes(frame->model().inputs());
  for (auto& input : inputs)
    for (auto& extent : input.shape)
      if (extent < 0) extent = 1;
  if (const auto outputs = (*use)->resolve(inputs); !outputs) fail(outputs.error());
  if (const auto status = frame->session().control(WEIR_WARM); !status) fail(status.error());
  return *std::move(use);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) return 2;
  const auto engine = infer::ModuleLibrary::instance().engine(argv[1]);
  if (!engine) fail(engine.error());
  infer::ModelSource source;
  source.engine = *engine;
  source.options.paths = {argv[2]};
  source.options.threads = 1;
  const bool shared = std::strcmp(argv[4], "shared") == 0;
  // The engine's library, its threads and a user beside are there before anything is counted.
  const auto beside = warmed(source, "");
  const long before = private_kib();
  std::vector<std::unique_ptr<infer::ModelUse>> users;
  for (int i = 0; i < std::atoi(argv[3]); ++i) users.push_back(warmed(source, shared ? "k" : ""));
  std::printf("{\"kib\": %ld}\n", private_kib() - before);
}
