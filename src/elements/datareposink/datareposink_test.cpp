// datareposink: the bytes of the files and of the JSON file, and what keeps it from recording.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/datareposink/datarepo_test_support.hpp"

#include <sys/stat.h>

#include "elements/tests/many_tensors_test_support.hpp"

namespace datareposink_test {

using namespace weir::test;

constexpr char kBytes[] = "application/octet-stream";

class Datareposink : public DatarepoTest {
 protected:
  // Pushes buffers to the element, which then goes to NULL.
  std::string record(const std::string& caps, const std::vector<std::vector<Bytes>>& buffers) {
    const auto h = make_harness(sink(), caps);
    Errors errors(h);
    for (const auto& memories : buffers)
      if (gst_harness_push(h.get(), buffer_of(memories)) != GST_FLOW_OK) break;
    std::string error = errors.next();
    return error;
  }
  // Plays `source` into this element and into a filesink.
  void expect_bytes_of_filesink(const std::string& source) {
    EXPECT_EQ(error_of_pipeline(source + " ! tee name=t ! queue ! " + sink() +
                                " t. ! queue ! filesink location=" + path("reference")),
              "");
    EXPECT_FALSE(read("data").empty());
    EXPECT_EQ(read("data"), read("reference"));
  }
  static std::string start_error_of(const std::string& properties) {
    const auto element = lone_element("datareposink " + properties);
    Errors errors(element.get());
    EXPECT_EQ(gst_element_set_state(element.get(), GST_STATE_READY), GST_STATE_CHANGE_FAILURE);
    std::string error = errors.next();
    gst_element_set_state(element.get(), GST_STATE_NULL);
    return error;
  }
  std::string caps_error_of(const std::string& properties, const std::string& caps) {
    return start_error("datareposink " + properties, caps);
  }
};

TEST_F(Datareposink, WritesStaticTensorsInOrderWithoutHeaders) {
  const std::string caps = tensors("uint8,int16", "3,2", "10/1");
  EXPECT_EQ(record(caps, {{{1, 2, 3}, {4, 0, 5, 0}}, {{6, 7, 8}, {9, 0, 10, 0}}}), "");
  EXPECT_EQ(bytes_of(read("data")), (Bytes{1, 2, 3, 4, 0, 5, 0, 6, 7, 8, 9, 0, 10, 0}));
  EXPECT_EQ(read("data.json"),
            "{\n"
            "  \"gst_caps\" : \"other/tensors, format=(string)static, num_tensors=(int)2, "
            "dimensions=(string)\\\"3\\\\,2\\\", types=(string)\\\"uint8\\\\,int16\\\", "
            "framerate=(fraction)10/1\",\n"
            "  \"total_samples\" : 2,\n"
            "  \"sample_size\" : 7\n"
            "}");
}

TEST_F(Datareposink, WritesTensorsOfOneMemory) {
  EXPECT_EQ(record(tensors("uint8,uint8", "3,2"), {{{1, 2, 3, 4, 5}}}), "");
  EXPECT_EQ(bytes_of(read("data")), (Bytes{1, 2, 3, 4, 5}));
}

// The 16th memory of such a frame begins with a header that lists the tensors in it.
TEST_F(Datareposink, WritesMoreThan16TensorsWithoutTheirPackedHeader) {
  for (const bool is_flexible : {false, true}) {
    const Sweep sweep{20, 20, is_flexible};
    const auto all = make_range(0, 20);
    EXPECT_EQ(record(make_caps(sweep, all), {make_memories(sweep, all)}), "");
    std::vector<Bytes> expected;
    for (const size_t tensor : all) expected.push_back(make_tensor(sweep, tensor));
    EXPECT_EQ(bytes_of(read("data")), joined(expected)) << is_flexible;
  }
}

// Two tensors, then one, each after its header.
TEST_F(Datareposink, ListsWhereFlexibleTensorsAre) {
  const Sweep sweep{3, 3, true};
  const Bytes a = make_chunk(sweep, 0), b = make_chunk(sweep, 1), c = make_chunk(sweep, 2);
  EXPECT_EQ(record(make_caps(sweep, {0}), {{a, b}, {c}}), "");
  EXPECT_EQ(bytes_of(read("data")), joined({a, b, c}));
  const auto number = [](size_t value) { return std::to_string(value); };
  EXPECT_EQ(read("data.json"),
            "{\n"
            "  \"gst_caps\" : \"other/tensors, format=(string)flexible, "
            "framerate=(fraction)30/1\",\n"
            "  \"total_samples\" : 2,\n"
            "  \"sample_offset\" : [\n    0,\n    " +
                number(a.size() + b.size()) + "\n  ],\n  \"tensor_size\" : [\n    " +
                number(a.size()) + ",\n    " + number(b.size()) + ",\n    " + number(c.size()) +
                "\n  ],\n"
                "  \"tensor_count\" : [\n    0,\n    2\n  ]\n}");
}

// uint8 0:0:9:0:0:7 has two values that are not 0: 128 + 2 * (1 + 4) bytes.
TEST_F(Datareposink, WritesSparseTensorsWithTheirHeaders) {
  EXPECT_EQ(record(tensors("uint8", "6"), {{{0, 0, 9, 0, 0, 7}}}), "");
  const std::string dense = "filesrc blocksize=6 location=" + path("data") + " ! " +
                            tensors("uint8", "6") + " ! tensor_sparse_enc ! ";
  EXPECT_EQ(error_of_pipeline(dense + "datareposink " + files("sparse", "sparse.json")), "");
  const std::string bytes = read("sparse");
  ASSERT_EQ(bytes.size(), 138u);
  EXPECT_EQ(bytes.substr(0, 4), "\xed\xcc\xed\xfe");
  EXPECT_EQ(bytes_of(bytes.substr(128)), (Bytes{9, 7, 2, 0, 0, 0, 5, 0, 0, 0}));
  EXPECT_SAYS(read("sparse.json"), "\"tensor_size\" : [\n    138\n  ],\n");
}

TEST_F(Datareposink, WritesVideoAsFilesinkDoes) {
  for (const char* format : {"RGB", "BGRx", "GRAY8"})
    expect_bytes_of_filesink("videotestsrc num-buffers=3 ! video/x-raw,width=5,height=3,format=" +
                             std::string(format));
  EXPECT_SAYS(read("data.json"), "\"total_samples\" : 3,\n  \"sample_size\" : 24\n}");
}

TEST_F(Datareposink, WritesAudioAsFilesinkDoes) {
  expect_bytes_of_filesink(
      "audiotestsrc num-buffers=4 samplesperbuffer=100 ! audio/x-raw,format=S16LE,channels=2");
  EXPECT_SAYS(read("data.json"), "\"total_samples\" : 4,\n  \"sample_size\" : 400\n}");
}

TEST_F(Datareposink, WritesTextAndBytesAsFilesinkDoes) {
  write("source", "one two three four five six!");
  for (const char* caps : {"text/x-raw,format=utf8", kBytes}) {
    expect_bytes_of_filesink("filesrc blocksize=7 location=" + path("source") + " ! " + caps);
    EXPECT_SAYS(read("data.json"), "\"total_samples\" : 4,\n  \"sample_size\" : 7\n}");
  }
}

TEST_F(Datareposink, WritesEachPictureToItsFile) {
  for (const char* caps : {"image/png,width=16,height=16,framerate=1/1",
                           "image/jpeg,width=16,height=16,framerate=1/1,sof-marker=0",
                           "image/tiff,endianness=1234", "image/gif", "image/bmp"}) {
    {
      const auto h = make_harness("datareposink " + files("img_%02d.png", "data.json"), caps);
      for (const auto& picture : {Bytes{1}, Bytes{2, 3}, Bytes{4, 5, 6}})
        EXPECT_EQ(gst_harness_push(h.get(), frame(picture)), GST_FLOW_OK) << caps;
    }
    EXPECT_EQ(bytes_of(read("img_00.png")), (Bytes{1}));
    EXPECT_EQ(bytes_of(read("img_01.png")), (Bytes{2, 3}));
    EXPECT_EQ(bytes_of(read("img_02.png")), (Bytes{4, 5, 6}));
    EXPECT_FALSE(exists("img_03.png"));
    EXPECT_SAYS(read("data.json"), "\"total_samples\" : 3,\n  \"sample_size\" : 3\n}");
  }
}

// docs/compatibility/element-tables.md
TEST_F(Datareposink, AcceptsTheDocumentedCaps) {
  const auto expected = Ref<GstCaps>::adopt(gst_caps_from_string(
      "other/tensors, format=(string){ static, flexible, sparse }, framerate=(fraction)[ 0/1, "
      "2147483647/1 ]; video/x-raw, format=(string){ RGB, BGR, RGBx, BGRx, xRGB, xBGR, RGBA, BGRA, "
      "ARGB, ABGR, GRAY8 }, width=(int)[ 1, 2147483647 ], height=(int)[ 1, 2147483647 ], "
      "framerate=(fraction)[ 0/1, 2147483647/1 ], interlace-mode=(string)progressive; audio/x-raw, "
      "format=(string){ S8, U8, S16LE, S16BE, U16LE, U16BE, S32LE, S32BE, U32LE, U32BE, F32LE, "
      "F32BE, F64LE, F64BE }, rate=(int)[ 1, 2147483647 ], channels=(int)[ 1, 2147483647 ], "
      "layout=(string)interleaved; image/png, width=(int)[ 16, 1000000 ], height=(int)[ 16, "
      "1000000 ], framerate=(fraction)[ 0/1, 2147483647/1 ]; image/jpeg, width=(int)[ 16, 65535 ], "
      "height=(int)[ 16, 65535 ], framerate=(fraction)[ 0/1, 2147483647/1 ], sof-marker=(int){ 0, "
      "1, 2, 4, 9 }; image/tiff, endianness=(int){ 4321, 1234 }; image/gif; image/bmp; text/x-raw, "
      "format=(string)utf8; application/octet-stream"));
  const auto element = lone_element("datareposink");
  const auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "sink"));
  const auto caps = Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(pad.get()));
  EXPECT_TRUE(gst_caps_is_strictly_equal(caps.get(), expected.get()));
}

