// Tests of NNStreamer decoders as modes of tensor_decoder: sub_plugins/decoder.c is built with our
// headers, bare_decoder.c with a struct laid out by hand.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fstream>
#include <stdexcept>

#include "elements/tensor_decoder/decoder_test_support.hpp"
#include "nnstreamer_plugin_api_decoder.h"
#include "sub_plugin_test_support.hpp"
#include "tensor_decoder_custom.h"

namespace weir::testing_tensor_decoder {
namespace sub_plugin_decoders_test {

const std::string kThree = tensor("uint8", "3");

std::string text(const Bytes& bytes) {
  return {bytes.begin(), bytes.end()};
}
std::string refusal(const std::string& mode) {
  return get_error("mode=" + mode, kThree, {1, 2, 3});
}
std::string message(const std::string& what) {
  return get_error("mode=adding option1=" + what, kThree, {1, 2, 3});
}

TEST(SubPluginDecoder, IsAModeOfTensorDecoder) {
  auto h = harness("mode=adding option2=5", kThree);
  EXPECT_EQ(decoded(h, frame(Bytes{1, 2, 253})), (Bytes{6, 7, 2}));
  EXPECT_SAYS(caps_text(h), "application/octet-stream, tensors=(int)1, framerate=(fraction)30/1");
  EXPECT_EQ(stat(h, "consumed"), 1u);
  auto second = harness("mode=adding option2=1", kThree);
  EXPECT_EQ(decoded(second, frame(Bytes{1, 2, 3})), (Bytes{2, 3, 4})) << "each has its own";
  EXPECT_EQ(decoded(h, frame(Bytes{1, 2, 3})), (Bytes{6, 7, 8}));
}

TEST(SubPluginDecoder, NeedsNoHeaderAndNoLibraryOfWeir) {
  auto h = harness("mode=bare", tensors("uint8,int16", "3,2:1:2"));
  GstBuffer* in = frame(Bytes{1, 2, 3});
  const auto second = Ref<GstBuffer>::adopt(frame(std::vector<int16_t>{1, 256, 2, 3}));
  gst_buffer_append_memory(in, gst_memory_ref(gst_buffer_peek_memory(second.get(), 0)));
  EXPECT_EQ(text(decoded(h, in)),
            "format 0, 2 tensors; type 5, 3:0:0, 3 bytes, sum 6; type 2, 2:1:2, 8 bytes, sum 7");
  EXPECT_SAYS(caps_text(h), "text/x-raw, format=(string)utf8, framerate=(fraction)30/1");
}

TEST(SubPluginDecoder, ReceivesMoreThanSixteenTensors) {
  std::string types = "uint8", dimensions = "1";
  for (int i = 1; i < 18; ++i) types += ",uint8", dimensions += "," + std::to_string(i + 1);
  auto h = harness("mode=bare", tensors(types, dimensions));
  Bytes bytes(18 * 19 / 2, 1);
  const std::string out = text(decoded(h, frame(bytes)));
  EXPECT_SAYS(out, "format 0, 18 tensors; type 5, 1:0:0, 1 bytes, sum 1;");
  EXPECT_TRUE(out.ends_with("type 5, 17:0:0, 17 bytes, sum 17; type 5, 18:0:0, 18 bytes, sum 18"))
      << out;
}

TEST(SubPluginDecoder, ReceivesFlexibleTensorsWithTheirHeaders) {
  const Harness h{
      gst_harness_new_parse("tensor_converter ! other/tensors,format=flexible ! tensor_decoder "
                            "mode=bare")};
  gst_harness_set_src_caps_str(h.get(), video("GRAY8", 4, 2).c_str());
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(Bytes(8, 0))));
  const std::string reported = text(content(out.get()));
  EXPECT_SAYS(reported, "format 1, 1 tensors; type 5, 1:4:2, 136 bytes, sum ");
}

