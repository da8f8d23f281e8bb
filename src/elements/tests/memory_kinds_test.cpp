// Memory other than system memory: mapped only through its own functions and no longer than needed;
// if it cannot be mapped, an error reports it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/allocators/gstdmabuf.h>
#include <gst/allocators/gstfdmemory.h>

#include <numeric>

#include "elements/tests/bad_input_bench_test_support.hpp"
#include "elements/tests/device_memory_test_support.hpp"
#include "elements/tests/dma_buf_test_support.hpp"

namespace memory_kinds_test {

using namespace weir::testing_bad_input;
using namespace weir::testing_memory;

GstBuffer* make_buffer(GstMemory* memory) {
  GstBuffer* buffer = gst_buffer_new();
  gst_buffer_append_memory(buffer, memory);
  return buffer;
}

std::vector<uint8_t> ramp(size_t bytes) {
  std::vector<uint8_t> out(bytes);
  std::iota(out.begin(), out.end(), uint8_t{1});
  return out;
}
GstBuffer* system_memory(const std::vector<uint8_t>& bytes) {
  GstBuffer* buffer = gst_buffer_new_allocate(nullptr, bytes.size(), nullptr);
  gst_buffer_fill(buffer, 0, bytes.data(), bytes.size());
  return buffer;
}
// The element's output for four such frames, and how many bytes it copies for them.
template <class Make>
std::pair<std::vector<uint8_t>, uint64_t> make_output(const Subject& subject, Make&& make) {
  Bench bench(subject.line);
  EXPECT_EQ(bench.start(subject.caps), "");
  bench.keep_bytes();
  for (int i = 0; i < 4; ++i) EXPECT_EQ(bench.push(make(ramp(subject.bytes))), "") << i;
  bench.expect_balance(4);
  return {bench.bytes(), bench.stat("bytes-copied")};
}

// Elements that never read the bytes: frames keep their memory.
bool passes_on(const Subject& subject) {
  const std::string name = subject.name;
  return name == "converter" || name == "converter_bytes" || name == "sink" || name == "overlay" ||
         name == "to_roi" || name == "from_roi";
}

class MemoryKind : public EachElement {};

TEST_P(MemoryKind, WithItsOwnMapFunctionIsReadThroughIt) {
  const Subject& subject = GetParam();
  DeviceAllocator device(Refuses::Nothing);
  const auto make = [&](const auto& bytes) { return make_buffer(device.holding(bytes)); };
  EXPECT_EQ(make_output(subject, make), make_output(subject, system_memory));
  EXPECT_EQ(device.mapped(), 0) << "nothing stays mapped";
}

TEST_P(MemoryKind, ThatCannotBeMappedIsReported) {
  const Subject& subject = GetParam();
  for (const guint flags : {guint{0}, guint{GST_MEMORY_FLAG_NOT_MAPPABLE}}) {
    DeviceAllocator device(Refuses::Everything, flags);
    Bench bench(subject.line);
    ASSERT_EQ(bench.start(subject.caps), "");
    const std::string error = bench.push(make_buffer(device.holding(ramp(subject.bytes))));
    EXPECT_EQ(error.empty(), passes_on(subject)) << error;
    EXPECT_SAYS(error, passes_on(subject) ? "" : "WEIR-2007: ");
    expect_sound_again(bench, subject, bench.stat("received"));
  }
}

TEST_P(MemoryKind, ThatCannotBeMappedAndIsSharedIsReported) {
  const Subject& subject = GetParam();
  DeviceAllocator device(Refuses::Everything);
  Bench bench(subject.line);
  ASSERT_EQ(bench.start(subject.caps), "");
  const auto held = Ref<GstBuffer>::adopt(make_buffer(device.holding(ramp(subject.bytes))));
  const std::string error = bench.push(gst_buffer_ref(held.get()));
  const std::string name = subject.name;
  if (name != "sink" && name != "overlay" && name != "to_roi" && name != "from_roi") {
    EXPECT_SAYS(error, "WEIR-2007: ");
  }
  expect_sound_again(bench, subject, 1);
}

TEST_P(MemoryKind, ThatIsReadOnlyIsNeverWritten) {
  const Subject& subject = GetParam();
  for (const guint flags : {guint{0}, guint{GST_MEMORY_FLAG_READONLY}}) {
    DeviceAllocator device(Refuses::Writing, flags);
    Bench bench(subject.line);
    ASSERT_EQ(bench.start(subject.caps), "");
    for (int i = 0; i < 2; ++i)
      EXPECT_EQ(bench.push(make_buffer(device.holding(ramp(subject.bytes)))), "") << i;
    expect_sound_again(bench, subject, 2);
  }
}

TEST_P(MemoryKind, ThatIsAFileIsRead) {
  const Subject& subject = GetParam();
  const auto allocator = Ref<GstAllocator>::adopt(gst_fd_allocator_new());
  const auto make = [&](const auto& bytes) {
    return make_buffer(gst_fd_allocator_alloc(allocator.get(), make_file(bytes), bytes.size(),
                                              GST_FD_MEMORY_FLAG_NONE));
  };
  EXPECT_EQ(make_output(subject, make), make_output(subject, system_memory));
}

// A memory file replaces the device's: GstDmaBuf maps it with the same calls.
TEST_P(MemoryKind, ThatIsADmaBufIsReadBetweenSyncs) {
  const Subject& subject = GetParam();
  const auto allocator = Ref<GstAllocator>::adopt(gst_dmabuf_allocator_new());
  SyncWatch syncs;
  const auto make = [&](const auto& bytes) {
    return make_buffer(gst_dmabuf_allocator_alloc(allocator.get(), make_file(bytes), bytes.size()));
  };
  EXPECT_EQ(make_output(subject, make), make_output(subject, system_memory));
  // Frames passed on unread are mapped only by the bench: once per output.
  EXPECT_GE(syncs.begun(), passes_on(subject) ? 0 : 4);
  EXPECT_EQ(syncs.ended(), syncs.begun());
}

TEST_P(MemoryKind, ThatIsARealDmaBufIsReadBetweenSyncs) {
  const Subject& subject = GetParam();
  if (!can_make_dma_bufs())
    GTEST_SKIP() << "no /dev/dri/card that shares its memory: modprobe vgem";
  const auto allocator = Ref<GstAllocator>::adopt(gst_dmabuf_allocator_new());
  SyncWatch syncs;
  const auto make = [&](const auto& bytes) {
    GstMemory* memory = gst_dmabuf_allocator_alloc(allocator.get(), make_dma_buf(bytes), kPage);
    gst_memory_resize(memory, 0, bytes.size());
    return make_buffer(memory);
  };
  EXPECT_EQ(make_output(subject, make), make_output(subject, system_memory));
  EXPECT_GE(syncs.begun(), passes_on(subject) ? 0 : 4);
  EXPECT_EQ(syncs.ended(), syncs.begun());
  EXPECT_EQ(syncs.refused(), 0);
}

TEST(MemoryKindOfPaddedRows, IsReadOrReported) {
  const Subject subject{"converter", "tensor_converter", video("RGB", 5, 4), 64};
  DeviceAllocator device(Refuses::Nothing), refusing(Refuses::Everything);
  const auto make = [&](const auto& bytes) { return make_buffer(device.holding(bytes)); };
  const auto rows = make_output(subject, make);
  EXPECT_EQ(rows.first.size(), 4 * 60u);
  EXPECT_EQ(rows.second, 4 * 60u);
  EXPECT_EQ(rows, make_output(subject, system_memory));
  EXPECT_EQ(device.mapped(), 0);
  Bench bench(subject.line);
  ASSERT_EQ(bench.start(subject.caps), "");
  EXPECT_SAYS(bench.push(make_buffer(refusing.holding(ramp(64)))), "WEIR-2007: ");
  expect_sound_again(bench, subject, 1);
}

WEIR_FOR_EACH_OF(MemoryKind, single_input_subjects());

}  // namespace memory_kinds_test
