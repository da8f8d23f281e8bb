// Outputs that exceed the property max-buffer-size or the memory of the process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <sys/resource.h>
#include <unistd.h>

#include <cstring>
#include <functional>

#include "address_space.hpp"
#include "core/tensor/sparse.hpp"
#include "elements/tensor_crop/crop_test_support.hpp"
#include "elements/tests/bad_input_bench_test_support.hpp"
#include "elements/tests/element_test_support.hpp"

namespace memory_limit_test {

using namespace weir::testing_bad_input;
using weir::test::Bytes;

constexpr size_t kHalf = size_t{1} << 28, kHuge = kHalf * 2;  // bytes

// Pages that are never written use no memory.
GstBuffer* zero_pages(size_t bytes) {
  void* pages = std::calloc(bytes, 1);
  return gst_buffer_new_wrapped_full(GST_MEMORY_FLAG_READONLY, pages, bytes, 0, bytes, pages,
                                     std::free);
}

// Limits the process to 256 MiB more than it uses now.
void limit_memory() {
  std::ifstream statm("/proc/self/statm");
  rlim_t pages = 0;
  statm >> pages;
  const rlim_t bytes = pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + kHalf;
  const rlimit limit{bytes, bytes};
  if (setrlimit(RLIMIT_AS, &limit) != 0) std::abort();
}

// The errors of the large frame and of the small one after it; "" for none.
struct Outcome {
  std::string large, small;
};

// One sink pad; pushes `large` `count` times.
Outcome pushed(const std::string& line, const std::string& large_caps, size_t large, int count,
               const std::string& small_caps, size_t small) {
  Bench bench(line);
  Outcome out;
  std::vector<GstBuffer*> buffers;
  for (int i = 0; i < count; ++i) buffers.push_back(zero_pages(large));
  out.large = bench.start(large_caps);
  limit_memory();
  for (GstBuffer* buffer : buffers) {
    const std::string error = bench.push(buffer);
    if (out.large.empty()) out.large = error;
  }
  if (small == 0) return out;
  out.small = bench.set_caps(small_caps);
  for (int i = 0; i < count; ++i)
    if (out.small.empty()) out.small = bench.push(zeros(small));
  return out;
}

Outcome sparse_decoder() {
  const auto small =
      weir::to_sparse({weir::ElementType::UInt8, weir::Shape{3}, ""}, std::vector<std::byte>(3));
  std::vector<uint32_t> header(32);
  std::memcpy(header.data(), small->data(), 128);
  header[3] = kHuge;
  Bench bench("tensor_sparse_dec max-buffer-size=0");
  Outcome out;
  EXPECT_EQ(bench.start("other/tensors,format=sparse,framerate=30/1"), "");
  limit_memory();
  out.large = bench.push(weir::test::frame(header));
  out.small = bench.push(weir::test::frame(*small));
  return out;
}

Outcome sparse_encoder() {
  Bench bench("tensor_sparse_enc");
  Outcome out;
  EXPECT_EQ(bench.start(tensors("134217728", "uint8")), "");
  GstBuffer* ones = gst_buffer_new_allocate(nullptr, 134217728, nullptr);
  gst_buffer_memset(ones, 0, 1, 134217728);
  limit_memory();
  out.large = bench.push(ones);
  out.small = bench.set_caps(tensors("4", "uint8"));
  if (out.small.empty()) out.small = bench.push(zeros(4));
  return out;
}

// A tensor that `apply` excludes is copied to get a header.
Outcome transform_of_another_tensor() {
  const auto h = weir::test::make_harness(
      "tensor_transform mode=arithmetic option=add:1 apply=1 max-buffer-size=0");
  weir::test::Errors errors(h);
  gst_harness_set_sink_caps_str(h.get(), "other/tensors,format=flexible,framerate=30/1");
  gst_harness_set_src_caps_str(h.get(), tensors("536870912,4", "uint8,uint8").c_str());
  GstBuffer* large = gst_buffer_append(zero_pages(kHuge), zeros(4));
  limit_memory();
  gst_harness_push(h.get(), large);
  Outcome out{errors.next(), ""};
  gst_harness_set_src_caps_str(h.get(), tensors("4,4", "uint8,uint8").c_str());
  gst_harness_push(h.get(), gst_buffer_append(zeros(4), zeros(4)));
  out.small = errors.next();
  return out;
}

// Two inputs, each pushed by its own thread.
Outcome both_pushed(weir::test::ManyInputs& inputs, GstBuffer* first, GstBuffer* second) {
  const auto push = [&](GstBuffer* a, GstBuffer* b) {
    GST_BUFFER_PTS(a) = GST_BUFFER_PTS(b) = 0;
    auto pushing = inputs.push_later(0, Ref<GstBuffer>::adopt(a));
    inputs.push(1, Ref<GstBuffer>::adopt(b));
    pushing.get();
  };
  limit_memory();
  push(first, second);
  return {inputs.error(), ""};
}
Outcome merged() {
  weir::test::ManyInputs merge("tensor_merge mode=linear option=0 max-buffer-size=0");
  for (int i = 0; i < 2; ++i) merge.add(tensors("268435456", "uint8").c_str());
  merge.play();
  return both_pushed(merge, zero_pages(kHalf), zero_pages(kHalf));
}
Outcome multiplexed() {
  weir::test::ManyInputs mux("tensor_mux sync-mode=nosync");
  for (int i = 0; i < 2; ++i) mux.add(tensors("268435456", "uint8").c_str());
  mux.play();
  return both_pushed(mux, zero_pages(kHalf), zero_pages(kHalf));
}
Outcome cropped() {
  weir::test::Crop crop(
      "max-buffer-size=0",
      "other/tensor,dimension=(string)1:8192:8192,type=(string)uint8,framerate=30/1");
  std::vector<uint32_t> regions;
  for (int i = 0; i < 16; ++i) regions.insert(regions.end(), {0, 0, 8192, 8192});
  return both_pushed(crop, zero_pages(size_t{8192} * 8192),
                     weir::test::frame(weir::test::make_info(regions)));
}

// A picture with other owners is copied before it is drawn into.
Outcome overlay() {
  const auto element = weir::test::lone_element("tensor_overlay show-scores=false");
  const weir::test::Harness results{
      gst_harness_new_with_element(element.get(), "results", nullptr)};
  const weir::test::Harness pictures{gst_harness_new_with_element(element.get(), "sink", "src")};
  weir::test::Errors errors(element.get());
  gst_harness_set_src_caps_str(results.get(), tensors("6:1", "float32").c_str());
  gst_harness_set_src_caps_str(pictures.get(), video("GRAY8", 16384, 32768).c_str());
  gst_harness_push(results.get(), weir::test::frame(std::vector<float>{1, 1, 7, 6, 1, 0}, 0));
  GstBuffer* picture = zero_pages(kHuge);
  GST_BUFFER_PTS(picture) = 0;
  limit_memory();
  gst_harness_push(pictures.get(), picture);
  return {errors.next(), ""};
}

// Only the first pad is linked; its output counts.
Outcome branched(const std::string& line, const std::string& caps, size_t bytes) {
  const weir::test::Harness h{
      gst_harness_new_with_element(weir::test::lone_element(line).get(), "sink", nullptr)};
  weir::test::Errors errors(h);
  g_signal_connect(h->element, "pad-added", G_CALLBACK(+[](GstElement*, GstPad* pad, gpointer) {
                     static GstStaticPadTemplate any = GST_STATIC_PAD_TEMPLATE(
                         "end", GST_PAD_SINK, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY);
                     GstPad* end = gst_pad_new_from_static_template(&any, "end");
                     gst_pad_set_chain_function(end, [](GstPad*, GstObject*, GstBuffer* buffer) {
                       gst_buffer_unref(buffer);
                       return GST_FLOW_OK;
                     });
                     gst_pad_set_active(end, TRUE);
                     gst_pad_link(pad, end);
                   }),
                   nullptr);
  gst_harness_set_src_caps_str(h.get(), caps.c_str());
  GstBuffer* large = zero_pages(bytes);
  limit_memory();
  const GstFlowReturn flow = gst_harness_push(h.get(), large);
  const std::string error = errors.next();
  return {error.empty() && flow != GST_FLOW_OK ? gst_flow_get_name(flow) : error, ""};
}

Outcome loop_start() {
  const auto pipeline = weir::test::lone_element(
      "tensor_reposrc slot-index=77 max-buffer-size=0 "
      "caps=other/tensors,format=static,num_tensors=1,dimensions=(string)536870912,"
      "types=(string)uint8,framerate=(fraction)30/1 ! fakesink");
  limit_memory();
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(pipeline.get()));
  const auto message = Ref<GstMessage>::adopt(
      gst_bus_timed_pop_filtered(bus.get(), 60 * GST_SECOND, GST_MESSAGE_ERROR));
  Outcome out{weir::test::get_text(message.get()), ""};
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  return out;
}

