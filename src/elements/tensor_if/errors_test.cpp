// tensor_if: rejected settings and frames, and their error texts.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/tensor_header.hpp"
#include "elements/tests/branches_test_support.hpp"

namespace weir::test {
namespace tensor_if_errors_test {

constexpr char kCaps[] =
    "other/tensors,format=static,num_tensors=2,dimensions=(string)\"3:4,2\",types=(string)\"uint8,"
    "uint8\",framerate=30/1";
GstBuffer* frame() {
  return make_frame({Bytes(12), Bytes(2)});
}

std::string at_the_start(const std::string& properties) {
  Branches element("tensor_if " + properties);
  EXPECT_FALSE(element.started()) << properties;
  return element.error();
}
std::string at_the_first_frame(const std::string& properties, GstBuffer* buffer = frame()) {
  Branches element("tensor_if " + properties);
  EXPECT_TRUE(element.started());
  element.caps(kCaps);
  EXPECT_EQ(element.error(), "");
  EXPECT_EQ(element.push(buffer), GST_FLOW_ERROR);
  EXPECT_EQ(element.stat("dropped-error"), 1u);
  element.expect_balance();
  return element.error();
}

TEST(TensorIfRejects, TyposAtTheStart) {
  EXPECT_SAYS(at_the_start("supplied-value=1O compared-value-option=0,0"), "    1O\n    ^");
  EXPECT_SAYS(at_the_start("supplied-value=1 compared-value-option=0.0,0"),
              "WEIR-1001: compared-value-option cannot be read");
  EXPECT_SAYS(at_the_start("supplied-value=1 compared-value-option=0"), "    0\n     ^");
  EXPECT_SAYS(at_the_start("supplied-value=1 compared-value-option=0,0 then=TENSORPICK "
                           "then-option=\"0;1\""),
              "WEIR-1001: then-option cannot be read");
  EXPECT_SAYS(at_the_start("compared-value=TENSOR_AVERAGE_VALUE compared-value-option=x"),
              "    x\n    ^");
}

TEST(TensorIfRejects, NothingBeforeAFrameBecauseOfPlaceholderCaps) {
  Branches element(
      "tensor_if compared-value-option=2:3,1 supplied-value=0 operator=EQ then=TENSORPICK "
      "then-option=1");
  element.caps(
      "other/"
      "tensors,format=static,num_tensors=1,dimensions=(string)1,types=(string)uint8,framerate=30/"
      "1");
  EXPECT_EQ(element.error(), "");
  element.caps(
      "other/"
      "tensors,format=static,num_tensors=2,dimensions=(string)\"2,3:4\",types=(string)\"uint8,"
      "uint8\",framerate=30/1");
  EXPECT_EQ(element.push(make_frame({Bytes(2), Bytes(12)})), GST_FLOW_OK);
  EXPECT_TRUE(element.has("src_0"));
}

TEST(TensorIfRejects, MissingPropertiesAtTheFirstFrame) {
  EXPECT_SAYS(at_the_first_frame(""), "WEIR-1004: tensor_if needs to know what to compare\n");
  EXPECT_SAYS(at_the_first_frame("supplied-value=1"), "no compared-value-option");
  EXPECT_SAYS(at_the_first_frame("compared-value-option=0,0"), "0 numbers in supplied-value");
  EXPECT_SAYS(at_the_first_frame("compared-value-option=0,0 operator=RANGE_EXCLUSIVE "
                                 "supplied-value=1"),
              "1 numbers in supplied-value");
  EXPECT_SAYS(at_the_first_frame("compared-value=CUSTOM"), "the name of a registered function");
  EXPECT_SAYS(at_the_first_frame("compared-value-option=0,0 supplied-value=1 else=TENSORPICK"),
              "else=TENSORPICK needs a list of tensors");
}

TEST(TensorIfRejects, MissingTensorsAtTheFirstFrame) {
  const std::string element = at_the_first_frame("supplied-value=1 compared-value-option=1:4,0");
  EXPECT_SAYS(element, "WEIR-1004: compared-value-option names an element that does not exist");
  EXPECT_SAYS(element, "coordinate 4 in dimension 1");
  EXPECT_SAYS(element, "tensor 0 is uint8 3:4");
  EXPECT_SAYS(at_the_first_frame("supplied-value=1 compared-value-option=0,2"),
              "there are 2 tensors");
  EXPECT_SAYS(at_the_first_frame("supplied-value=1 compared-value=TENSOR_AVERAGE_VALUE "
                                 "compared-value-option=5"),
              "index 5");
  EXPECT_SAYS(at_the_first_frame("supplied-value=1 compared-value-option=0,0 then=TENSORPICK "
                                 "then-option=0,9"),
              "then-option names a tensor that does not exist");
}

TEST(TensorIfRejects, BuffersOfTheWrongSize) {
  const std::string properties = "supplied-value=1 compared-value-option=0,0";
  EXPECT_SAYS(at_the_first_frame(properties, make_frame({Bytes(12), Bytes(1)})),
              "WEIR-2004: the size of a buffer does not match its caps");
  EXPECT_SAYS(at_the_first_frame(properties, make_frame({Bytes(13)})), "13 bytes in 1 memory");
  EXPECT_SAYS(at_the_first_frame(properties, gst_buffer_new()), "the buffer is too small");
}

TEST(TensorIfRejects, AStreamWithoutAnyOutput) {
  Branches element("tensor_if supplied-value=1 compared-value-option=0,0 then=SKIP else=SKIP");
  element.caps(kCaps);
  EXPECT_EQ(element.push(frame()), GST_FLOW_OK);
  element.send(gst_event_new_eos());
  const std::string error = element.error();
  EXPECT_SAYS(error, "WEIR-2003: the stream ended without any output");
  EXPECT_SAYS(error, "offered: frames without output: 1");
  EXPECT_SAYS(error, "fix: check the properties that select the output");
}

TEST(TensorIfRejects, BuffersOfFlexibleStreamsWithoutHeaders) {
  Branches element("tensor_if supplied-value=1 compared-value-option=0,0");
  element.caps(kFlexibleBranch);
  EXPECT_EQ(element.push(frame()), GST_FLOW_ERROR);
  EXPECT_SAYS(element.error(), "WEIR-2005");
  element.expect_balance();
}

TEST(TensorIfRejects, SparseTensorsOfFlexibleStreams) {
  TensorHeader header;
  header.format = Format::Sparse;
  header.spec = {ElementType::UInt8, Shape{100}, {}};
  header.nonzero_count = 1;
  Bytes bytes(kTensorHeaderBytes + 5, 1);  // one value and its place
  write_tensor_header(header, std::as_writable_bytes(std::span(bytes)).first<kTensorHeaderBytes>());
  Branches element("tensor_if supplied-value=1 compared-value-option=0,0");
  element.caps(kFlexibleBranch);
  EXPECT_EQ(element.push(make_frame({bytes})), GST_FLOW_ERROR);
  const std::string error = element.error();
  EXPECT_SAYS(error, "the tensor to compare is not dense");
  EXPECT_SAYS(error, "offered: uint8 100 in 5 bytes");
  EXPECT_SAYS(error, "tensor_sparse_dec ! tensor_if");
  element.expect_balance();
}

// Frames leave as they came: no headers are added for a peer that prefers flexible tensors.
TEST(TensorIfRejects, PeersThatTakeFlexibleTensorsOnly) {
  Branches element("tensor_if supplied-value=0 compared-value-option=0,0",
                   {{"src_0", "other/tensors,format=flexible"}});
  element.caps(kCaps);
  EXPECT_EQ(element.push(frame()), GST_FLOW_NOT_NEGOTIATED);
  EXPECT_SAYS(element.error(),
              "WEIR-2001: the element downstream of src_0 does not accept its output");
}

}  // namespace tensor_if_errors_test
}  // namespace weir::test
