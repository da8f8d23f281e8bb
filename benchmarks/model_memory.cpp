// Measures the memory of several filters of one model: each with its own model, or all with one
// key.
//
// Usage: model_memory ENGINE MODELS DIMENSIONS TYPE FILTERS shared|apart. Prints the KiB that this
// process has written after FILTERS filters (may be 0) have run a frame. tools/bench starts a
// process for each number.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <malloc.h>

#include <cstdlib>
#include <cstring>

#include "stream_stage.hpp"
#include "written_memory.hpp"

namespace {

using weir::bench::Stage;

// The bytes of a frame of "3:224:224:1".
size_t count_bytes(const char* dimensions, const char* type) {
  size_t bytes = std::strcmp(type, "uint8") == 0 ? 1 : sizeof(float);
  for (const char* at = dimensions; at; at = std::strchr(at, ':')) {
    at += *at == ':';
    bytes *= std::strtoul(at, nullptr, 10);
  }
  return bytes;
}

// Filters on one thread that all get the same frame; results are not kept.
std::string filters(const char* engine, const char* models, int count, const char* key) {
  std::string text = "tee name=all ";
  for (int i = 0; i < count; ++i)
    text += std::string("all. ! tensor_filter framework=") + engine + " model=" + models + key +
            " threads=1 ! fakesink async=false enable-last-sample=false ";
  return text + "all. ! identity";  // last, so that all filters have finished
}

}  // namespace

int main(int argc, char** argv) {
  // Otherwise malloc adapts its threshold to the blocks that the first model frees and keeps such
  // blocks, so that later models would seem to need less.
  mallopt(M_MMAP_THRESHOLD, 128 << 10);
  gst_init(&argc, &argv);
  if (argc != 7) return 2;
  const std::string caps =
      std::string("other/tensor,type=") + argv[4] + ",framerate=30/1,dimension=(string)" + argv[3];
  const size_t bytes = count_bytes(argv[3], argv[4]);
  const char* const key =
      std::strcmp(argv[6], "shared") == 0 ? " shared-tensor-filter-key=measured" : "";
  // Run once and closed, so that plug-ins, the engine's library, threads and tables exist in every
  // measurement and are not counted.
  Stage(caps, bytes, filters(argv[1], argv[2], 1, ""), 1).run(1);
  malloc_trim(0);
  Stage stage(caps, bytes, filters(argv[1], argv[2], std::atoi(argv[5]), key), 1);
  stage.run(1);
  std::printf("{\"kib\": %ld}\n", weir::bench::written_kib());
}
