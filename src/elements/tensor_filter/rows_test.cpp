// tensor_filter invoke-rows, invoke-threads: a batch that runs in parts gives the same result as a
// whole one.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fstream>

#include "core/tensor/tensor_header.hpp"
#include "elements/tests/element_test_support.hpp"

namespace rows_test {

using namespace weir::test;

// The model adds 1 to each number.
std::string line(const std::string& properties, const char* engine = "fake") {
  const std::string path = testing::TempDir() + "weir_fake_model.bin";
  std::ofstream(path) << "x";
  return "tensor_filter framework=" + std::string(engine) + " model=" + path + " " + properties;
}
std::string caps(size_t rows) {
  return "other/tensor,dimension=(string)4:" + std::to_string(rows) +
         ",type=float32,framerate=30/1";
}
std::vector<float> numbers(size_t rows, float first) {
  std::vector<float> out(4 * rows);
  for (size_t i = 0; i < out.size(); ++i) out[i] = first + static_cast<float>(i);
  return out;
}

TEST(TensorFilterRows, StaticBatchesArePushedWhole) {
  for (const char* how : {"invoke-rows=3", "invoke-threads=2", "invoke-rows=1 invoke-threads=3",
                          "invoke-rows=100", "invoke-rows=3 invoke-threads=2 workers=2"}) {
    auto h = make_harness(line(how), caps(10));
    for (int i = 0; i < 3; ++i) {
      const auto first = static_cast<float>(100 * i);
      ASSERT_EQ(gst_harness_push(h.get(), frame(numbers(10, first), i * GST_SECOND, GST_MSECOND)),
                GST_FLOW_OK);
    }
    for (int i = 0; i < 3; ++i) {
      const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
      ASSERT_TRUE(out) << how;
      EXPECT_EQ(values<float>(out.get()), numbers(10, static_cast<float>(100 * i + 1))) << how;
      EXPECT_EQ(GST_BUFFER_PTS(out.get()), i * GST_SECOND);
    }
    EXPECT_EQ(stat(h, "tensor_filter", "consumed"), 3u);
    EXPECT_EQ(stat(h, "tensor_filter", "bytes-copied"), 0u) << how;
  }
}

// A header, then float32 rows.
GstBuffer* flexible(size_t rows) {
  weir::TensorHeader header;
  header.spec.type = weir::ElementType::Float32;
  header.spec.shape = {};
  header.spec.shape[0] = 4;
  header.spec.shape[1] = static_cast<uint32_t>(rows);
  std::vector<float> bytes(weir::kTensorHeaderBytes / sizeof(float));
  weir::write_tensor_header(
      header, std::as_writable_bytes(std::span(bytes)).first<weir::kTensorHeaderBytes>());
  const auto all = numbers(rows, 0);
  bytes.insert(bytes.end(), all.begin(), all.end());
  return frame(bytes, 0, GST_MSECOND);
}

TEST(TensorFilterRows, BatchesCanChangeWithEachFrame) {
  auto h = make_harness(line("invoke-rows=4 invoke-threads=2"),
                        "other/tensors,format=flexible,framerate=30/1");
  for (const size_t rows : {7, 7, 1, 20, 2, 7}) {
    const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), flexible(rows)));
    ASSERT_TRUE(out);
    auto found = values<float>(out.get());
    found.erase(found.begin(), found.begin() + weir::kTensorHeaderBytes / sizeof(float));
    EXPECT_EQ(found, numbers(rows, 1));
  }
}

TEST(TensorFilterRows, PartsAreSeparateInvokes) {
  auto whole = make_harness(line("custom=fail-at:3"), caps(4));
  EXPECT_EQ(gst_harness_push(whole.get(), frame(numbers(4, 0), 0, 1)), GST_FLOW_OK);
  auto parts = make_harness(line("custom=fail-at:3 invoke-rows=1"), caps(4));
  EXPECT_EQ(gst_harness_push(parts.get(), frame(numbers(4, 0), 0, 1)), GST_FLOW_ERROR);
}

