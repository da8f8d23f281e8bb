// datareposrc with files that are missing, wrong, or do not fit their description.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/datareposink/datarepo_test_support.hpp"
#include "elements/tests/many_tensors_test_support.hpp"

namespace damaged_files_test {

using namespace weir::test;

constexpr char kTensorCaps[] =
    "other/tensors,format=static,num_tensors=1,dimensions=(string)4,types=(string)uint8,"
    "framerate=10/1";
constexpr char kFlexibleCaps[] = "other/tensors,format=flexible,framerate=10/1";

class DamagedFiles : public DatarepoTest {
 protected:
  void describe(const std::string& caps, const std::string& members) const {
    write("data.json", "{\"gst_caps\":\"" + caps + "\"," + members + "}");
  }
  // The error that keeps the element from starting.
  std::string start_error_of(const std::string& properties) const {
    const Played played = play("datareposrc " + properties);
    EXPECT_TRUE(played.is_refused) << properties;
    return played.error;
  }
  std::string start_error_of() const { return start_error_of(files()); }
  // Two samples of one flexible tensor each, of 131 bytes.
  void write_flexible(Bytes second) const {
    const Bytes first = make_chunk({1, 1, true}, 0);
    ASSERT_EQ(first.size(), 130u);
    write("data", text_of(joined({first, second})));
    describe(kFlexibleCaps, R"("total_samples":2,"sample_offset":[0,130],"tensor_size":[130,130],)"
                            R"("tensor_count":[0,1])");
  }
};

TEST_F(DamagedFiles, AreNamedIfAPropertyIsMissing) {
  EXPECT_SAYS(start_error_of("json=" + path("data.json")),
              "WEIR-1004: the property location is not set");
  const std::string error = start_error_of("location=" + path("data"));
  EXPECT_SAYS(error, "WEIR-1004: the property json is not set");
  EXPECT_SAYS(error, "needed: the JSON file of the samples, or the property caps");
  EXPECT_SAYS(error, "fix: datareposrc location=samples.bin json=samples.json");
}

TEST_F(DamagedFiles, AreNamedIfTheyAreMissing) {
  EXPECT_SAYS(start_error_of(),
              "WEIR-4001: the file of json cannot be read: No such file or "
              "directory\n  offered: " +
                  path("data.json"));
  describe(kTensorCaps, R"("total_samples":1,"sample_size":4)");
  EXPECT_SAYS(start_error_of(),
              "WEIR-4001: the file of location cannot be read: No such file or "
              "directory\n  offered: " +
                  path("data"));
  std::filesystem::create_directory(path("data"));
  EXPECT_SAYS(start_error_of(), "it is a folder");
}

TEST_F(DamagedFiles, AreNamedIfTheDescriptionIsWrong) {
  write("data", "12345678");
  write("data.json", "{\"gst_caps\" : ");
  EXPECT_SAYS(start_error_of(), "WEIR-4003: the description of the samples is not JSON");
  describe("", R"("total_samples":1)");
  EXPECT_SAYS(start_error_of(), path("data.json"));
  describe("other/tensors,format=(", R"("total_samples":1)");
  EXPECT_SAYS(start_error_of(), "gst_caps of " + path("data.json") + " cannot be read");
  describe("ANY", R"("total_samples":1)");
  EXPECT_SAYS(start_error_of(), "they are not fixed");
  describe("EMPTY", R"("total_samples":1)");
  EXPECT_SAYS(start_error_of(), "they are not fixed");
  describe("video/x-raw,format=RGB,width=[1,2],height=2", R"("total_samples":1)");
  EXPECT_SAYS(start_error_of(), "they are not fixed");
  describe("video/x-h264", R"("total_samples":1)");
  EXPECT_SAYS(start_error_of(),
              "WEIR-2002: the caps do not describe samples: the medium is "
              "unknown\n  offered: " +
                  path("data.json") + ": gst_caps is video/x-h264");
  describe(kTensorCaps, R"("total_samples":-1)");
  EXPECT_SAYS(start_error_of(), "total_samples is not a number of bytes or samples");
}

TEST_F(DamagedFiles, AreNamedIfTheCapsAreNotComplete) {
  write("data", "12345678");
  const auto error = [&](const std::string& caps) {
    describe(caps, R"("total_samples":1)");
    return start_error_of();
  };
  EXPECT_SAYS(error("video/x-raw,format=RGB,height=2"), "the picture is not complete");
  EXPECT_SAYS(error("video/x-raw,format=RGB,width=0,height=2"), "the picture is not complete");
  EXPECT_SAYS(error("video/x-raw,format=RGB,width=-1,height=2"), "the picture is not complete");
  EXPECT_SAYS(error("audio/x-raw,format=S16LE,rate=8"), "the audio is not complete");
  EXPECT_SAYS(error("audio/x-raw,format=S16LE,rate=0,channels=1"), "the audio is not complete");
  EXPECT_SAYS(error("audio/x-raw,format=S,rate=8,channels=1"), "the audio is not complete");
  EXPECT_SAYS(error("audio/x-raw,format=_,rate=8,channels=1"), "the audio is not complete");
  EXPECT_SAYS(error("audio/x-raw,format=F64LE,rate=2147483647,channels=2147483647"), "WEIR-");
  EXPECT_SAYS(error("other/tensors,format=static,num_tensors=1,framerate=1/1"),
              "the tensors are not complete");
  EXPECT_SAYS(error("other/tensors,framerate=1/1"), "the tensors are not complete");
  EXPECT_SAYS(error("other/tensors,format=static,num_tensors=1,dimensions=(string)"
                    "4294967295:4294967295:4294967295,types=(string)uint8,framerate=1/1"),
              "WEIR-2002");
}

TEST_F(DamagedFiles, AreNamedIfThereAreNoSamples) {
  write("data", "");
  describe(kTensorCaps, R"("total_samples":0,"sample_size":0)");
  EXPECT_SAYS(start_error_of(), "WEIR-4003: there are no samples\n  offered: " + path("data.json") +
                                    ": total_samples is 0");
  const std::string caps = " caps=\"" + std::string(kTensorCaps) + "\"";
  write("data", "123");
  EXPECT_SAYS(start_error_of("location=" + path("data") + caps),
              "WEIR-4003: there are no samples\n  offered: " + path("data") +
                  ": 3 bytes\n  needed: a sample or more, each of 4 bytes");
  EXPECT_SAYS(start_error_of("caps=image/gif location=" + path("%d.gif")),
              "WEIR-4003: there are no samples\n  offered: " + path("0.gif"));
}

TEST_F(DamagedFiles, AreNamedIfTheFileIsTooShort) {
  write("data", "1234567");
  describe(kTensorCaps, R"("total_samples":2,"sample_size":4)");
  const std::string error = start_error_of();
  EXPECT_SAYS(error, "WEIR-4003: the description does not fit the file of the samples");
  EXPECT_SAYS(error, "offered: " + path("data") + ": 7 bytes\n  needed: 2 samples of 4 bytes");
  EXPECT_SAYS(error, "first difference: sample 1 is not complete");
  describe(kTensorCaps, R"("total_samples":9223372036854775807,"sample_size":4)");
  EXPECT_SAYS(start_error_of(), "sample 1 is not complete");
}

TEST_F(DamagedFiles, ThatAreTooLongAreAWarning) {
  write("data", "123456789");
  describe(kTensorCaps, R"("total_samples":1,"sample_size":4)");
  const Played played = play("datareposrc " + files());
  EXPECT_EQ(played.error, "");
  EXPECT_EQ(text_of(joined(played.frames())), "1234");
  EXPECT_SAYS(played.warning, "WEIR-4003: the file is longer than its description");
}

TEST_F(DamagedFiles, AreNamedIfTheSampleSizeDoesNotFitTheCaps) {
  write("data", "12345678");
  describe(kTensorCaps, R"("total_samples":1,"sample_size":8)");
  const std::string error = start_error_of();
  EXPECT_SAYS(error,
              "WEIR-4003: sample_size does not fit gst_caps\n  offered: " + path("data.json") +
                  ": sample_size is 8\n  needed: 4 bytes of "
                  "other/tensors");
  describe("application/octet-stream", R"("total_samples":1,"sample_size":0)");
  EXPECT_SAYS(start_error_of(), "needed: a sample_size of 1 byte or more");
}

TEST_F(DamagedFiles, AreNamedIfTheListsContradictEachOther) {
  write("data", std::string(1000, 'x'));
  const auto error = [&](const std::string& offsets, const std::string& sizes,
                         const std::string& counts) {
    describe(kFlexibleCaps, "\"total_samples\":3,\"sample_offset\":" + offsets +
                                ",\"tensor_size\":" + sizes + ",\"tensor_count\":" + counts);
    return start_error_of();
  };
  EXPECT_SAYS(
      error("[0,200,400]", "[200,200,200]", "[0,2,1]"),
      "first difference: tensor_count[2] is 1, which is not more than tensor_count[1] is 2");
  EXPECT_SAYS(error("[0,200,801]", "[200,200,200]", "[0,1,2]"),
              "first difference: sample 2: sample_offset[2] is 801, and tensor 0 of it ends beyond "
              "the file");
  describe(kFlexibleCaps, R"("total_samples":3,"sample_size":4)");
  EXPECT_SAYS(start_error_of(), "the lists sample_offset, tensor_size and tensor_count");
  EXPECT_SAYS(start_error_of("location=" + path("data") + " caps=\"" + kFlexibleCaps + "\""),
              "the lists sample_offset, tensor_size and tensor_count");
}

TEST_F(DamagedFiles, EndTheStreamAtATensorWithoutAHeader) {
  write_flexible(Bytes(130, 7));
  const Played played = play("datareposrc " + files());
  EXPECT_EQ(played.memories.size(), 1u);
  EXPECT_SAYS(played.error, "WEIR-2005");
  EXPECT_SAYS(played.error, "sample 1, tensor 0 at byte 130");
}

TEST_F(DamagedFiles, EndTheStreamAtATensorThatIsTooLong) {
  Bytes longer = make_chunk({1, 1, true}, 0);
  longer[12] = 3;  // the first dimension
  write_flexible(longer);
  const Played played = play("datareposrc " + files());
  EXPECT_EQ(played.memories.size(), 1u);
  EXPECT_SAYS(played.error,
              "WEIR-4003: a tensor is longer than its tensor_size\n  offered: "
              "sample 1, tensor 0 at byte 130: 130 bytes\n  needed: 131 bytes");
}

TEST_F(DamagedFiles, EndTheStreamIfTheFileShrinks) {
  write("data", "12345678");
  describe(kTensorCaps, R"("total_samples":2,"sample_size":4)");
  const auto element = lone_element("datareposrc " + files() + " ! fakesink name=out sync=false");
  Errors errors(element.get());
  const auto bus = Ref<GstBus>::adopt(gst_bus_new());
  gst_element_set_state(element.get(), GST_STATE_READY);
  const auto source = [&] {
    GValue item = G_VALUE_INIT;
    const Unique<GstIterator, gst_iterator_free> all(
        gst_bin_iterate_sources(GST_BIN(element.get())));
    gst_iterator_next(all.get(), &item);
    const auto found = Ref<GstElement>::share(GST_ELEMENT(g_value_get_object(&item)));
    g_value_unset(&item);
    return found;
  }();
  const auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(source.get(), "src"));
  const std::string data = path("data");
  gst_pad_add_probe(
      pad.get(), GST_PAD_PROBE_TYPE_BUFFER,
      [](GstPad*, GstPadProbeInfo*, gpointer file) {
        EXPECT_EQ(truncate(static_cast<const char*>(file), 6), 0);
        return GST_PAD_PROBE_OK;
      },
      const_cast<char*>(data.c_str()), nullptr);
  gst_element_set_state(element.get(), GST_STATE_PLAYING);
  const auto own = Ref<GstBus>::adopt(gst_element_get_bus(element.get()));
  const auto message =
      Ref<GstMessage>::adopt(gst_bus_timed_pop_filtered(own.get(), kTimeout, GST_MESSAGE_ERROR));
  EXPECT_SAYS(get_text(message.get()),
              "WEIR-4003: a sample is cut off by the end of the file\n"
              "  offered: " +
                  data + ": 6 bytes\n  needed: 8 bytes");
  gst_element_set_state(element.get(), GST_STATE_NULL);
}

