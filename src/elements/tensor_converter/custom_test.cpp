// tensor_converter mode=custom-code: functions that the program registers with the loaded plug-in.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <dlfcn.h>

#include <cstring>
#include <stdexcept>

#include "elements/tensor_converter/converter_test_support.hpp"
#include "weir/custom_converter.h"

namespace tensor_converter_custom_test {

using namespace weir::testing_tensor_converter;

// Looked up as a program does: this test links its own copy of the core, separate from the
// plug-in's.
void* exported(const char* name) {
  auto plugin = Ref<GstPlugin>::adopt(gst_registry_find_plugin(gst_registry_get(), "weir"));
  static void* file = dlopen(gst_plugin_get_filename(plugin.get()), RTLD_NOW);
  void* found = file ? dlsym(file, name) : nullptr;
  EXPECT_NE(found, nullptr) << name;
  return found;
}
class Registered {
 public:
  Registered(const char* name, weir_convert_function function, void* data) : name_(name) {
    const auto add =
        reinterpret_cast<decltype(&weir_converter_register)>(exported("weir_converter_register"));
    EXPECT_EQ(add(name, function, data), WEIR_OK);
  }
  Registered(const Registered&) = delete;
  Registered& operator=(const Registered&) = delete;
  ~Registered() {
    const auto remove = reinterpret_cast<decltype(&weir_converter_unregister)>(
        exported("weir_converter_unregister"));
    EXPECT_EQ(remove(name_), WEIR_OK);
  }

 private:
  const char* name_;
};

// Two uint8 tensors: the first byte of the buffer, and the number of frames so far.
int split(const weir_host* host, const char* caps, const weir_frame* in, weir_frame* out,
          void* data, weir_error* error) {
  const auto first = *static_cast<const uint8_t*>(in->tensors[0].data);
  if (first == 0xFF)
    return host->fail(error, WEIR_INVOKE_FAILED, "the first byte is 255", caps, nullptr, nullptr,
                      nullptr);
  if (first == 0xFE) return 1;
  for (uint32_t i = 0; i < 2; ++i) {
    weir_tensor& to = out->tensors[i];
    if (host->allocate(nullptr, WEIR_MEMORY_HOST, 1, 64, &to) != WEIR_OK)
      return -WEIR_OUT_OF_MEMORY;
    to.info = in->tensors[0].info;
    to.info.shape[0] = 1;
  }
  out->n_tensors = 2;
  *static_cast<uint8_t*>(out->tensors[0].data) = first;
  *static_cast<uint8_t*>(out->tensors[1].data) = static_cast<uint8_t>(++*static_cast<int*>(data));
  return WEIR_OK;
}

constexpr char kBytes[] = "application/octet-stream,framerate=10/1";

TEST(ConverterCustomCode, MakesTensorsOfAnyMedium) {
  int frames = 0;
  const Registered registered("split", split, &frames);
  for (const std::string& caps : {std::string(kBytes), video("RGB", 2, 2)}) {
    auto h = harness("mode=Custom-Code:split", caps);
    EXPECT_SAYS(caps_text(h), "dimensions=(string)1:1:1:1, types=(string)uint8");
    auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame({7, 8, 9})));
    EXPECT_EQ(content(out.get()), (Bytes{7, static_cast<uint8_t>(frames)}));
    EXPECT_SAYS(caps_text(h), "num_tensors=(int)2");
    EXPECT_SAYS(caps_text(h), "framerate=(fraction)10/1");
    EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 100 * GST_MSECOND);
  }
  EXPECT_EQ(frames, 2);
}

TEST(ConverterCustomCode, MayFailAndDrop) {
  int frames = 0;
  const Registered registered("split", split, &frames);
  auto h = harness("mode=custom-code:split", kBytes);
  EXPECT_SAYS(get_error(h, frame({0xFF})),
              "WEIR-3006: the function split failed: the first byte is 255");
  EXPECT_EQ(get_error(h, frame({0xFE})), "");
  EXPECT_SAYS(get_error(h, gst_buffer_new()), "WEIR-2004: a buffer is empty");
  EXPECT_EQ(stat(h, "dropped-error"), 2u);
  EXPECT_EQ(stat(h, "dropped-policy"), 1u);
}

// Allocates and then throws, which no C function does.
int throwing(const weir_host* host, const char*, const weir_frame*, weir_frame* out, void* data,
             weir_error*) {
  EXPECT_EQ(host->allocate(nullptr, WEIR_MEMORY_HOST, 8, 64, &out->tensors[3]), WEIR_OK);
  if (data) throw std::runtime_error("thrown in a function");
  throw 42;
}

