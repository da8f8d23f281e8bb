// Tests of what the OpenCV engines reject, and of the error texts.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "opencv-dnn/dnn_test_support.hpp"
#include "out_of_memory_test_support.hpp"
#include "says.hpp"

namespace weir::engine_test {
namespace opencv_dnn_refusals_test {

class OpencvDnnRejects : public DnnTest {};

TEST_F(OpencvDnnRejects, FilesThatDoNotExist) {
  const Error both = get_error(OpenEngine::open(engine("caffe"), folder_.path("none.caffemodel")));
  EXPECT_EQ(both.code, Code::SPEC_MISMATCH);
  EXPECT_SAYS(both.offered, "none.prototxt is not there");
  EXPECT_EQ(both.fix, "model=net.prototxt,net.caffemodel");
  const Error graph = get_error(OpenEngine::open(engine("tensorflow"), folder_.path("none.pb")));
  EXPECT_EQ(graph.code, Code::MODEL_NOT_FOUND);
  const Error cfg = get_error(OpenEngine::open(engine("darknet"), write("a.cfg", "[net]\n")));
  EXPECT_SAYS(cfg.offered, "a.weights is not there");
}

TEST_F(OpencvDnnRejects, ToRunWithoutMemoryAndRecovers) {
  write("net.caffemodel", caffemodel({caffe_layer("none", "Power", {})}));
  const auto path = write(
      "net.prototxt",
      "layer { name: \"x\" type: \"Input\" top: \"x\"\n"
      "  input_param { shape { dim: [1, 1, 2048, 2048] } } }\n"
      "layer { name: \"y\" type: \"Power\" bottom: \"x\" top: \"y\" power_param { scale: -1 } }\n");
  expect_errors_without_memory({engine("caffe"), path, {1, 1, 2048, 2048}, folder_.path("")});
}

TEST_F(OpencvDnnRejects, ALayerThatOpencvLacksByName) {
  const Error caffe = get_error(
      open_caffe("input: \"data\" input_shape { dim: 1 dim: 3 }\n"
                 "layer { name: \"odd\" type: \"Frobnicate\" bottom: \"data\" top: \"odd\" }\n",
                 product_weights()));
  EXPECT_EQ(caffe.code, Code::MODEL_UNSUPPORTED) << caffe.message();
  EXPECT_SAYS(caffe.offered, "Frobnicate");
  const Error tensorflow = get_error(open_tensorflow(
      graph({placeholder("x", {1, 3}), TensorflowNode("odd", "Frobnicate", {"x"}).type("T")})));
  EXPECT_EQ(tensorflow.code, Code::MODEL_UNSUPPORTED) << tensorflow.message();
  EXPECT_SAYS(tensorflow.offered, "Frobnicate");
  const Error darknet = get_error(
      open_darknet("[net]\nwidth=2\nheight=2\n[frobnicate]\nsize=1\n", darknet_weights({})));
  EXPECT_EQ(darknet.code, Code::MODEL_UNSUPPORTED) << darknet.message();
  EXPECT_SAYS(darknet.message(), "frobnicate");
}

TEST_F(OpencvDnnRejects, AnActivationThatOpencvLacksByName) {
  const Error error = get_error(
      open_darknet("[net]\nbatch=1\nwidth=3\nheight=2\nchannels=2\n"
                   "[convolutional]\nfilters=1\nsize=1\nstride=1\npad=0\nactivation=frobnicate\n",
                   darknet_weights({0.5f, 2, -1})));
  EXPECT_EQ(error.code, Code::MODEL_UNSUPPORTED) << error.message();
  EXPECT_SAYS(error.offered, "frobnicate");
  EXPECT_SAYS(error.fix, "export the network to ONNX");
}

TEST_F(OpencvDnnRejects, InputsOfTextByTheirKind) {
  for (const char* name : {"models/tf/DS_CNN_S.pb", "models/audio/conv_actions_frozen.pb"}) {
    const auto path = shared_file(name);
    if (path.empty()) GTEST_SKIP() << "../shared/models is not there";
    const Error error = get_error(OpenEngine::open(engine("tensorflow"), path));
    EXPECT_EQ(error.code, Code::MODEL_UNSUPPORTED);
    EXPECT_SAYS(error.what, "wav_data");
    EXPECT_SAYS(error.offered, "string");
  }
}

TEST_F(OpencvDnnRejects, DescriptionsThatCannotBeReadByTheirLine) {
  const std::pair<const char*, const char*> texts[]{
      {"layer {\n name: \"a\"\n", "line 3: a message that is not closed"},
      {"layer {\n name: \"a\n }", "line 2: a string that is not closed"},
      {"name: \"a\"\n}", "line 2: a field name is missing"},
      {"name \"a\"", "line 1: no value for name"},
      {"name: {", "line 1: a message that is not closed"},
      {"dim: [1, 2", "line 1: no value"}};
  for (const auto& [text, words] : texts) {
    const Error error = get_error(open_caffe(text, product_weights()));
    EXPECT_EQ(error.code, Code::MODEL_INVALID);
    EXPECT_SAYS(error.offered, words);
    EXPECT_SAYS(error.offered, "net.prototxt");
  }
  std::string deep;
  for (int i = 0; i < 100; ++i) deep += "a {";
  EXPECT_SAYS(get_error(open_caffe(deep, product_weights())).offered, "nested too deeply");
  EXPECT_SAYS(get_error(open_caffe("name: \"a\"", product_weights())).what, "has no layer");
  for (const auto& [text, words] : std::vector<std::pair<std::string, std::string>>{
           {"width=3\n", "line 1"},
           {"[net\n", "a section that is not closed"},
           {"[net]\nwidth=many\n", "line 2: width=many"},
           {"[net]\nwidth=0\n", "line 2"},
           {"[net]\nwidth=3\n[convolutional]\nsize=1\n", "no height"}}) {
    const Error error = get_error(open_darknet(text, darknet_weights({})));
    EXPECT_EQ(error.code, Code::MODEL_INVALID) << text;
    EXPECT_SAYS(error.offered, words);
  }
}

TEST_F(OpencvDnnRejects, TruncatedOrInconsistentWeights) {
  const auto whole = product_weights();
  for (size_t size = 1; size < whole.size(); ++size) {
    const Error error = get_error(open_caffe(kProduct, whole.substr(0, size)));
    EXPECT_EQ(error.code, Code::MODEL_INVALID) << size << error.message();
    EXPECT_SAYS(error.offered, "net.caffemodel");
  }
  const Error lie = get_error(open_caffe(
      kProduct, caffemodel({caffe_layer("fc", "InnerProduct", {{{2, 3000000}, {1, 2, 3}}})})));
  EXPECT_SAYS(lie.offered, "a blob of 3 values whose shape requires 6000000");
  const Error huge = get_error(open_caffe(
      kProduct,
      caffemodel({caffe_layer("fc", "InnerProduct", {{{1ull << 40, 1ull << 40}, {1}}})})));
  EXPECT_EQ(huge.code, Code::MODEL_INVALID) << huge.message();
  const Error none = get_error(open_caffe(kProduct, MessageBuilder().bytes(1, "a").text()));
  EXPECT_SAYS(none.offered, "it contains no layer");
}

TEST_F(OpencvDnnRejects, TruncatedDarknetWeights) {
  const char* const cfg =
      "[net]\nwidth=3\nheight=2\nchannels=2\n"
      "[convolutional]\nbatch_normalize=1\nfilters=2\nsize=1\nstride=1\nactivation=leaky\n";
  const auto whole = darknet_weights(std::vector<float>(4 * 2 + 2 * 2, 1));
  EXPECT_TRUE(open_darknet(cfg, whole));
  for (const size_t size : {size_t{8}, size_t{20}, whole.size() / 2, whole.size() - 8}) {
    const Error error = get_error(open_darknet(cfg, whole.substr(0, size)));
    EXPECT_EQ(error.code, Code::MODEL_INVALID) << size << error.message();
    EXPECT_SAYS(error.offered, "net.weights");
  }
}

TEST_F(OpencvDnnRejects, TruncatedGraphs) {
  const auto whole =
      graph({placeholder("x", {1, 3}), TensorflowNode("y", "Relu", {"x"}).type("T")});
  for (size_t size = 1; size < whole.size(); ++size) {
    const auto model = open_tensorflow(whole.substr(0, size));
    if (model) continue;  // cut between two nodes, which is a valid graph
    EXPECT_TRUE(model.error().code == Code::MODEL_INVALID ||
                model.error().code == Code::MODEL_UNSUPPORTED ||
                model.error().code == Code::SPEC_MISMATCH)
        << size << model.error().message();
    EXPECT_FALSE(model.error().what.empty());
  }
}

TEST_F(OpencvDnnRejects, NamesThatTheNetworkLacks) {
  const Error input = get_error(open_caffe(kProduct, product_weights(), {{"inputname", "dota"}}));
  EXPECT_EQ(input.code, Code::SPEC_MISMATCH);
  EXPECT_SAYS(input.what, "inputname");
  EXPECT_EQ(input.fix, "inputname=data");
  const Error output = get_error(open_caffe(kProduct, product_weights(), {{"outputname", "prob"}}));
  EXPECT_EQ(output.code, Code::SPEC_MISMATCH);
  EXPECT_SAYS(output.needed, "one of: fc");
  const Error count = get_error(open_caffe(kProduct, product_weights(), {{"input", "3:1,3:1"}}));
  EXPECT_SAYS(count.what, "a different number of inputs");
}

TEST_F(OpencvDnnRejects, ShapesThatTheNetworkDoesNotAccept) {
  const auto model = open_caffe(kProduct, product_weights());
  ASSERT_TRUE(model);
  const auto rank = (*model)->resolve({make_tensor(WEIR_FLOAT32, {3}).info});
  ASSERT_FALSE(rank);
  EXPECT_SAYS(rank.error().difference, "rank 1 instead of 2");
  const auto size = (*model)->invoke({make_tensor(WEIR_FLOAT32, {1, 4})});
  ASSERT_FALSE(size);
  EXPECT_SAYS(size.error().difference, "dimension 1 is 4 instead of 3");
  const Error requested = get_error(open_caffe(kProduct, product_weights(), {{"input", "4:1"}}));
  EXPECT_EQ(requested.code, Code::SPEC_MISMATCH) << requested.message();
  EXPECT_SAYS(requested.offered, "float32 4:1 (data)");
  EXPECT_SAYS(requested.difference, "fc");
}

// The weights of R-Net with the description of P-Net.
TEST_F(OpencvDnnRejects, TheWeightsOfAnotherNetwork) {
  const Error error = get_error(open_caffe(
      kProduct,
      caffemodel({caffe_layer("fc", "InnerProduct", {{{4, 5}, std::vector<float>(20, 1)}})})));
  EXPECT_TRUE(error.code == Code::MODEL_INVALID || error.code == Code::SPEC_MISMATCH)
      << error.message();
  const Error none = get_error(
      open_caffe(kProduct, caffemodel({caffe_layer("other", "InnerProduct", {{{1}, {1}}})})));
  EXPECT_TRUE(none.code == Code::MODEL_INVALID || none.code == Code::SPEC_MISMATCH)
      << none.message();
}

TEST_F(OpencvDnnRejects, InconsistentFramesAndContinues) {
  const auto model = open_caffe(kProduct, product_weights());
  ASSERT_TRUE(model);
  std::vector<float> x{1, 1, 1}, y(2);
  OneToOne frames({1, 3}, x, {1, 2}, y);
  weir_tensor &in = frames.in, &out = frames.out;
  ASSERT_TRUE(frames.through(**model));
  EXPECT_EQ(y, (std::vector<float>{16, 35}));
  const auto code = [&] { return frames.get_code(**model); };
  in.bytes = 8;
  EXPECT_EQ(code(), Code::FRAME_SIZE);
  in.bytes = 12;
  out.info.shape[1] = 1;
  out.bytes = 4;
  EXPECT_EQ(code(), Code::INVOKE_FAILED);
  out.info.shape[1] = 2;
  out.bytes = 8;
  in.data = nullptr;
  EXPECT_EQ(code(), Code::FRAME_SIZE);
  in.data = x.data();
  EXPECT_EQ(code(), Code::INTERNAL) << "and goes on";
}

TEST_F(OpencvDnnRejects, InvalidOptionValues) {
  for (const auto& [key, value] : Options{{"NumThreads", "0"}, {"NumThreads", "two"}}) {
    const Error error = get_error(open_caffe(kProduct, product_weights(), {{key, value}}));
    EXPECT_EQ(error.code, Code::OPTION_VALUE);
    EXPECT_SAYS(error.offered, value);
  }
  const Error type = get_error(open_caffe(kProduct, product_weights(), {{"inputtype", "int64"}}));
  EXPECT_EQ(type.code, Code::SPEC_MISMATCH) << type.message();
  EXPECT_SAYS(type.fix, "mode=typecast");
}

}  // namespace opencv_dnn_refusals_test
}  // namespace weir::engine_test