TEST_F(Datareposink, MakesTensorConverterSendTensors) {
  EXPECT_EQ(error_of_pipeline("videotestsrc num-buffers=1 ! "
                              "video/x-raw,format=GRAY8,width=4,height=1 ! tensor_converter ! " +
                              sink()),
            "");
  EXPECT_SAYS(read("data.json"),
              "\"gst_caps\" : \"other/tensors, format=(string)static, "
              "num_tensors=(int)1,");
}

// docs/compatibility/types-and-caps.md 1.5
TEST_F(Datareposink, TakesDescribedTensorsAsStatic) {
  EXPECT_EQ(error_of_pipeline("fakesrc num-buffers=1 sizetype=fixed sizemax=4 format=time ! "
                              "capsfilter caps=\"other/tensors,num_tensors=1,"
                              "dimensions=(string)4,types=(string)uint8,framerate=0/1\" ! " +
                              sink()),
            "");
  EXPECT_SAYS(read("data.json"), "format=(string)static");
}

// A tensor in two memories, and two tensors in one.
TEST_F(Datareposink, WritesTensorsInAnyNumberOfMemories) {
  EXPECT_EQ(record(tensors("uint8", "5"), {{{1, 2}, {3, 4, 5}}}), "");
  EXPECT_EQ(bytes_of(read("data")), (Bytes{1, 2, 3, 4, 5}));
  const Bytes a = make_chunk({1, 1, true}, 0), b = make_chunk({2, 2, true}, 1);
  EXPECT_EQ(record(make_caps({1, 1, true}, {0}), {{joined({a, b})}}), "");
  EXPECT_EQ(bytes_of(read("data")), joined({a, b}));
  EXPECT_SAYS(read("data.json"), "\"tensor_size\" : [\n    " + std::to_string(a.size()) +
                                     ",\n    " + std::to_string(b.size()) + "\n  ]");
}