TEST(ConverterCustomCode, AnExceptionIsReportedWithItsNameAndCounted) {
  int words = 0;
  for (int* data : {&words, static_cast<int*>(nullptr)}) {
    const Registered registered("throwing", throwing, data);
    auto h = harness("mode=custom-code:throwing", kBytes);
    const auto text = get_error(h, frame({1}));
    EXPECT_SAYS(text, "WEIR-5003: the function throwing threw an exception");
    EXPECT_SAYS(text, data ? "offered: thrown in a function" : "offered: not a std::exception");
    EXPECT_SAYS(text, "fix: catch it there and return host->fail(...)");
    EXPECT_EQ(stat(h, "dropped-error"), 1u);
    EXPECT_EQ(stat(h, "held"), 0u);
  }
}

// Returns a tensor smaller than its spec.
int cheating(const weir_host* host, const char*, const weir_frame* in, weir_frame* out, void*,
             weir_error*) {
  weir_tensor& to = out->tensors[0];
  EXPECT_EQ(host->allocate(nullptr, WEIR_MEMORY_HOST, 1, 64, &to), WEIR_OK);
  to.info = in->tensors[0].info;
  out->n_tensors = 1;
  return WEIR_OK;
}

TEST(ConverterCustomCode, ThatCheatsIsNamed) {
  const Registered registered("cheating", cheating, nullptr);
  auto h = harness("mode=custom-code:cheating", kBytes);
  const auto text = get_error(h, frame({1, 2, 3}));
  EXPECT_SAYS(
      text,
      "WEIR-5003: the function cheating produced a tensor whose size differs from its description");
  EXPECT_SAYS(text, "offered: 1 bytes\n  needed: 3 bytes for uint8 3");
  EXPECT_SAYS(text, "fix: correct the function cheating");
}

TEST(ConverterCustomCode, OfAnUnknownNameIsAnErrorAtTheFirstFrame) {
  auto h = harness("mode=custom-code:nowhere", kBytes);
  const auto text = get_error(h, frame({1}));
  EXPECT_SAYS(text, "WEIR-3011: no function is registered under this name");
  EXPECT_SAYS(text, "fix: weir_converter_register(\"nowhere\", function, data)");
  EXPECT_EQ(stat(h, "dropped-error"), 1u);
}

std::string get_warning(const char* mode) {
  auto element = Ref<GstElement>::adopt(
      GST_ELEMENT(gst_object_ref_sink(gst_element_factory_make("tensor_converter", nullptr))));
  Errors errors(element.get());
  g_object_set(element.get(), "mode", mode, nullptr);
  return errors.next_warning();
}

TEST(ConverterMode, AWrongValueIsReportedWhenItIsSet) {
  EXPECT_SAYS(get_warning("custom-code"), "WEIR-1001: the mode has no name after a colon");
  EXPECT_SAYS(get_warning("custom:x"), "WEIR-1005: tensor_converter has no such mode");
  EXPECT_SAYS(get_warning("custom-code:x"), "WEIR-3011: no function is registered");
  EXPECT_EQ(get_warning("custom-script:x"), "");
  EXPECT_EQ(get_warning(""), "");
  const Registered registered("x", split, nullptr);
  EXPECT_EQ(get_warning("custom-code:x"), "");
}

TEST(ConverterMode, WithoutANameIsIgnoredAndAnUnknownWordIsNot) {
  auto h = harness("mode=custom-code input-dim=2 input-type=uint8", kBytes);
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame({1, 2})));
  EXPECT_EQ(content(out.get()), (Bytes{1, 2}));
  EXPECT_SAYS(caps_error("mode=custom:x", kBytes), "WEIR-1005: tensor_converter has no such mode");
}

// gst_parse_launch() sets properties before the element is in a pipeline with a bus.
TEST(ConverterMode, WithoutANameIsReportedWhenABusExists) {
  const auto pipeline = lone_element(
      "videotestsrc num-buffers=2 ! video/x-raw,format=RGB,width=8,height=4 ! "
      "tensor_converter mode=custom-code ! fakesink");
  const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(pipeline.get()));
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  const auto next = [&bus] {
    const auto message = Ref<GstMessage>::adopt(gst_bus_timed_pop_filtered(
        bus.get(), 60 * GST_SECOND,
        GstMessageType(GST_MESSAGE_WARNING | GST_MESSAGE_ERROR | GST_MESSAGE_EOS)));
    return !message                                             ? "nothing"
           : GST_MESSAGE_TYPE(message.get()) == GST_MESSAGE_EOS ? "the end"
                                                                : get_text(message.get());
  };
  EXPECT_SAYS(next(), "WEIR-1001: the mode has no name after a colon");
  EXPECT_EQ(next(), "the end") << "reported once, then ignored";
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
}

}  // namespace tensor_converter_custom_test