struct Case {
  const char* name;
  std::function<Outcome()> run;
  bool passes = false;  // the element passes the frame on and allocates nothing
};
void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

std::vector<Case> cases() {
  const std::string one = tensors("4", "uint8"), huge = tensors("536870912", "uint8");
  const auto pass = [&](const std::string& line) {
    return [=] { return pushed(line, huge, kHuge, 1, one, 4); };
  };
  return {
      {"converter_rows",
       [] {
         return pushed("tensor_converter max-buffer-size=0", video("GRAY8", 16383, 32768), kHuge, 1,
                       video("GRAY8", 5, 2), 16);
       }},
      {"converter_frames",
       [] {
         return pushed("tensor_converter frames-per-tensor=2 max-buffer-size=0",
                       video("GRAY8", 16384, 16384), kHalf, 2, video("GRAY8", 4, 2), 8);
       }},
      {"converter_text",
       [] {
         return pushed("tensor_converter input-dim=536870912 max-buffer-size=0",
                       "text/x-raw,format=utf8,framerate=30/1", 16, 1, "", 0);
       }},
      {"preprocess",
       [] {
         return pushed("tensor_preprocess width=16384 height=32768 max-buffer-size=0",
                       video("RGB", 8, 4), 96, 1, "", 0);
       }},
      {"transform",
       [=] {
         return pushed("tensor_transform mode=typecast option=float64 max-buffer-size=0",
                       tensors("67108864", "uint8"), 67108864, 1, one, 4);
       }},
      {"transform_apply", transform_of_another_tensor},
      {"filter",
       [] {
         return pushed(fake_filter() + " max-buffer-size=0", tensors("4:33554432", "float32"),
                       kHuge, 1, tensors("4:4", "float32"), 64);
       }},
      {"crop", cropped},
      {"decoder",
       [] {
         return pushed("tensor_decoder mode=direct_video max-buffer-size=0",
                       tensors("1:16383:32768", "uint8"), size_t{16383} * 32768, 1,
                       tensors("1:3:2", "uint8"), 6);
       }},
      {"overlay", overlay},
      {"aggregator",
       [] {
         return pushed("tensor_aggregator frames-out=2 frames-dim=0 max-buffer-size=0",
                       tensors("268435456", "uint8"), kHalf, 2, tensors("4", "uint8"), 4);
       }},
      {"sparse_enc", sparse_encoder},
      {"sparse_dec", sparse_decoder},
      {"merge", merged},
      {"reposrc", loop_start},
      {"debug", pass("tensor_debug"), true},
      {"demux", [=] { return branched("tensor_demux", huge, kHuge); }, true},
      {"split", [=] { return branched("tensor_split tensorseg=268435456,268435456", huge, kHuge); },
       true},
      {"rate", pass("tensor_rate"), true},
      {"if",
       [=] {
         return branched(
             "tensor_if compared-value=A_VALUE compared-value-option=0:0:0:0,0 "
             "operator=GE supplied-value=0 then=PASSTHROUGH else=SKIP",
             huge, kHuge);
       },
       true},
      {"mux", multiplexed, true},
      {"reposink", [=] { return pushed("tensor_reposink slot-index=78", huge, kHuge, 1, "", 0); },
       true},
      {"sink", pass("tensor_sink"), true},
      {"join",
       [=] {
         weir::test::ManyInputs join("join");
         join.add(huge.c_str());
         join.play();
         GstBuffer* large = zero_pages(kHuge);
         limit_memory();
         join.push(0, Ref<GstBuffer>::adopt(large));
         return Outcome{join.error(), ""};
       },
       true},
  };
}