TEST(SubPluginDecoder, IsListed) {
  auto h = harness("mode=adding", kThree);
  gchar* raw = nullptr;
  g_object_get(find_element(h, "tensor_decoder").get(), "sub-plugins", &raw, nullptr);
  const weir::gst::UniqueText list{raw};
  const std::string names = "," + std::string(list.get()) + ",";
  for (const char* name : {",adding,", ",bare,", ",image_labeling,"}) EXPECT_SAYS(names, name);
}

TEST(SubPluginDecoder, WarnsAboutRejectedOptionsAndContinues) {
  const auto element = lone_element("tensor_decoder mode=adding option1=x option3=y");
  Errors errors(element.get());
  EXPECT_EQ(gst_element_set_state(element.get(), GST_STATE_PAUSED), GST_STATE_CHANGE_SUCCESS);
  EXPECT_SAYS(errors.next_warning(),
              "WEIR-1004: the decoder adding does not accept an option and continues without it\n  "
              "offered: option3=y");
  gst_element_set_state(element.get(), GST_STATE_NULL);
}

TEST(SubPluginDecoder, ReportsWhatIsWrongWithItsCaps) {
  EXPECT_SAYS(message("no-caps"), "WEIR-2001: the decoder adding does not accept these tensors");
  EXPECT_SAYS(message("no-caps"), "offered: 1 tensor: uint8 3");
  EXPECT_SAYS(message("any-caps"),
              "WEIR-5003: the decoder adding returned caps without any media type");
  EXPECT_SAYS(message("any-caps"), "offered: ANY");
  EXPECT_SAYS(message("empty-caps"), "offered: EMPTY");
  EXPECT_SAYS(message("no-caps-at-all"), "offered: something else");
}

TEST(SubPluginDecoder, ReportsWhatIsWrongWithAFrame) {
  EXPECT_SAYS(message("error"),
              "WEIR-5003: the decoder adding failed on a frame\n  offered: error");
  EXPECT_SAYS(message("not-negotiated"), "offered: not-negotiated");
  EXPECT_SAYS(message("nothing"),
              "WEIR-5003: the decoder adding returned success without an output\n  offered: a "
              "buffer without memory");
  EXPECT_SAYS(message("picture"),
              "WEIR-2004: the output of the decoder is smaller than a picture of its caps");
  EXPECT_SAYS(message("picture"), "offered: 3 bytes\n  needed: 32 bytes");
}

TEST(SubPluginDecoder, CanDropFrames) {
  auto h = harness("mode=adding option1=drop", kThree);
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{1, 2, 3})), GST_FLOW_OK);
  EXPECT_EQ(stat(h, "dropped-policy"), 1u);
  EXPECT_EQ(gst_harness_buffers_in_queue(h.get()), 0u);
}

TEST(SubPluginDecoder, IsRejectedWithAMessage) {
  const auto file = [](const std::string& name) {
    return test::built_sub_plugin("libnnstreamer_decoder_" + name + ".so").string();
  };
  EXPECT_SAYS(refusal("closed"),
              "WEIR-5003: the decoder closed cannot be opened\n  offered: its init returned FALSE");
  EXPECT_SAYS(refusal("silent"), "WEIR-3007: the sub-plugin " + file("silent") +
                                     " does not register itself\n  offered: it registered nothing");
  for (int i = 0; i < 2; ++i)
    EXPECT_SAYS(refusal("renamed"), "offered: it registered the decoder other")
        << "the second time";
  EXPECT_SAYS(refusal("renamed"), "needed: the decoder renamed");
  EXPECT_SAYS(refusal("nameless"),
              "a decoder was rejected: the decoder without a name lacks required members (without "
              "modename)");
  EXPECT_SAYS(refusal("halved"),
              "the decoder halved lacks required members (without getOutCaps, decode)");
  EXPECT_SAYS(refusal("auto"), "a decoder was rejected: this name is reserved (auto)");
  EXPECT_SAYS(refusal("reserved"), "a decoder was rejected: this name is reserved (Auto)");
  harness("mode=bare", kThree);
  EXPECT_SAYS(refusal("copied"),
              "a decoder was rejected: another decoder already has this name (bare)");
}

