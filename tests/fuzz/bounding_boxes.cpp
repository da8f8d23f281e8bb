// Fuzz target: decodes tensors of any shape and content with every scheme of bounding_boxes. A
// frame has the size of its caps, and its pixels are red or transparent.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <vector>

#include "core/decoders/builtin_decoders.hpp"
#include "core/infer/module/decoder.hpp"
#include "fuzz_input.hpp"
#include "memory_file.hpp"

namespace {

using weir::fuzz::FuzzInput;
using weir::fuzz::require;

constexpr std::array kSchemes{
    "mobilenet-ssd", "tf-ssd",  "ov-person-detection", "yolov5",        "yolov8",
    "yolov8-obb",    "yolov10", "mp-palm-detection",   "no-such-scheme"};

struct Sink final : weir_sink {
  weir::Status set_caps(const std::string&) override { return weir::ok(); }
  void* reserve(uint64_t bytes) override {
    pixels.assign(bytes / 4, 0x55555555);
    return pixels.data();
  }
  weir::Status share_input(uint32_t) override { return weir::ok(); }
  std::vector<uint32_t> pixels;
};

struct Tensors {
  // Shapes that the scheme takes, or any of up to 4 extents; numbers are those of the input.
  explicit Tensors(FuzzInput* input) : values(input->below(5)), tensors(values.size()) {
    static constexpr std::array<int64_t, 12> kExtents{1, 2, 3, 4, 5, 6, 7, 18, 21, 63, 200, 2016};
    for (size_t i = 0; i < values.size(); ++i) {
      auto& info = tensors[i].info;
      info.type = input->rarely() ? input->byte() : uint32_t{WEIR_FLOAT32};
      info.rank = input->rarely() ? input->byte() : 1 + input->below(3);
      size_t count = 1;
      for (uint32_t k = 0; k < info.rank && k < WEIR_RANK_LIMIT; ++k) {
        info.shape[k] = input->rarely() ? input->take<int32_t>()
                                        : kExtents[input->below(uint32_t{kExtents.size()})];
        count = info.shape[k] > 0 && info.shape[k] < 4096 ? count * size_t(info.shape[k]) : 0;
        if (count > 1 << 16) count = 0;
      }
      values[i].resize(count);
    }
    for (auto& numbers : values)
      for (float& number : numbers) number = number_of(input);
    for (size_t i = 0; i < values.size(); ++i) {
      tensors[i].data = values[i].data();
      tensors[i].bytes = tensors[i].capacity = values[i].size() * sizeof(float);
    }
  }
  static float number_of(FuzzInput* input) {
    if (input->rarely()) return input->take<float>();
    return static_cast<float>(input->byte()) / 128;
  }

  std::vector<std::vector<float>> values;
  std::vector<weir_tensor> tensors;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzInput input(data, size);
  const weir_module& module = weir::decoders::builtin_decoders();
  const std::string scheme = kSchemes[input.below(uint32_t{kSchemes.size()})];
  std::string parameters(input.line());
  std::string prior_lines(input.line());
  std::replace(prior_lines.begin(), prior_lines.end(), ';', '\n');
  const weir::fuzz::MemoryFile priors(prior_lines);
  const weir::fuzz::MemoryFile labels("a\nb\n");
  if (scheme == "mobilenet-ssd") parameters = priors.path() + parameters;
  weir::infer::Decoder::Options options{{"option1", scheme},
                                        {"option3", parameters},
                                        {"option4", std::string(input.line())},
                                        {"option5", std::string(input.line())},
                                        {"option6", input.flag() ? "1" : "0"}};
  if (input.flag()) options.emplace_back("option2", labels.path());
  // Large frames take long to look at.
  if (options[2].second.size() > 5) options[2].second = "32:32";
  const auto decoder = weir::infer::Decoder::open(*module.decoders[0], options);
  if (!decoder) {
    require(!decoder.error().what.empty() && !decoder.error().needed.empty(),
            "an error says what is needed");
    return 0;
  }
  for (int i = 0; i < 3 && !input.empty(); ++i) {
    Tensors tensors(&input);
    weir_frame frame{};
    frame.struct_size = sizeof frame;
    frame.n_tensors = static_cast<uint32_t>(tensors.tensors.size());
    frame.tensors = tensors.tensors.data();
    Sink sink;
    if (!(*decoder)->decode(frame, &sink)) continue;
    for (const uint32_t pixel : sink.pixels)
      require(pixel == 0 || pixel == 0xFF0000FF, "a pixel is red or transparent");
  }
  return 0;
}