TEST_F(DamagedFiles, EndTheStreamAtAPictureThatIsMissing) {
  write("p0.png", "a");
  write("p2.png", "c");
  describe("image/png", R"("total_samples":3,"sample_size":1)");
  const Played played = play("datareposrc " + files("p%d.png"));
  EXPECT_EQ(text_of(joined(played.frames())), "a");
  EXPECT_SAYS(played.error,
              "WEIR-4001: the file of sample 1 cannot be read: No such file or "
              "directory\n  offered: " +
                  path("p1.png"));
}

TEST_F(DamagedFiles, AreNamedIfAPatternIsWrong) {
  describe("image/png", R"("total_samples":3)");
  EXPECT_SAYS(start_error_of(files("%s")),
              "WEIR-1001: the pattern of the file names cannot be used");
}

TEST_F(DamagedFiles, AreNoReasonToAllocateEverything) {
  write("data", std::string(100, 'x'));
  const std::string caps =
      "other/tensors,format=static,num_tensors=1,dimensions=(string)100,"
      "types=(string)uint8,framerate=1/1";
  const std::string launch =
      "datareposrc location=" + path("data") + " caps=\"" + caps + "\" max-buffer-size=";
  EXPECT_SAYS(play(launch + "99").error, "WEIR-2006");
  EXPECT_EQ(play(launch + "100").error, "");
  write("0", std::string(100, 'x'));
  EXPECT_SAYS(play("datareposrc caps=image/gif max-buffer-size=99 location=" + path("%d")).error,
              "WEIR-2006");
}

TEST_F(DamagedFiles, AreNamedIfDownstreamNeedsOthers) {
  write("data", "12345678");
  const std::string launch = "datareposrc caps=image/gif location=" + path("%d") + " ! tensor_sink";
  write("0", "x");
  EXPECT_SAYS(error_of_pipeline(launch), "WEIR-2001");
}

}  // namespace damaged_files_test
