// Memory that is not the system's: mapped where it can be, by its own functions and no longer than
// needed; named where it cannot.
#include <gst/allocators/gstdmabuf.h>
#include <gst/allocators/gstfdmemory.h>
#include <sys/mman.h>
#include <unistd.h>

#include <numeric>

#include "elements/tests/bad_input_bench.hpp"
#include "elements/tests/device_memory.hpp"

namespace {

using namespace weir::testing_bad_input;
using weir::testing_memory::DeviceAllocator;
using weir::testing_memory::Refuses;

GstBuffer* buffer_of(GstMemory* memory) {
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
// What the element makes of four such frames.
template <class Make>
std::vector<uint8_t> made_of(const Subject& subject, Make&& make) {
  Bench bench(subject.line);
  EXPECT_EQ(bench.start(subject.caps), "");
  bench.keep_bytes();
  for (int i = 0; i < 4; ++i) EXPECT_EQ(bench.push(make(ramp(subject.bytes))), "") << i;
  bench.expect_balance(4);
  return bench.bytes();
}

// What never looks at the bytes: they go on in the memory they are in.
bool passes_on(const Subject& subject) {
  const std::string name = subject.name;
  return name == "converter" || name == "converter_bytes" || name == "sink";
}

class MemoryKind : public EachElement {};

TEST_P(MemoryKind, ThatMapsByItsOwnFunctionIsReadThroughIt) {
  const Subject& subject = GetParam();
  DeviceAllocator device(Refuses::Nothing);
  const auto make = [&](const auto& bytes) { return buffer_of(device.holding(bytes)); };
  EXPECT_EQ(made_of(subject, make), made_of(subject, system_memory));
  EXPECT_EQ(device.mapped(), 0) << "nothing stays mapped";
}

TEST_P(MemoryKind, ThatCannotBeMappedIsNamed) {
  const Subject& subject = GetParam();
  for (const guint flags : {guint{0}, guint{GST_MEMORY_FLAG_NOT_MAPPABLE}}) {
    DeviceAllocator device(Refuses::Everything, flags);
    Bench bench(subject.line);
    ASSERT_EQ(bench.start(subject.caps), "");
    const std::string error = bench.push(buffer_of(device.holding(ramp(subject.bytes))));
    EXPECT_EQ(error.empty(), passes_on(subject)) << error;
    EXPECT_SAYS(error, passes_on(subject) ? "" : "WEIR-2007: ");
    expect_sound_again(bench, subject, bench.stat("received"));
  }
}

TEST_P(MemoryKind, ThatCannotBeMappedAndIsHeldBySomebodyElseIsNamed) {
  const Subject& subject = GetParam();
  DeviceAllocator device(Refuses::Everything);
  Bench bench(subject.line);
  ASSERT_EQ(bench.start(subject.caps), "");
  const auto held = Ref<GstBuffer>::adopt(buffer_of(device.holding(ramp(subject.bytes))));
  const std::string error = bench.push(gst_buffer_ref(held.get()));
  if (std::string(subject.name) != "sink") {
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
      EXPECT_EQ(bench.push(buffer_of(device.holding(ramp(subject.bytes)))), "") << i;
    expect_sound_again(bench, subject, 2);
  }
}

// Files in memory stand in for a device's: GstDmaBuf maps them with the same calls.
GstMemory* memory_of_file(GstAllocator* allocator, const std::vector<uint8_t>& bytes, bool dma) {
  const int file = memfd_create("weir-test", MFD_CLOEXEC);
  EXPECT_EQ(write(file, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  return dma ? gst_dmabuf_allocator_alloc(allocator, file, bytes.size())
             : gst_fd_allocator_alloc(allocator, file, bytes.size(), GST_FD_MEMORY_FLAG_NONE);
}

TEST_P(MemoryKind, ThatIsAFileIsRead) {
  const Subject& subject = GetParam();
  for (const bool dma : {false, true}) {
    const auto allocator =
        Ref<GstAllocator>::adopt(dma ? gst_dmabuf_allocator_new() : gst_fd_allocator_new());
    const auto make = [&](const auto& bytes) {
      return buffer_of(memory_of_file(allocator.get(), bytes, dma));
    };
    EXPECT_EQ(made_of(subject, make), made_of(subject, system_memory)) << dma;
  }
}

TEST(MemoryKindOfPaddedRows, IsReadOrNamed) {
  const Subject subject{"converter", "tensor_converter", video("RGB", 5, 4), 64};
  DeviceAllocator device(Refuses::Nothing), refusing(Refuses::Everything);
  const auto make = [&](const auto& bytes) { return buffer_of(device.holding(bytes)); };
  const auto rows = made_of(subject, make);
  EXPECT_EQ(rows.size(), 4 * 60u);
  EXPECT_EQ(rows, made_of(subject, system_memory));
  EXPECT_EQ(device.mapped(), 0);
  Bench bench(subject.line);
  ASSERT_EQ(bench.start(subject.caps), "");
  EXPECT_SAYS(bench.push(buffer_of(refusing.holding(ramp(64)))), "WEIR-2007: ");
  expect_sound_again(bench, subject, 1);
}

WEIR_FOR_EACH_ELEMENT(MemoryKind);

}  // namespace