TEST(SubPluginDecoder, IsSearchedInItsFoldersOnly) {
  for (const char* mode : {"../adding", "sub/adding", "addng"}) {
    EXPECT_SAYS(refusal(mode), "WEIR-3010: no decoder has this name");
  }
  EXPECT_SAYS(refusal("addng"), "did you mean adding?");
  EXPECT_SAYS(refusal("addng"), "fix: mode=adding");
}

TEST(SubPluginDecoder, ComesFromTheFirstFolderThatContainsIt) {
  const test::SubPluginFolder folder("NNSTREAMER_DECODERS");
  std::ofstream(folder / "libnnstreamer_decoder_early.so") << "not a shared object";
  std::filesystem::create_directory(folder / "libnnstreamer_decoder_adding.so");
  EXPECT_SAYS(refusal("early"), "WEIR-3007: the module " +
                                    (folder / "libnnstreamer_decoder_early.so").string() +
                                    " cannot be used");
  EXPECT_SAYS(refusal("early"), "needed: a shared object for this machine");
  EXPECT_EQ(refusal("adding"), "") << "a folder of that name is none";
}

TEST(SubPluginDecoder, MustNotBeASymbolicLinkUnlessEnabled) {
  const test::SubPluginFolder folder("NNSTREAMER_DECODERS");
  const auto link = folder / "libnnstreamer_decoder_linked.so";
  const auto target = folder / "libnnstreamer_decoder_file.so";
  std::ofstream(target) << "not a shared object";
  std::filesystem::create_symlink(target, link);
  EXPECT_SAYS(refusal("linked"), "WEIR-3007: a sub-plugin's file must not be a symbolic link");
  EXPECT_SAYS(refusal("linked"), "offered: " + link.string() + " -> " + target.string());
  EXPECT_SAYS(refusal("linked"), "enable_symlink=true in the group [common] of nnstreamer.ini");
  setenv("NNSTREAMER_common_enable_symlink", "yes", 1);
  EXPECT_SAYS(refusal("linked"), "needed: a shared object for this machine");
  unsetenv("NNSTREAMER_common_enable_symlink");
}

TEST(SubPluginDecoder, NeedsTheLibraryWithItsFunctions) {
  const std::string library = std::getenv("WEIR_NNSTREAMER_LIBRARY");
  const test::SubPluginFolder folder("NNSTREAMER_DECODERS");
  std::ofstream(folder / "libnnstreamer_decoder_lonely.so") << "never opened";
  setenv("WEIR_NNSTREAMER_LIBRARY", "/nowhere/libnnstreamer.so", 1);
  const auto error = refusal("lonely");
  for (const char* path : {"libnnstreamer.so", ""}) {
    setenv("WEIR_NNSTREAMER_LIBRARY", path, 1);
    EXPECT_SAYS(refusal("lonely"),
                "WEIR-1004: the path of the library with NNStreamer's functions "
                "is not absolute\n  offered: \"" +
                    std::string(path) + "\"");
  }
  setenv("WEIR_NNSTREAMER_LIBRARY", library.c_str(), 1);
  EXPECT_SAYS(error, "WEIR-3007: the library with the functions that sub-plugins for NNStreamer");
  EXPECT_SAYS(error, "offered: /nowhere/libnnstreamer.so: cannot open shared object file");
  EXPECT_SAYS(error, "fix: install it, or name it: WEIR_NNSTREAMER_LIBRARY=");
}

TEST(SubPluginDecoder, IsNotSearchedIfDisabled) {
  const test::SubPluginFolder folder("NNSTREAMER_DECODERS");
  std::ofstream(folder / "libnnstreamer_decoder_off.so") << "never opened";
  EXPECT_SAYS(refusal("off"), "WEIR-3007");
  setenv("WEIR_NNSTREAMER_ENABLE", "no", 1);
  EXPECT_SAYS(refusal("off"), "WEIR-3010: no decoder has this name");
  setenv("WEIR_NNSTREAMER_ENABLE", "yes", 1);
}

