// Opens a built-in decoder and passes it tensors of any shape and content.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "core/decoders/decoders.hpp"
#include "core/infer/module/decoder.hpp"
#include "fuzz_input.hpp"

namespace weir::fuzz {

// Output memory of whole words, which is not cleared for decoders.
struct Sink final : weir_sink {
  weir::Status set_caps(const std::string&) override { return weir::ok(); }
  void* reserve(uint64_t bytes) override {
    words.assign(bytes / 4, 0x55555555);
    return words.data();
  }
  weir::Status share_input(uint32_t) override { return weir::ok(); }
  std::vector<uint32_t> words;
};

struct Tensors {
  // Mostly float32 tensors with up to 3 of these extents; numbers are those of the input.
  Tensors(std::span<const int64_t> extents, FuzzInput* input)
      : values(input->below(5)), tensors(values.size()) {
    for (size_t i = 0; i < values.size(); ++i) {
      auto& info = tensors[i].info;
      info.type = input->rarely() ? input->byte() : uint32_t{WEIR_FLOAT32};
      info.rank = input->rarely() ? input->byte() : 1 + input->below(3);
      size_t count = 1;
      for (uint32_t k = 0; k < info.rank && k < WEIR_RANK_LIMIT; ++k) {
        info.shape[k] = input->rarely() ? input->take<int32_t>()
                                        : extents[input->below(uint32_t(extents.size()))];
        count = info.shape[k] > 0 && info.shape[k] < 4096 ? count * size_t(info.shape[k]) : 0;
        if (count > 1 << 16) count = 0;
      }
      values[i].resize(count);
    }
    for (auto& numbers : values)
      for (float& number : numbers) number = read_number(input);
    for (size_t i = 0; i < values.size(); ++i) {
      tensors[i].data = values[i].data();
      tensors[i].bytes = tensors[i].capacity = values[i].size() * sizeof(float);
    }
  }
  static float read_number(FuzzInput* input) {
    if (input->rarely()) return input->take<float>();
    return static_cast<float>(input->byte()) / 128;
  }

  std::vector<std::vector<float>> values;
  std::vector<weir_tensor> tensors;
};

inline const weir_decoder_type& builtin_decoder(const std::string& name) {
  const weir_module& module = decoders::builtin_decoders();
  size_t i = 0;
  while (name != module.decoders[i]->name) ++i;
  return *module.decoders[i];
}

// Calls `check` with the words of each frame that the decoder makes of up to 3 inputs.
template <class Check>
void decode_frames(const std::string& mode, const infer::Decoder::Options& options,
                   std::span<const int64_t> extents, FuzzInput* input, Check&& check) {
  const auto decoder = infer::Decoder::open(builtin_decoder(mode), options);
  if (!decoder) {
    require(!decoder.error().what.empty() && !decoder.error().needed.empty(),
            "an error says what is needed");
    return;
  }
  for (int i = 0; i < 3 && !input->empty(); ++i) {
    Tensors tensors(extents, input);
    weir_frame frame{};
    frame.struct_size = sizeof frame;
    frame.n_tensors = static_cast<uint32_t>(tensors.tensors.size());
    frame.tensors = tensors.tensors.data();
    Sink sink;
    const auto made = (*decoder)->decode(frame, &sink);
    if (made)
      check(std::span<const uint32_t>(sink.words));
    else
      require(!made.error().what.empty() && !made.error().needed.empty(),
              "an error says what is needed");
  }
}

}  // namespace weir::fuzz
