// Pushes three frames of four values through any elements and prints the frames that come out.
//
//   pipeline_push_pull 'tensor_transform mode=arithmetic option=mul:2'
//   c++ -std=c++20 pipeline_push_pull.cpp $(pkg-config --cflags --libs weir-pipeline)
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdio>

#include "weir/pipeline.hpp"

namespace {

using namespace std::chrono_literals;

int complain(const weir::Error& error) {
  std::fprintf(stderr, "%s\n", error.message().c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "pipeline_push_pull 'ELEMENT ! ...'\n"), 2;
  auto made = weir::Pipeline::parse("appsrc name=in ! valve name=door ! " + std::string(argv[1]) +
                                    " ! tensor_sink name=out");
  if (!made) return complain(made.error());
  weir::Pipeline& pipeline = *made;
  if (const auto status = pipeline.start(); !status) return complain(status.error());
  if (const auto status = pipeline.valve("door").open(); !status) return complain(status.error());

  for (int n = 0; n < 3; ++n) {
    const float x = static_cast<float>(n);
    const std::vector<float> values{x, x + 1, x + 2, x + 3};
    const auto status = pipeline.push<float>("in", values, {.shape = {1, 4}, .pts = n * 100ms});
    if (!status) return complain(status.error());
  }
  if (const auto status = pipeline.end("in"); !status) return complain(status.error());

  for (;;) {
    const auto frame = pipeline.pull<float>("out", 30s);
    if (!frame) return complain(frame.error());
    if (!*frame) break;
    const auto values = (**frame)[0].as<float>();
    if (!values) return complain(values.error());
    std::printf("%lld ms:", static_cast<long long>((*frame)->pts().value_or(0ns) / 1ms));
    for (const float value : *values) std::printf(" %g", static_cast<double>(value));
    std::printf("\n");
  }
  const auto ended = pipeline.wait(30s);
  if (!ended) return complain(ended.error());
  return *ended ? 0 : 1;
}
