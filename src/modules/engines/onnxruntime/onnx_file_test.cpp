// Tests of reading ONNX files without ONNX Runtime.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "onnxruntime/onnx_file.hpp"

#include <gtest/gtest.h>

#include "onnxruntime/onnx_builder_test_support.hpp"
#include "says.hpp"

namespace weir::engine {
namespace onnx_file_test {

using engine_test::kFloat;
using engine_test::OnnxBuilder;

OnnxBuilder small_model() {
  return OnnxBuilder()
      .input("x", kFloat, {"n", "3"})
      .shapeless_output("y", kFloat)
      .node("Neg", {"x"}, {"a"})
      .node("Compress", {"a"}, {"y"})
      .constant("unused", {1, 2, 3});
}

int score(std::vector<unsigned char> head) {
  return onnx_score(head);
}

TEST(OnnxFile, ReportsProducerOperatorsAndShapes) {
  const auto summary = read_onnx(small_model().bytes());
  ASSERT_TRUE(summary) << summary.error().message();
  EXPECT_EQ(summary->ir_version, 7);
  EXPECT_EQ(summary->producer, "weir tests");
  EXPECT_EQ(summary->opsets.at("ai.onnx"), 13);
  EXPECT_EQ(summary->operators, (std::set<std::string>{"Neg", "Compress"}));
  EXPECT_EQ(summary->shapeless, (std::set<std::string>{"y"}));
  EXPECT_TRUE(summary->shapes_depend_on_data());
  EXPECT_GT(summary->weight_bytes, 24u);
}

TEST(OnnxFile, ScalarsHaveAShape) {
  const auto summary = read_onnx(OnnxBuilder().input("s", kFloat, {}).bytes());
  ASSERT_TRUE(summary) << summary.error().message();
  EXPECT_TRUE(summary->shapeless.empty());
  EXPECT_FALSE(summary->shapes_depend_on_data());
}

// A network with a weight of `weights` floats for an input of this shape.
bool is_small(const std::vector<std::string>& shape, int64_t weights) {
  const auto summary =
      read_onnx(OnnxBuilder()
                    .input("x", kFloat, shape)
                    .output("y", kFloat, shape)
                    .constant("w", {weights}, std::vector<float>(static_cast<size_t>(weights), 1))
                    .node("Mul", {"x", "w"}, {"y"})
                    .bytes());
  EXPECT_TRUE(summary) << summary.error().message();
  return summary && summary->is_small();
}

TEST(OnnxFile, IsSmallByWeightsTimesInput) {
  EXPECT_TRUE(is_small({"1", "1", "28", "28"}, 7'000));        // MNIST
  EXPECT_TRUE(is_small({"batch", "3", "24", "24"}, 100'000));  // R-Net: a batch counts as one
  EXPECT_FALSE(is_small({"1", "3", "224", "224"}, 500'000));   // MobileNet
  EXPECT_FALSE(is_small({"1", "3", "2160", "3840"}, 1));       // a picture without a network
  EXPECT_TRUE(is_small({}, 100));
}

TEST(OnnxFile, IsNotSmallIfASizeIsUnknown) {
  EXPECT_FALSE(is_small({"1", "3", "h", "w"}, 100));
  EXPECT_FALSE(is_small({"1", "99999999999", "3"}, 100));
  EXPECT_FALSE(is_small({"1", "2000000000", "2000000000", "2000000000"}, 100)) << "no overflow";
  const auto shapeless = read_onnx(small_model().shapeless_input("z", kFloat).bytes());
  ASSERT_TRUE(shapeless);
  EXPECT_FALSE(shapeless->is_small());
}

TEST(OnnxFile, RejectsATruncatedGraphAndReportsTheMissingBytes) {
  auto bytes = small_model().bytes();
  bytes.resize(60);
  const auto summary = read_onnx(bytes);
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error().code, Code::MODEL_INVALID);
  EXPECT_SAYS(summary.error().offered, "bytes too early");
}

TEST(OnnxFile, EveryTruncationAndFlippedBitIsHandled) {
  const auto whole = small_model().bytes();
  for (size_t size = 0; size < whole.size(); ++size) (void)read_onnx({whole.data(), size});
  for (size_t bit = 0; bit < whole.size() * 8; ++bit) {
    auto bytes = whole;
    bytes[bit / 8] ^= std::byte(1 << bit % 8);
    (void)read_onnx(bytes);
  }
}

TEST(OnnxFile, RejectsAFileWithoutAGraph) {
  const std::vector<std::byte> only_version{std::byte{8}, std::byte{7}};
  EXPECT_FALSE(read_onnx(only_version));
  EXPECT_FALSE(read_onnx({}));
}

// A protobuf field with this content.
std::string wrap(int field, const std::string& content) {
  std::string size;
  size_t rest = content.size();
  for (; rest >= 0x80; rest >>= 7) size += static_cast<char>((rest & 0x7F) | 0x80);
  return std::string(1, static_cast<char>(field << 3 | 2)) + size + static_cast<char>(rest) +
         content;
}
Result<OnnxSummary> read_graph(const std::string& graph) {
  const std::string model = wrap(7, graph);
  return read_onnx({reinterpret_cast<const std::byte*>(model.data()), model.size()});
}

TEST(OnnxFile, ReportsThatWeightsMayBeInOtherFiles) {
  EXPECT_FALSE(read_onnx(small_model().bytes())->may_need_other_files);
  EXPECT_TRUE(
      read_onnx(small_model().constant_in_file("w", {1}, "w.bin").bytes())->may_need_other_files);
  const std::string here = wrap(8, "name"), elsewhere = here + "\x70\x01";  // data_location 14: 1
  const auto in_an_attribute = [](int field, const std::string& value) {
    return wrap(1, wrap(5, wrap(field, value)));
  };
  for (const int field : {5, 10}) {  // a tensor, a list of tensors
    EXPECT_FALSE(read_graph(in_an_attribute(field, here))->may_need_other_files);
    EXPECT_TRUE(read_graph(in_an_attribute(field, elsewhere))->may_need_other_files);
  }
  EXPECT_TRUE(read_graph(in_an_attribute(6, wrap(5, elsewhere)))->may_need_other_files)
      << "in a subgraph";
  EXPECT_TRUE(read_graph(wrap(15, ""))->may_need_other_files) << "sparse";
}

TEST(OnnxFile, RejectsGraphsNestedTooDeeply) {
  // Attribute 5 of node 1 holds graph 6: nested far deeper than the limit.
  std::string graph;
  for (int i = 0; i < 200; ++i) graph = wrap(1, wrap(5, wrap(6, graph)));
  const auto summary = read_graph(graph);
  ASSERT_FALSE(summary);
  EXPECT_SAYS(summary.error().offered, "graphs are nested too deeply");
}

TEST(OnnxFile, RecognisesAnOnnxFileByItsFirstBytes) {
  EXPECT_GE(score({0x08, 0x07, 0x12, 0x07, 'p', 'y', 't'}), 80);
  EXPECT_GE(score({0x1C, 0, 0, 0, 'O', 'R', 'T', 'M'}), 80);
  EXPECT_EQ(score({0x1C, 0, 0, 0, 'T', 'F', 'L', '3'}), 0);
  EXPECT_EQ(score({0x89, 'P', 'N', 'G', 0x0D, 0x0A, 0x1A, 0x0A}), 0);
  EXPECT_EQ(score({'P', 'K', 3, 4}), 0);
  EXPECT_LT(score({0x08, 0x07, 'x', 'x'}), 50);
  EXPECT_EQ(score({0x08}), 0);
  EXPECT_EQ(score({}), 0);
}

}  // namespace onnx_file_test
}  // namespace weir::engine