TEST_F(Datareposink, StartsWithTheDocumentedValues) {
  const auto element = lone_element("datareposink");
  gchar *location = nullptr, *json = nullptr;
  gboolean sync = FALSE, async = FALSE, qos = TRUE;
  g_object_get(element.get(), "location", &location, "json", &json, "sync", &sync, "async", &async,
               "qos", &qos, nullptr);
  EXPECT_EQ(location, nullptr);
  EXPECT_EQ(json, nullptr);
  EXPECT_TRUE(sync && async && !qos);
}

TEST_F(Datareposink, NeedsBothFilesForReady) {
  EXPECT_SAYS(start_error_of("json=" + path("data.json")),
              "WEIR-1004: the property location is not set");
  EXPECT_SAYS(start_error_of("location=" + path("data")),
              "WEIR-1004: the property json is not set");
  EXPECT_SAYS(start_error_of(""), "fix: datareposink location=samples.bin json=samples.json");
}

TEST_F(Datareposink, WritesTheDescriptionOnTheWayFromReadyToNull) {
  const auto h = make_harness(sink(), kBytes);
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{1})), GST_FLOW_OK);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  gst_element_set_state(h->element, GST_STATE_READY);
  EXPECT_FALSE(exists("data.json"));
  gst_element_set_state(h->element, GST_STATE_NULL);
  EXPECT_TRUE(exists("data.json"));
}

