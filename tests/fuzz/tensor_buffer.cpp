// Fuzz target: buffers of tensor streams, split into memories at any offset. Every tensor found is
// in the buffer and has the size of its spec, for every reader.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

#include <vector>

#include "fuzz_input.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/frame_layout.hpp"

namespace {

using namespace weir;
using fuzz::FuzzInput;
using fuzz::require;

FrameSpec spec_from(FuzzInput* input) {
  FrameSpec spec;
  spec.format = static_cast<Format>(input->below(3));
  spec.rate = {30, 1};
  if (spec.format != Format::Static) return spec;
  const uint32_t count = input->below(20) + 1;
  for (uint32_t i = 0; i < count; ++i) {
    const auto type = static_cast<ElementType>(input->below(11));
    const bool large = input->below(16) == 0;
    const uint32_t extent = large ? input->take<uint32_t>() : input->below(8) + 1;
    spec.tensors.push_back({type, Shape{extent, input->below(4) + 1}, ""});
  }
  return spec;
}

// Headers from the input are often damaged: a flag replaces some of them with valid ones.
gst::Ref<GstBuffer> buffer_from(FuzzInput* input) {
  auto buffer = gst::Ref<GstBuffer>::adopt(gst_buffer_new());
  const uint32_t memories = input->below(17);
  for (uint32_t i = 0; i <= memories; ++i) {
    const size_t wanted = i == memories ? input->rest().size() : input->take<uint16_t>();
    const auto bytes = input->bytes(wanted);
    if (bytes.empty()) continue;
    GstBuffer* const part = gst_buffer_new_memdup(bytes.data(), bytes.size());
    gst_buffer_append_memory(buffer.get(), gst_buffer_get_memory(part, 0));
    gst_buffer_unref(part);
  }
  return buffer;
}

size_t read_payloads(GstBuffer* buffer, const FrameSpec& spec) {
  gst::FrameLayout reader;
  if (const auto status = reader.read(buffer, spec); !status) {
    require(!status.error().what.empty(), "an error has a text");
    return 0;
  }
  unsigned sum = 0;
  for (const auto& tensor : reader.tensors()) {
    require(tensor.spec.valid() && tensor.payload.size() <= tensor.capacity, "a tensor has a spec");
    if (tensor.format != Format::Sparse)
      require(tensor.payload.size() == tensor.spec.bytes(), "a tensor has the bytes of its spec");
    for (const std::byte b : tensor.payload) sum += static_cast<unsigned>(b);
  }
  require(sum != 1u << 31, "payloads can be read");
  return reader.tensors().size();
}

void pick_all(GstBuffer* buffer, const FrameSpec& spec) {
  gst::FrameLayout layout;
  if (!layout.locate(buffer, spec)) return;
  const size_t size = gst_buffer_get_size(buffer);
  std::vector<size_t> chosen;
  for (const auto& place : layout.tensors()) {
    require(place.offset <= size && place.size <= size - place.offset,
            "a tensor lies in the buffer");
    chosen.insert(chosen.begin(), chosen.size());
  }
  uint64_t copied = 0;
  (void)gst::pick_tensors(buffer, layout, chosen, &copied);
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  gst_init(nullptr, nullptr);
  gst_debug_set_default_threshold(GST_LEVEL_NONE);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzInput input(data, size);
  const auto spec = spec_from(&input);
  const auto buffer = buffer_from(&input);
  require(read_payloads(buffer.get(), spec) <= kTensorLimit, "a frame has at most 256 tensors");
  pick_all(buffer.get(), spec);
  return 0;
}
