// tensor_debug in a harness: frames pass unchanged, and each way of logging them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/element_test_support.hpp"
#include "gstcpp/buffer/query_meta.hpp"

namespace tensor_debug_test {

using namespace weir::test;

constexpr char kDebug[] = "tensor_debug";

Harness debug(const std::string& properties,
              const std::string& caps = tensors("uint8,int16", "3,2")) {
  return make_harness("tensor_debug name=d " + properties, caps);
}
// What `run` writes to standard error.
template <class F>
std::string console(F&& run) {
  testing::internal::CaptureStderr();
  run();
  return testing::internal::GetCapturedStderr();
}
std::vector<std::string> last_lines(const Harness& h) {
  const auto structure = stats(find_element(h, kDebug).get());
  const GValue* list = gst_structure_get_value(structure.get(), "last-lines");
  std::vector<std::string> out;
  for (guint i = 0; i < gst_value_array_get_size(list); ++i)
    out.emplace_back(g_value_get_string(gst_value_array_get_value(list, i)));
  return out;
}

TEST(TensorDebug, PassesBuffersOfEveryFormatUnchanged) {
  for (const std::string& caps :
       {tensors("uint8", "4"), std::string("other/tensors,format=flexible,framerate=30/1"),
        std::string("other/tensors,format=sparse,framerate=30/1")}) {
    auto h = debug("silent=false output-method=circularbuf capability=always", caps);
    // The size fits none of the caps, which tensor_debug must ignore.
    GstBuffer* in = frame(Bytes{1, 2});
    auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
    EXPECT_EQ(out.get(), in);
    EXPECT_EQ(stat(h, kDebug, "consumed"), 1u);
    EXPECT_EQ(stat(h, kDebug, "bytes-copied"), 0u);
  }
}

TEST(TensorDebug, LogsNothingByDefault) {
  EXPECT_EQ(console([] {
              auto h = debug("capability=always output-method=console-error+gstdebug-error");
              gst_buffer_unref(gst_harness_push_and_pull(h.get(), frame(Bytes(7))));
            }),
            "");
  EXPECT_EQ(console([] {
              auto h = debug("silent=false capability=disabled");
              gst_buffer_unref(gst_harness_push_and_pull(h.get(), frame(Bytes(7))));
            }),
            "");
  EXPECT_EQ(console([] {
              auto h = debug("silent=false capability=always output-method=disabled");
              gst_buffer_unref(gst_harness_push_and_pull(h.get(), frame(Bytes(7))));
            }),
            "");
}

TEST(TensorDebug, HasALevelOnTheConsole) {
  const struct {
    const char *method, *word;
  } cases[] = {{"console-info", "info"}, {"console-warn", "warning"}, {"console-error", "error"}};
  for (const auto& c : cases)
    EXPECT_EQ(console([&] {
                auto h =
                    debug(std::string("silent=false capability=updates output-method=") + c.method);
                gst_buffer_unref(gst_harness_push_and_pull(h.get(), frame(Bytes(7))));
              }),
              std::string("d: ") + c.word + ": 2 tensors: uint8 3, int16 2 at 30/1\n");
}

TEST(TensorDebug, LogsTheWholeCapsWhenTheyChange) {
  auto h = debug("silent=false output-method=circularbuf");
  gst_harness_set_src_caps_str(h.get(), "other/tensors,format=flexible,framerate=5/1");
  gst_buffer_unref(gst_harness_push_and_pull(h.get(), frame(Bytes(7))));
  const auto lines = last_lines(h);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_SAYS(lines[0],
              "2 tensors: uint8 3, int16 2 at 30/1: other/tensors, format=(string)static");
  EXPECT_EQ(lines[1],
            "flexible tensors at 5/1: other/tensors, format=(string)flexible, "
            "framerate=(fraction)5/1");
}

TEST(TensorDebug, LogsTheSelectedMetadataOfEachFrame) {
  auto h = debug(
      "silent=false output-method=circularbuf capability=always "
      "metadata=timestamp+queryserver",
      tensors("uint8", "7"));
  GstBuffer* in = frame(Bytes(7), 1500 * GST_MSECOND);
  ASSERT_TRUE(weir::gst::set_client(in, -4));
  for (GstBuffer* b : {in, frame(Bytes(7))})
    gst_buffer_unref(gst_harness_push_and_pull(h.get(), b));
  const auto lines = last_lines(h);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(
      lines[1],
      "frame 0: 1 memory, 7 bytes, pts 0:00:01.500000000, dts none, duration none, client -4");
  EXPECT_EQ(lines[2], "frame 1: 1 memory, 7 bytes, pts none, dts none, duration none, no client");
}

TEST(TensorDebug, KeepsTheLast64Lines) {
  auto h = debug("silent=false output-method=circularbuf capability=always");
  for (int i = 0; i < 100; ++i)
    gst_buffer_unref(gst_harness_push_and_pull(h.get(), frame(Bytes(7))));
  const auto lines = last_lines(h);
  ASSERT_EQ(lines.size(), 64u);
  EXPECT_EQ(lines.front().substr(0, 9), "frame 36:");
  EXPECT_EQ(lines.back().substr(0, 9), "frame 99:");
}

struct Logged {
  std::vector<std::pair<GstDebugLevel, std::string>> lines;
};
void take_log(GstDebugCategory* category, GstDebugLevel level, const gchar*, const gchar*, gint,
              GObject*, GstDebugMessage* message, gpointer user) {
  const std::string text = gst_debug_message_get(message);
  if (text.starts_with("input caps")) return;  // what each element logs of its stream
  if (g_strcmp0(gst_debug_category_get_name(category), kDebug) == 0)
    static_cast<Logged*>(user)->lines.emplace_back(level, text);
}

TEST(TensorDebug, HasALevelInTheLogOfGStreamer) {
  const struct {
    const char* method;
    GstDebugLevel level;
  } cases[] = {{"gstdebug-info", GST_LEVEL_INFO},
               {"gstdebug-warn", GST_LEVEL_WARNING},
               {"gstdebug-error", GST_LEVEL_ERROR}};
  for (const auto& c : cases) {
    Logged logged;
    (gst_debug_add_log_function)(take_log, &logged, nullptr);
    gst_debug_set_threshold_for_name(kDebug, GST_LEVEL_INFO);
    console([&] {
      auto h = debug(std::string("silent=false capability=updates output-method=") + c.method);
      gst_buffer_unref(gst_harness_push_and_pull(h.get(), frame(Bytes(7))));
    });
    gst_debug_unset_threshold_for_name(kDebug);
    (gst_debug_remove_log_function_by_data)(&logged);
    ASSERT_EQ(logged.lines.size(), 1u) << c.method;
    EXPECT_EQ(logged.lines[0].first, c.level);
    EXPECT_EQ(logged.lines[0].second, "2 tensors: uint8 3, int16 2 at 30/1");
  }
}

TEST(TensorDebug, HasTheDocumentedValues) {
  auto h = debug("");
  const auto element = find_element(h, kDebug);
  guint method = 0, metadata = 9;
  gint capability = 0;
  g_object_get(element.get(), "output-method", &method, "metadata", &metadata, "capability",
               &capability, nullptr);
  EXPECT_EQ(method, 0x11u);
  EXPECT_EQ(metadata, 0u);
  EXPECT_EQ(capability, 2);
  const std::pair<const char*, guint> values[] = {
      {"disabled", 0},          {"console-info", 0x11},  {"console-warn", 0x12},
      {"console-error", 0x13},  {"gstdebug-info", 0x24}, {"gstdebug-warn", 0x28},
      {"gstdebug-error", 0x2C}, {"circularbuf", 0x100},  {"filewrite", 0x200}};
  for (const auto& [name, value] : values) {
    gst_util_set_object_arg(G_OBJECT(element.get()), "output-method", name);
    g_object_get(element.get(), "output-method", &method, nullptr);
    EXPECT_EQ(method, value) << name;
  }
}

TEST(TensorDebug, RejectsOtherTensorAndVideo) {
  for (const char* caps : {"other/tensor,dimension=(string)2,type=uint8,framerate=30/1",
                           "video/x-raw,format=RGB,width=2,height=2,framerate=30/1"}) {
    auto h = debug("", caps);
    EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes(2))), GST_FLOW_NOT_NEGOTIATED);
  }
}

}  // namespace tensor_debug_test