TEST_F(Datareposink, WritesNoDescriptionOfAStreamWithoutCaps) {
  make_harness(sink());
  EXPECT_FALSE(exists("data.json"));
  EXPECT_FALSE(exists("data"));
}

TEST_F(Datareposink, DescribesAStreamWithoutBuffers) {
  EXPECT_EQ(record(kBytes, {}), "");
  EXPECT_EQ(read("data"), "");
  EXPECT_SAYS(read("data.json"), "\"total_samples\" : 0,\n  \"sample_size\" : 0\n}");
}

TEST_F(Datareposink, ReplacesFilesOfBefore) {
  write("data", "a longer file than the new one");
  write("data.json", std::string(1000, 'x'));
  EXPECT_EQ(record(kBytes, {{{7}}}), "");
  EXPECT_EQ(read("data"), "\x07");
  EXPECT_EQ(read("data.json"),
            "{\n  \"gst_caps\" : \"application/octet-stream\",\n  \"total_samples\" : 1,\n"
            "  \"sample_size\" : 1\n}");
}

TEST_F(Datareposink, CreatesFilesThatOthersCanRead) {
  const mode_t before = umask(0);
  EXPECT_EQ(record(kBytes, {{{7}}}), "");
  umask(before);
  struct stat about {};
  ASSERT_EQ(stat(path("data").c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 07777, mode_t{0644});
}

TEST_F(Datareposink, ReplacesTheFilesWithEachStream) {
  const auto h = make_harness(sink(), kBytes);
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{1, 2, 3})), GST_FLOW_OK);
  gst_element_set_state(h->element, GST_STATE_READY);
  gst_element_set_state(h->element, GST_STATE_PLAYING);
  gst_harness_push_event(h.get(), gst_event_new_stream_start("again"));
  gst_harness_set_src_caps_str(h.get(), kBytes);
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{4})), GST_FLOW_OK);
  gst_element_set_state(h->element, GST_STATE_NULL);
  EXPECT_EQ(read("data"), "\x04");
  EXPECT_SAYS(read("data.json"), "\"total_samples\" : 1,\n  \"sample_size\" : 1\n}");
}

TEST_F(Datareposink, DescribesTheSamplesBeforeAnError) {
  EXPECT_SAYS(record(tensors("uint8", "3"), {{{1, 2, 3}}, {{4, 5}}}), "WEIR-2004");
  EXPECT_EQ(bytes_of(read("data")), (Bytes{1, 2, 3}));
  EXPECT_SAYS(read("data.json"), "\"total_samples\" : 1,\n  \"sample_size\" : 3\n}");
}

TEST_F(Datareposink, RejectsFlexibleTensorsWithoutHeaders) {
  const Bytes good = make_chunk({1, 1, true}, 0);
  EXPECT_SAYS(record(make_caps({1, 1, true}, {0}), {{good}, {good, Bytes(200)}}), "WEIR-2005");
  EXPECT_EQ(bytes_of(read("data")), good);
  EXPECT_SAYS(read("data.json"), "\"total_samples\" : 1,");
}

TEST_F(Datareposink, RejectsABufferBeforeCaps) {
  const auto h = make_harness(sink());
  Errors errors(h);
  gst_harness_push_event(h.get(), gst_event_new_stream_start("test"));
  gst_harness_push_event(h.get(), time_segment());
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes(1))), GST_FLOW_NOT_NEGOTIATED);
  EXPECT_SAYS(errors.next(), "WEIR-2003: a buffer arrived before caps");
}

TEST_F(Datareposink, NamesTheFileOnAFullDisk) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP();
  for (const std::string& caps : {std::string(kBytes), tensors("uint8", "1")}) {
    const auto h = make_harness("datareposink location=/dev/full json=" + path("data.json"), caps);
    Errors errors(h);
    EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{1})), GST_FLOW_ERROR);
    const std::string error = errors.next();
    EXPECT_SAYS(error,
                "WEIR-4010: the file of location cannot be written: No space left on "
                "device\n  offered: /dev/full");
    EXPECT_SAYS(error, "fix: df -h /dev");
  }
  EXPECT_SAYS(read("data.json"), "\"total_samples\" : 0,");
}