TEST(SubPluginDecoder, IsFoundByItsName) {
  const auto find = WEIR_LIBRARY(nnstreamer_decoder_find);
  const auto* adding = find("adding");
  ASSERT_NE(adding, nullptr);
  EXPECT_STREQ(adding->modename, "adding");
  EXPECT_EQ(find("nothing-of-this-name"), nullptr);
  EXPECT_EQ(find(nullptr), nullptr);
}

// The number of tensors and the first byte.
int count(const GstTensorMemory* input, const GstTensorsConfig* config, void* data,
          GstBuffer* out) {
  if (data) return *static_cast<int*>(data);
  auto* bytes = static_cast<uint8_t*>(g_malloc(2));
  bytes[0] = static_cast<uint8_t>(config->info.num_tensors);
  bytes[1] = *static_cast<const uint8_t*>(input[0].data);
  gst_buffer_append_memory(
      out, gst_memory_new_wrapped(GstMemoryFlags(0), bytes, 2, 0, 2, bytes, g_free));
  return GST_FLOW_OK;
}

TEST(CustomCodeDecoder, IsAFunctionOfTheProgram) {
  const auto add = WEIR_LIBRARY(nnstreamer_decoder_custom_register);
  const auto remove = WEIR_LIBRARY(nnstreamer_decoder_custom_unregister);
  ASSERT_EQ(add("count", count, nullptr), 0);
  for (const char* mode : {"custom-code", "Custom-Code"}) {
    auto h = harness(std::string("option1=count mode=") + mode, kThree);
    EXPECT_EQ(decoded(h, frame(Bytes{9, 2, 3})), (Bytes{1, 9}));
    EXPECT_EQ(caps_text(h), "application/octet-stream, framerate=(fraction)30/1");
  }
  EXPECT_EQ(add("count", count, nullptr), -EINVAL) << "taken";
  EXPECT_EQ(add("auto", count, nullptr), -EINVAL);
  EXPECT_EQ(add("", count, nullptr), -EINVAL);
  EXPECT_EQ(add("none", nullptr, nullptr), -EINVAL);
  EXPECT_EQ(add(nullptr, count, nullptr), -EINVAL);
  EXPECT_EQ(remove("count"), 0);
  EXPECT_EQ(remove("count"), -EINVAL);
}

TEST(CustomCodeDecoder, MustBeRegisteredAndProduceABuffer) {
  const auto add = WEIR_LIBRARY(nnstreamer_decoder_custom_register);
  const auto remove = WEIR_LIBRARY(nnstreamer_decoder_custom_unregister);
  int flow = GST_FLOW_ERROR;
  ASSERT_EQ(add("failing", count, &flow), 0);
  const std::string missing = get_error("mode=custom-code option1=absent", kThree, {1, 2, 3});
  EXPECT_SAYS(missing, "WEIR-5002: no decoder is registered under this name");
  EXPECT_SAYS(missing, "needed: one of: failing");
  EXPECT_SAYS(get_error("mode=custom-code"), "offered: mode=custom-code option1=");
  EXPECT_SAYS(get_error("mode=custom-code option1=failing", kThree, {1, 2, 3}),
              "WEIR-5003: the function failing failed on a frame\n  offered: error");
  flow = GST_FLOW_OK;
  EXPECT_SAYS(get_error("mode=custom-code option1=failing", kThree, {1, 2, 3}),
              "the function failing returned success without an output");
  remove("failing");
}

int throwing(const GstTensorMemory*, const GstTensorsConfig*, void*, GstBuffer*) {
  throw std::runtime_error("no such label");
}

TEST(CustomCodeDecoder, ReportsAnExceptionWithItsName) {
  ASSERT_EQ(WEIR_LIBRARY(nnstreamer_decoder_custom_register)("throwing", throwing, nullptr), 0);
  const auto text = get_error("mode=custom-code option1=throwing", kThree, {1, 2, 3});
  EXPECT_SAYS(text, "WEIR-5003: the function throwing threw an exception");
  EXPECT_SAYS(text, "offered: no such label");
  WEIR_LIBRARY(nnstreamer_decoder_custom_unregister)("throwing");
}

}  // namespace sub_plugin_decoders_test
}  // namespace weir::testing_tensor_decoder