TEST(TensorFilterRows, AlignmentAppliesToEachPart) {
  auto h = make_harness(line("custom=alignment:64,padding:64 invoke-rows=5"), caps(18));
  const auto out = Ref<GstBuffer>::adopt(
      gst_harness_push_and_pull(h.get(), frame(numbers(18, 0), 0, GST_MSECOND)));
  ASSERT_TRUE(out);
  EXPECT_EQ(values<float>(out.get()), numbers(18, 1));
}

TEST(TensorFilterRows, AModelOfOneRowRunsOnceForEachRow) {
  for (const char* how : {"custom=rows:1 invoke-rows=1", "custom=rows:1 invoke-rows=1 workers=2",
                          "custom=rows:1,alignment:16 invoke-rows=1 invoke-threads=2"}) {
    auto fixed = make_harness(line(how), caps(5));
    ASSERT_EQ(gst_harness_push(fixed.get(), frame(numbers(5, 3), 0, GST_MSECOND)), GST_FLOW_OK);
    const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(fixed.get()));
    ASSERT_TRUE(out) << how;
    EXPECT_EQ(values<float>(out.get()), numbers(5, 4)) << how;
    auto h = make_harness(line(how), "other/tensors,format=flexible,framerate=30/1");
    for (const size_t rows : {3, 1, 7, 7}) {
      gst_harness_push(h.get(), flexible(rows));
      const auto each = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
      ASSERT_TRUE(each) << how;
      auto found = values<float>(each.get());
      found.erase(found.begin(), found.begin() + weir::kTensorHeaderBytes / sizeof(float));
      EXPECT_EQ(found, numbers(rows, 1)) << how;
    }
  }
}

TEST(TensorFilterRows, AModelOfOneRowStaysOneWithoutTheProperty) {
  const std::string whole = start_error(line("custom=rows:1"), caps(3));
  EXPECT_SAYS(whole, "first difference: tensor 0 (x): dimension 1 is 3, needed is 1");
  EXPECT_SAYS(whole, "fix: tensor_filter invoke-rows=1");
  auto h = make_harness(line("custom=rows:1,alignment:64 invoke-rows=1"), caps(3));
  Errors errors(h);
  EXPECT_EQ(gst_harness_push(h.get(), frame(numbers(3, 0), 0, GST_MSECOND)), GST_FLOW_ERROR);
  const std::string unaligned = errors.next();
  EXPECT_SAYS(unaligned, "WEIR-3013: the rows of a batch are not aligned as the model requires");
  EXPECT_SAYS(unaligned, "offered: rows of 16 bytes");
  EXPECT_SAYS(unaligned, "needed: a multiple of 64 bytes");
  EXPECT_SAYS(start_error(line("invoke-rows=1 custom=stateful:1,rows:1")),
              "offered: a model that keeps state");
}

TEST(TensorFilterRows, ReportsBatchesThatCannotBeSplit) {
  const std::string fixed = start_error(line("invoke-rows=2 custom=rows:4"));
  EXPECT_SAYS(fixed, "WEIR-3013: the model's batch cannot be split");
  EXPECT_SAYS(fixed, "offered: 4 rows");
  EXPECT_SAYS(fixed, "first difference: input 0");
  EXPECT_SAYS(fixed, "fix: tensor_filter invoke-rows=0 invoke-threads=1");
  EXPECT_SAYS(start_error(line("invoke-rows=2 custom=stateful:1")),
              "offered: a model that keeps state");
  const std::string gathered = start_error(line("invoke-rows=2 batch-size=2"));
  EXPECT_SAYS(gathered, "WEIR-1004: these properties cannot be combined");
  EXPECT_SAYS(gathered, "offered: batch-size=2 with invoke-rows=2 invoke-threads=1");
  EXPECT_SAYS(start_error(line("invoke-rows=2 isolate=process")), "isolate=process");
}

}  // namespace rows_test