TEST_F(Datareposink, ReportsADescriptionThatCannotBeWritten) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP();
  const auto h = make_harness("datareposink json=/dev/full location=" + path("data"), kBytes);
  Errors errors(h);
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{1})), GST_FLOW_OK);
  gst_element_set_state(h->element, GST_STATE_NULL);
  EXPECT_SAYS(errors.next(),
              "WEIR-4010: the file of json cannot be written: No space left on "
              "device\n  offered: /dev/full");
}

TEST_F(Datareposink, NamesALocationThatCannotBeWritten) {
  EXPECT_SAYS(start_error_of(files("data", "no/data.json")),
              "WEIR-4010: the file of json cannot be written: No such file or directory");
  const std::string error = caps_error_of(files("no/data"), kBytes);
  EXPECT_SAYS(error,
              "WEIR-4010: the file of location cannot be written: No such file or "
              "directory\n  offered: " +
                  path("no/data"));
  EXPECT_SAYS(error, "fix: mkdir -p " + path("no"));
  EXPECT_SAYS(caps_error_of("location=" + path("") + " json=" + path("data.json"), kBytes),
              "Is a directory");
}

TEST_F(Datareposink, NeedsAPatternWithOneNumberForPictures) {
  EXPECT_SAYS(caps_error_of(files("picture.png"), "image/gif"),
              "WEIR-1001: the pattern of the file names cannot be used: it has no number");
  for (const char* pattern : {"%s.png", "%n", "%d_%d", "%"})
    EXPECT_SAYS(caps_error_of(files(pattern), "image/gif"), "WEIR-1001: the pattern of the file");
  EXPECT_EQ(caps_error_of(files("100%s"), kBytes), "");  // no pattern: no picture
  EXPECT_TRUE(exists("100%s"));
}

TEST_F(Datareposink, KeepsTheCapsOfItsSamples) {
  const auto h = make_harness(sink(), tensors("uint8", "1"));
  gst_harness_set_src_caps_str(h.get(), tensors("uint8", "2").c_str());
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{1, 2})), GST_FLOW_OK);
  Errors errors(h);
  gst_harness_set_src_caps_str(h.get(), tensors("uint8", "3").c_str());
  const std::string error = errors.next();
  EXPECT_SAYS(error, "WEIR-2001: the caps changed, and the samples of one file have the same caps");
  EXPECT_SAYS(error, "as 1 sample before");
  gst_element_set_state(h->element, GST_STATE_NULL);
  EXPECT_SAYS(read("data.json"), "dimensions=(string)2");
}

TEST_F(Datareposink, TakesPicturesOfDifferentSizes) {
  const auto h =
      make_harness("datareposink " + files("%d.png"), "image/png,width=16,height=16,framerate=1/1");
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{1})), GST_FLOW_OK);
  gst_harness_set_src_caps_str(h.get(), "image/png,width=32,height=16,framerate=1/1");
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{2})), GST_FLOW_OK);
  gst_element_set_state(h->element, GST_STATE_NULL);
  EXPECT_EQ(read("1.png"), "\x02");
  EXPECT_SAYS(read("data.json"), "image/png, width=(int)32");
}

TEST_F(Datareposink, WarnsOnceThatSamplesHaveDifferentSizes) {
  const auto h = make_harness(sink(), kBytes);
  Errors errors(h);
  for (const auto& sample : {Bytes{1, 2}, Bytes{3, 4}, Bytes{5}})
    EXPECT_EQ(gst_harness_push(h.get(), frame(sample)), GST_FLOW_OK);
  const std::string warning = errors.next_warning();
  EXPECT_SAYS(warning, "WEIR-2004: the samples have different sizes");
  EXPECT_SAYS(warning, "offered: 1 bytes\n  needed: 2 bytes, as the sample before");
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{6, 7})), GST_FLOW_OK);
  EXPECT_EQ(errors.next_warning(), "");
  gst_element_set_state(h->element, GST_STATE_NULL);
  EXPECT_EQ(read("data").size(), 7u);
  EXPECT_SAYS(read("data.json"), "\"total_samples\" : 4,\n  \"sample_size\" : 2\n}");
}

TEST_F(Datareposink, CountsSamples) {
  const auto h = make_harness(sink(), tensors("uint8", "2"));
  Errors errors(h);
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{1, 2})), GST_FLOW_OK);
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{1})), GST_FLOW_ERROR);
  EXPECT_EQ(stat(h, "datareposink", "received"), 2u);
  EXPECT_EQ(stat(h, "datareposink", "consumed"), 1u);
  EXPECT_EQ(stat(h, "datareposink", "dropped-error"), 1u);
}

}  // namespace datareposink_test