class MemoryRunsOut : public testing::TestWithParam<Case> {};

// In a separate process, whose limit stays. A failed allocation in GLib, or a CRITICAL, would abort
// it.
TEST_P(MemoryRunsOut, IsAnError) {
  if (!weir::can_limit_address_space()) GTEST_SKIP() << "the address space cannot be limited";
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto run = [] {
    const Outcome out = GetParam().run();
    std::fprintf(stderr, "large: %s\nsmall: %s|end\n", out.large.c_str(), out.small.c_str());
    std::fflush(stderr);
    std::_Exit(0);
  };
  EXPECT_EXIT(run(), testing::ExitedWithCode(0),
              GetParam().passes ? "large: \nsmall: \\|end"
                                : "large: WEIR-9001: memory ran out(.|\n)*small: \\|end");
}
INSTANTIATE_TEST_SUITE_P(All, MemoryRunsOut, testing::ValuesIn(cases()),
                         [](const auto& info) { return std::string(info.param.name); });

struct Limited {
  const char *name, *factory;
  std::string line, caps;
  size_t bytes;        // of an input frame
  std::string needed;  // bytes of the output
};
void PrintTo(const Limited& limited, std::ostream* out) {
  *out << limited.name;
}
class MaxBufferSize : public testing::TestWithParam<Limited> {};

