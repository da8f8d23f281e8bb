// tensor_if compared-value=CUSTOM: functions that the program registers with the loaded plug-in.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <dlfcn.h>

#include <stdexcept>

#include "core/tensor/tensor_header.hpp"
#include "elements/tests/branches_test_support.hpp"
#include "weir/custom_condition.hpp"

namespace weir::test {
namespace tensor_if_custom_test {

// Looked up as a program does: this test links its own copy of the core, separate from the
// plug-in's.
template <class Function>
Function exported(const char* name) {
  const auto plugin = Ref<GstPlugin>::adopt(gst_registry_find_plugin(gst_registry_get(), "weir"));
  static void* file = dlopen(gst_plugin_get_filename(plugin.get()), RTLD_NOW);
  void* found = file ? dlsym(file, name) : nullptr;
  EXPECT_NE(found, nullptr) << name;
  return reinterpret_cast<Function>(found);
}
RegisteredCondition registered(const char* name, RegisteredCondition::Function function) {
  return RegisteredCondition(
      name, std::move(function),
      exported<decltype(&weir_condition_register)>("weir_condition_register"),
      exported<decltype(&weir_condition_unregister)>("weir_condition_unregister"));
}

constexpr char kNamed[] = "tensor_if compared-value=CUSTOM compared-value-option=named";

TEST(TensorIfCustom, DecidesByAllTensorsOfTheFrame) {
  const auto named = registered("named", [](const weir_frame& frame) {
    EXPECT_EQ(frame.n_tensors, 2u);
    EXPECT_EQ(describe(frame.tensors[0].info), "uint8 2:1");
    EXPECT_EQ(describe(frame.tensors[1].info), "int16 1:3");
    EXPECT_EQ(frame.tensors[1].bytes, 6u);
    EXPECT_EQ(frame.pts, 5);
    EXPECT_EQ(frame.duration, -1);
    const auto* bytes = static_cast<const uint8_t*>(frame.tensors[0].data);
    return bytes[0] == bytes[1];
  });
  Branches element(kNamed);
  element.caps(test::tensors("uint8,int16", "2:1,1:3"));
  for (const auto& first : {Bytes{4, 4}, Bytes{4, 5}}) {
    GstBuffer* in = make_frame({first, Bytes(6)});
    GST_BUFFER_PTS(in) = 5;
    ASSERT_EQ(element.push(in), GST_FLOW_OK);
  }
  EXPECT_EQ(content(element.take("src_0").get(), 0), (Bytes{4, 4}));
  EXPECT_EQ(content(element.take("src_1").get(), 0), (Bytes{4, 5}));
  EXPECT_EQ(element.warning(), "");
  EXPECT_EQ(element.stat("bytes-copied"), 0u);
}

TEST(TensorIfCustom, GetsTheTensorsOfEachFlexibleFrame) {
  const auto named = registered("named", [](const weir_frame& frame) {
    return frame.tensors[0].bytes == static_cast<const uint8_t*>(frame.tensors[0].data)[0];
  });
  Branches element(kNamed);
  element.caps(kFlexibleBranch);
  for (const uint32_t size : {3u, 5u}) {
    TensorHeader header;
    header.format = Format::Flexible;
    header.spec = {ElementType::UInt8, Shape{size}, {}};
    Bytes bytes(kTensorHeaderBytes + size, 3);
    write_tensor_header(header,
                        std::as_writable_bytes(std::span(bytes)).first<kTensorHeaderBytes>());
    ASSERT_EQ(element.push(make_frame({bytes})), GST_FLOW_OK);
    EXPECT_EQ(content(element.take(size == 3 ? "src_0" : "src_1").get(), 0), bytes);
  }
  EXPECT_EQ(element.stat("bytes-copied"), 0u);
  element.expect_balance();
}

TEST(TensorIfCustom, CanBeRegisteredAfterTheProperties) {
  Branches element("tensor_if compared-value=CUSTOM");
  g_object_set(element.element(), "compared-value-option", "named", nullptr);
  EXPECT_SAYS(element.warning(), "WEIR-5002: no condition is registered under this name");
  element.caps(test::tensors("uint8", "1"));
  const auto named = registered("named", [](const weir_frame&) { return true; });
  EXPECT_EQ(element.push(make_frame({{1}})), GST_FLOW_OK);
  EXPECT_TRUE(element.has("src_0"));
}

TEST(TensorIfCustom, OfAnUnknownNameIsAnErrorAtTheFirstFrame) {
  const auto other = registered("other", [](const weir_frame&) { return true; });
  Branches element(kNamed);
  element.caps(test::tensors("uint8", "1"));
  EXPECT_EQ(element.error(), "");
  EXPECT_EQ(element.push(make_frame({{1}})), GST_FLOW_ERROR);
  const std::string error = element.error();
  EXPECT_SAYS(error, "WEIR-5002: no condition is registered under this name");
  EXPECT_SAYS(error, "offered: compared-value-option=named");
  EXPECT_SAYS(error, "needed: one of: other");
  EXPECT_EQ(element.stat("dropped-error"), 1u);
  element.expect_balance();
}

TEST(TensorIfCustom, ThatThrowsEndsTheStreamWithItsMessage) {
  const auto named = registered(
      "named", [](const weir_frame&) -> bool { throw std::runtime_error("no, not today"); });
  Branches element(kNamed);
  element.caps(test::tensors("uint8", "1"));
  GstBuffer* in = make_frame({{1}});
  GST_BUFFER_PTS(in) = 1500 * GST_MSECOND;
  EXPECT_EQ(element.push(in), GST_FLOW_ERROR);
  const std::string error = element.error();
  EXPECT_SAYS(error, "WEIR-5003: the condition named failed: no, not today");
  EXPECT_SAYS(error, "offered: a frame of uint8 1 at 0:00:01.500000000");
  element.expect_balance();
}

int drop(const weir_host*, const weir_frame*, int*, void*, weir_error*) {
  return 1;
}

TEST(TensorIfCustom, InCCanDropFrames) {
  const auto add = exported<decltype(&weir_condition_register)>("weir_condition_register");
  ASSERT_EQ(add("named", drop, nullptr), WEIR_OK);
  Branches element(kNamed);
  element.caps(test::tensors("uint8", "1"));
  EXPECT_EQ(element.push(make_frame({{1}})), GST_FLOW_OK);
  EXPECT_TRUE(element.added().empty());
  EXPECT_EQ(element.stat("dropped-policy"), 1u);
  const auto remove = exported<decltype(&weir_condition_unregister)>("weir_condition_unregister");
  EXPECT_EQ(remove("named"), WEIR_OK);
}

}  // namespace tensor_if_custom_test
}  // namespace weir::test