// Above the limit an error gives the element, the bytes and the property; the stream continues when
// the property is raised.
TEST_P(MaxBufferSize, IsCheckedForEachFrame) {
  const Limited& limited = GetParam();
  const auto h = weir::test::make_harness(limited.line, limited.caps);
  weir::test::Errors errors(h);
  const auto element = weir::test::find_element(h, limited.factory);
  const auto set_limit = [&](const std::string& bytes) {
    gst_util_set_object_arg(G_OBJECT(element.get()), "max-buffer-size", bytes.c_str());
  };
  const auto push = [&] { return gst_harness_push(h.get(), zeros(limited.bytes)); };
  ASSERT_EQ(push(), GST_FLOW_OK) << errors.next();
  set_limit(std::to_string(std::stoul(limited.needed) - 1));
  EXPECT_EQ(push(), GST_FLOW_ERROR);
  const std::string error = errors.next();
  EXPECT_SAYS(error, std::string("WEIR-2006: an output buffer of ") + limited.factory);
  EXPECT_SAYS(error, "offered: " + limited.needed + " bytes\n");
  EXPECT_SAYS(error, "fix: " + std::string(limited.factory) + " max-buffer-size=" + limited.needed);
  for (const std::string& enough : {limited.needed, std::string("0")}) {
    set_limit(enough);
    EXPECT_EQ(push(), GST_FLOW_OK) << errors.next();
  }
}
INSTANTIATE_TEST_SUITE_P(
    All, MaxBufferSize,
    testing::Values(
        Limited{"transform", "tensor_transform", "tensor_transform mode=typecast option=float64",
                tensors("4:4", "uint8"), 16, "128"},
        Limited{"preprocess", "tensor_preprocess", "tensor_preprocess width=10 height=10",
                video("RGB", 8, 4), 96, "300"},
        Limited{"filter", "tensor_filter", fake_filter(), tensors("4:4", "float32"), 64, "64"},
        Limited{"decoder", "tensor_decoder", "tensor_decoder mode=direct_video",
                tensors("3:5:2", "uint8"), 30, "32"}),
    [](const auto& info) { return std::string(info.param.name); });

// 512 bytes of headers describe 4 GiB.
TEST(MaxBufferSize, RejectsASparseFrameThatExpandsBeyondIt) {
  const auto h =
      weir::test::make_harness("tensor_sparse_dec", "other/tensors,format=sparse,framerate=30/1");
  weir::test::Errors errors(h);
  std::vector<uint32_t> one(32), all;
  one[0] = 0xFEEDCCED, one[1] = 0xDE001000, one[2] = 5, one[3] = 1u << 30;
  one[19] = 2, one[20] = 4;
  for (int i = 0; i < 4; ++i) all.insert(all.end(), one.begin(), one.end());
  EXPECT_EQ(gst_harness_push(h.get(), weir::test::frame(all)), GST_FLOW_ERROR);
  EXPECT_SAYS(errors.next(), "offered: 4294967296 bytes\n  needed: at most 1073741824 bytes\n");
}

TEST(MaxBufferSize, RejectsOverlappingRegionsBeyondIt) {
  weir::test::Crop crop("max-buffer-size=1000");
  const auto regions = [](size_t count) {
    std::vector<uint32_t> out;
    for (size_t i = 0; i < count; ++i) out.insert(out.end(), {0, 0, 5, 4});
    return weir::test::make_info(out);
  };
  auto first = crop.push_later(0, weir::test::make_buffer({weir::test::picture()}, 100));
  crop.push(1, regions(6), 100);
  first.get();
  EXPECT_SAYS(crop.error(), "offered: 1008 bytes\n  needed: at most 1000 bytes\n");
}

TEST(MaxBufferSize, RejectsInputCapsBeforeTheModelResolvesShapes) {
  EXPECT_SAYS(weir::test::start_error(fake_filter(), tensors("1073741824:2", "uint8")),
              "WEIR-2006: an input frame of tensor_filter is larger than max-buffer-size");
}

TEST(MaxBufferSize, RejectsWindowsAndLoopsBeyondIt) {
  EXPECT_SAYS(weir::test::start_error("tensor_aggregator frames-out=2 frames-dim=0",
                                      tensors("1073741824", "uint8")),
              "fix: tensor_aggregator max-buffer-size=2147483648");
  Bench gathered("tensor_converter frames-per-tensor=100 max-buffer-size=799");
  ASSERT_EQ(gathered.start(video("GRAY8", 4, 2)), "");
  EXPECT_SAYS(gathered.push(zeros(8)), "fix: tensor_converter max-buffer-size=800");
  Bench text("tensor_converter input-dim=1000 max-buffer-size=999");
  ASSERT_EQ(text.start("text/x-raw,format=utf8,framerate=30/1"), "");
  EXPECT_SAYS(text.push(zeros(8)), "fix: tensor_converter max-buffer-size=1000");
}

}  // namespace memory_limit_test
