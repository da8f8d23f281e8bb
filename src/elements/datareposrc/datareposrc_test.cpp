// datareposrc: the samples of each medium, ranges, epochs, times, and a choice of tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/base/gstbasesrc.h>

#include <algorithm>

#include "elements/datareposink/datarepo_test_support.hpp"
#include "elements/tests/many_tensors_test_support.hpp"

namespace datareposrc_test {

using namespace weir::test;

constexpr char kBytes[] = "application/octet-stream";
constexpr GstClockTime kNone = GST_CLOCK_TIME_NONE;
using Frames = std::vector<Bytes>;

class Datareposrc : public DatarepoTest {
 protected:
  // Writes `count` samples of one byte, 0, 1, 2, ..., and their description.
  void write_numbers(uint8_t count, const std::string& rate = "10/1") const {
    Bytes bytes(count);
    for (uint8_t i = 0; i < count; ++i) bytes[i] = i;
    write("data", text_of(bytes));
    describe(tensors("uint8", "1", rate), count, 1);
  }
  void describe(const std::string& caps, uint64_t samples, uint64_t sample_bytes) const {
    std::string quoted;
    for (const char c : caps) quoted += c == '"' ? std::string("\\\"") : std::string(1, c);
    write("data.json", "{\"gst_caps\":\"" + quoted +
                           "\",\"total_samples\":" + std::to_string(samples) +
                           ",\"sample_size\":" + std::to_string(sample_bytes) + "}");
  }
  Played play_numbers(const std::string& properties = "") const {
    return play("datareposrc " + files() + " " + properties);
  }
  // Plays the file "data" with the property caps instead of a description.
  Played play_as(const std::string& caps, const std::string& properties = "") const {
    return play("datareposrc location=" + path("data") + " caps=" + quoted(caps) + " " +
                properties);
  }
  static std::string quoted(const std::string& caps) {
    std::string out = "\"";
    for (const char c : caps) out += c == '"' ? std::string("\\\"") : std::string(1, c);
    return out + "\"";
  }
  void record(const std::string& caps, const std::vector<std::vector<Bytes>>& buffers,
              const std::string& location = "data") const {
    const auto h = make_harness("datareposink " + files(location), caps);
    for (const auto& memories : buffers)
      EXPECT_EQ(gst_harness_push(h.get(), buffer_of(memories)), GST_FLOW_OK);
  }
};

Bytes order(const Played& played) {
  return joined(played.frames());
}

TEST_F(Datareposrc, PushesStaticTensorsAsTheyWereRecorded) {
  const std::vector<std::vector<Bytes>> buffers{{{1, 2, 3}, {4, 0}}, {{6, 7, 8}, {9, 0}}};
  record(tensors("uint8,int16", "3,1", "10/1"), buffers);
  const Played played = play("datareposrc " + files());
  EXPECT_EQ(played.error, "");
  EXPECT_EQ(played.memories, buffers);
  EXPECT_EQ(played.caps,
            "other/tensors, format=(string)static, num_tensors=(int)2, "
            "dimensions=(string)\"3\\,1\", types=(string)\"uint8\\,int16\", "
            "framerate=(fraction)10/1");
}

TEST_F(Datareposrc, PushesTensorsOfEveryNumber) {
  for (const auto& sweep : sweep()) {
    if (sweep.count > 1 && sweep.count < 15) continue;
    const auto all = make_range(0, sweep.count);
    const auto memories = make_memories(sweep, all);
    record(make_caps(sweep, all), {memories, memories});
    const Played played = play("datareposrc " + files());
    EXPECT_EQ(played.error, "") << sweep;
    EXPECT_EQ(played.memories, (std::vector{memories, memories})) << sweep;
  }
}

TEST_F(Datareposrc, PushesFlexibleTensorsOfDifferentNumbers) {
  const Sweep sweep{3, 3, true};
  const std::vector<std::vector<Bytes>> buffers{{make_chunk(sweep, 0), make_chunk(sweep, 1)},
                                                {make_chunk(sweep, 2)}};
  record(make_caps(sweep, {0}), buffers);
  const Played played = play("datareposrc " + files() + " epochs=2 is-shuffle=false");
  EXPECT_EQ(played.memories, (std::vector{buffers[0], buffers[1], buffers[0], buffers[1]}));
  EXPECT_EQ(played.caps, "other/tensors, format=(string)flexible, framerate=(fraction)30/1");
}

TEST_F(Datareposrc, PushesSparseTensors) {
  write("dense", text_of({0, 0, 9, 0, 0, 7}));
  EXPECT_EQ(
      error_of_pipeline("filesrc blocksize=6 location=" + path("dense") + " ! " +
                        tensors("uint8", "6") + " ! tensor_sparse_enc ! datareposink " + files()),
      "");
  const Played played = play("datareposrc " + files() + " ! tensor_sparse_dec");
  EXPECT_EQ(played.error, "");
  EXPECT_EQ(played.frames(), (Frames{{0, 0, 9, 0, 0, 7}}));
}

// Rows of 5 RGB pixels are padded to 16 bytes, whose content is random.
TEST_F(Datareposrc, PushesVideoFrames) {
  EXPECT_EQ(error_of_pipeline("videotestsrc num-buffers=3 pattern=ball ! video/x-raw,format=RGB,"
                              "width=5,height=3,framerate=10/1 ! tee name=t ! queue ! "
                              "datareposink " +
                              files() + " t. ! queue ! filesink location=" + path("reference")),
            "");
  const Played played = play("datareposrc " + files());
  EXPECT_EQ(played.frames().size(), 3u);
  EXPECT_EQ(played.frames()[0].size(), 48u);
  EXPECT_EQ(text_of(order(played)), read("reference"));
  EXPECT_SAYS(played.caps, "video/x-raw, format=(string)RGB, width=(int)5, height=(int)3, ");
}

TEST_F(Datareposrc, PushesSecondsOfAudio) {
  const std::string caps = "audio/x-raw,format=S16LE,rate=50,channels=2,layout=interleaved";
  record(caps, {{ramp(200)}, {ramp(200)}, {ramp(200)}});
  EXPECT_EQ(play("datareposrc " + files()).frames(), (Frames{ramp(200), ramp(200), ramp(200)}));
  write("data", text_of(ramp(800)));
  for (const auto& [format, bytes] :
       {std::pair("S8", 100), std::pair("S16BE", 200), std::pair("S24LE", 300),
        std::pair("S20LE", 300), std::pair("S24_32LE", 400), std::pair("F64LE", 800)})
    EXPECT_EQ(
        play_as("audio/x-raw,rate=50,channels=2,layout=interleaved,format=" + std::string(format))
            .frames()
            .at(0)
            .size(),
        size_t(bytes))
        << format;
}

// The sink's description has the size of its last buffer.
TEST_F(Datareposrc, ReadsAudioInSecondsHoweverItWasRecorded) {
  record("audio/x-raw,format=U8,rate=50,channels=1,layout=interleaved",
         {{ramp(60)}, {ramp(60)}, {ramp(10)}});
  const Played played = play("datareposrc " + files());
  EXPECT_EQ(played.error, "");
  Bytes all = joined({ramp(60), ramp(60), ramp(10)});
  all.resize(100);
  EXPECT_EQ(order(played), all);
  EXPECT_SAYS(played.warning,
              "WEIR-4003: audio is read in seconds, and was not recorded in seconds");
}

TEST_F(Datareposrc, PushesTextAndBytesOfTheDescribedSize) {
  for (const char* caps : {"text/x-raw,format=utf8", kBytes}) {
    record(caps, {{{1, 2, 3}}, {{4, 5, 6}}});
    EXPECT_EQ(play("datareposrc blocksize=2 " + files()).frames(), (Frames{{1, 2, 3}, {4, 5, 6}}));
  }
}

TEST_F(Datareposrc, PushesPicturesOfWholeFiles) {
  record("image/png,width=16,height=16,framerate=1/1", {{{1}}, {{2, 3}}, {{4, 5, 6}}},
         "img_%02d.png");
  const Played played = play("datareposrc " + files("img_%02d.png"));
  EXPECT_EQ(played.frames(), (Frames{{1}, {2, 3}, {4, 5, 6}}));
  EXPECT_EQ(played.times, (std::vector<GstClockTime>{0, 0, GST_SECOND}));
  EXPECT_SAYS(played.caps, "image/png, width=(int)16");
}

TEST_F(Datareposrc, CountsSamplesByTheFileWithCaps) {
  write("data", text_of(ramp(11)));
  EXPECT_EQ(play_as(tensors("uint8", "3")).frames(), (Frames{{0, 1, 2}, {3, 4, 5}, {6, 7, 8}}));
  EXPECT_EQ(play_as("other/tensor,dimension=(string)5,type=(string)uint8,framerate=1/1").frames(),
            (Frames{{0, 1, 2, 3, 4}, {5, 6, 7, 8, 9}}));
  EXPECT_EQ(play_as(kBytes, "blocksize=4").frames(), (Frames{{0, 1, 2, 3}, {4, 5, 6, 7}}));
  EXPECT_EQ(play_as(kBytes, "blocksize=11 epochs=2").frames().size(), 2u);
  EXPECT_EQ(play_as("video/x-raw,format=GRAY8,width=4,height=2,framerate=5/1").frames(),
            (Frames{ramp(8)}));
}

TEST_F(Datareposrc, CountsPicturesByTheirFilesWithCaps) {
  for (const char* name : {"p0.gif", "p1.gif", "p3.gif"}) write(name, name);
  const Played played = play("datareposrc caps=image/gif location=" + path("p%d.gif"));
  EXPECT_EQ(text_of(order(played)), "p0.gifp1.gif");
}

TEST_F(Datareposrc, PrefersTheDescriptionToTheCaps) {
  write_numbers(3);
  EXPECT_EQ(play_numbers("caps=\"image/gif\"").frames(), (Frames{{0}, {1}, {2}}));
}

TEST_F(Datareposrc, PushesAnInclusiveRange) {
  write_numbers(6);
  EXPECT_EQ(order(play_numbers()), (Bytes{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(order(play_numbers("start-sample-index=2 stop-sample-index=4")), (Bytes{2, 3, 4}));
  EXPECT_EQ(order(play_numbers("start-sample-index=4")), (Bytes{4, 5}));
  EXPECT_EQ(order(play_numbers("stop-sample-index=1")), (Bytes{0, 1}));
  EXPECT_EQ(order(play_numbers("start-sample-index=5 stop-sample-index=5")), (Bytes{5}));
}

TEST_F(Datareposrc, DoesNotStartWithARangeThatDoesNotExist) {
  write_numbers(6);
  for (const char* range : {"start-sample-index=6", "stop-sample-index=6",
                            "start-sample-index=3 stop-sample-index=2"}) {
    const Played played = play_numbers(range);
    EXPECT_TRUE(played.is_refused) << range;
    EXPECT_SAYS(played.error, "WEIR-1004: the range of samples does not exist");
    EXPECT_SAYS(played.error, "fix: start-sample-index=0 stop-sample-index=5");
  }
}

TEST_F(Datareposrc, PushesTheFirstEpochInTheOrderOfTheFile) {
  write_numbers(30);
  const Bytes all = order(play_numbers("epochs=3 start-sample-index=5"));
  ASSERT_EQ(all.size(), 75u);
  for (size_t i = 0; i < 25; ++i) EXPECT_EQ(all[i], 5 + i);
  for (size_t epoch = 1; epoch < 3; ++epoch) {
    Bytes one(all.begin() + static_cast<ptrdiff_t>(25 * epoch),
              all.begin() + static_cast<ptrdiff_t>(25 * epoch + 25));
    EXPECT_FALSE(std::is_sorted(one.begin(), one.end()));  // 1 in 25! by chance
    std::sort(one.begin(), one.end());
    EXPECT_TRUE(std::equal(one.begin(), one.end(), all.begin()));
  }
}

TEST_F(Datareposrc, ShufflesInTheSameOrderWithTheSameSeed) {
  write_numbers(30);
  const Bytes once = order(play_numbers("epochs=3 seed=5"));
  EXPECT_EQ(order(play_numbers("epochs=3 seed=5")), once);
  EXPECT_NE(order(play_numbers("epochs=3 seed=6")), once);
  EXPECT_NE(order(play_numbers("epochs=3")), order(play_numbers("epochs=3")));
}

TEST_F(Datareposrc, RepeatsTheOrderOfTheFileWithoutShuffling) {
  write_numbers(3);
  EXPECT_EQ(order(play_numbers("epochs=3 is-shuffle=false")), (Bytes{0, 1, 2, 0, 1, 2, 0, 1, 2}));
  EXPECT_EQ(order(play_numbers("epochs=0")), Bytes{});
  EXPECT_EQ(play_numbers("epochs=0").error, "");
}

// 0, 0, 1/fps, 2/fps, ...
TEST_F(Datareposrc, CountsTimesOverEpochs) {
  write_numbers(3);
  const GstClockTime d = GST_SECOND / 10;
  const Played played = play_numbers("epochs=2");
  EXPECT_EQ(played.times, (std::vector<GstClockTime>{0, 0, d, 2 * d, 3 * d, 4 * d}));
  EXPECT_EQ(played.durations, std::vector<GstClockTime>(6, d));
}

TEST_F(Datareposrc, HasTimesWithoutAccumulatedRounding) {
  write_numbers(5, "30/1");
  const Played played = play_numbers();
  EXPECT_EQ(played.times, (std::vector<GstClockTime>{0, 0, 33333333, 66666666, 100000000}));
  EXPECT_EQ(played.durations, std::vector<GstClockTime>(5, 33333333));
  write_numbers(4, "2/5");
  EXPECT_EQ(play_numbers().times,
            (std::vector<GstClockTime>{0, 0, 2500 * GST_MSECOND, 5 * GST_SECOND}));
}

TEST_F(Datareposrc, HasNoTimesWithoutARate) {
  const std::vector<GstClockTime> none(2, kNone);
  write_numbers(2, "0/1");
  Played played = play_numbers();
  EXPECT_EQ(played.times, none);
  EXPECT_EQ(played.durations, none);
  EXPECT_EQ(played.warning, "");
  played = play_as(kBytes, "blocksize=1");
  EXPECT_EQ(played.times, none);
  EXPECT_EQ(played.warning, "");
}

TEST_F(Datareposrc, WarnsThatAudioHasNoTimes) {
  write("data", text_of(ramp(100)));
  const Played played = play_as("audio/x-raw,format=U8,rate=50,channels=1,layout=interleaved");
  EXPECT_EQ(played.times, std::vector<GstClockTime>(2, kNone));
  EXPECT_SAYS(played.warning, "WEIR-2008: buffers of audio have no timestamps");
}

TEST_F(Datareposrc, ChoosesTensorsInTheGivenOrder) {
  record(tensors("uint8,int16,uint8", "2,1,3"),
         {{{1, 2}, {3, 0}, {4, 5, 6}}, {{7, 8}, {9, 0}, {10, 11, 12}}});
  const Played played = play("datareposrc " + files() + " tensors-sequence=2,0");
  EXPECT_EQ(played.memories,
            (std::vector<std::vector<Bytes>>{{{4, 5, 6}, {1, 2}}, {{10, 11, 12}, {7, 8}}}));
  EXPECT_EQ(played.caps,
            "other/tensors, format=(string)static, num_tensors=(int)2, "
            "dimensions=(string)\"3\\,2\", types=(string)\"uint8\\,uint8\", "
            "framerate=(fraction)30/1");
  const Played one = play("datareposrc " + files() + " tensors-sequence=1");
  EXPECT_EQ(one.frames(), (Frames{{3, 0}, {9, 0}}));
  write("data", text_of(ramp(4)));
  EXPECT_SAYS(play_as("other/tensor,dimension=(string)2,type=(string)uint8,framerate=1/1",
                      "tensors-sequence=0,0")
                  .caps,
              "other/tensors, ");
  EXPECT_SAYS(one.caps, "num_tensors=(int)1, dimensions=(string)1, types=(string)int16");
}

TEST_F(Datareposrc, ChoosesTensorsOfLargeFrames) {
  const Sweep sweep{20, 20, false};
  record(make_caps(sweep, make_range(0, 20)), {make_memories(sweep, make_range(0, 20))});
  const std::vector<size_t> chosen{19, 0, 17, 3, 18, 1, 2, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13};
  const Played played = play("datareposrc " + files() + " tensors-sequence=" +
                             weir::join(chosen, ",", [](size_t i) { return std::to_string(i); }));
  EXPECT_EQ(played.memories, (std::vector<std::vector<Bytes>>{make_memories(sweep, chosen)}));
}

TEST_F(Datareposrc, DoesNotStartWithTensorsThatDoNotExist) {
  record(tensors("uint8,uint8", "2,1"), {{{1, 2}, {3}}});
  const auto error = [&](const std::string& sequence) {
    const Played played = play("datareposrc " + files() + " tensors-sequence=" + sequence);
    EXPECT_TRUE(played.is_refused) << sequence;
    return played.error;
  };
  EXPECT_SAYS(error("0,2"), "WEIR-1004: tensors-sequence names a tensor that does not exist");
  EXPECT_SAYS(error("0,x"), "WEIR-1001: tensors-sequence cannot be read");
  EXPECT_SAYS(error("-1"), "WEIR-1001: tensors-sequence cannot be read");
  EXPECT_SAYS(error(weir::join(std::vector<int>(257, 0), ",", [](int) { return "0"; })),
              "WEIR-2006: tensors-sequence has too many tensors");
  describe(kBytes, 1, 3);
  EXPECT_SAYS(error("0"), "WEIR-1004: tensors-sequence selects static tensors only");
}

TEST_F(Datareposrc, PlaysFromTheStartAgain) {
  write_numbers(3);
  const PlayedPipeline pipeline("datareposrc " + files() + " ! tensor_sink name=out");
  std::vector<Bytes> all;
  g_signal_connect(pipeline.find("out").get(), "new-data",
                   G_CALLBACK(+[](GstElement*, GstBuffer* buffer, std::vector<Bytes>* seen) {
                     seen->push_back(content(buffer));
                   }),
                   &all);
  EXPECT_EQ(pipeline.plays_to_its_end(), "");
  EXPECT_TRUE(pipeline.reaches(GST_STATE_READY));
  EXPECT_EQ(pipeline.plays_to_its_end(), "");
  EXPECT_EQ(all, (Frames{{0}, {1}, {2}, {0}, {1}, {2}}));
}

// Reads one sample near the end of 5 TiB.
TEST_F(Datareposrc, ReadsFilesThatAreLargerThanMemory) {
  constexpr uint64_t kSample = uint64_t{1} << 20, kSamples = 5 << 20;
  write("data", "");
  if (truncate(path("data").c_str(), static_cast<off_t>(kSample * kSamples)) != 0)
    GTEST_SKIP() << "the file system has no such files";
  {
    std::fstream file(path("data"), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(kSample * (kSamples - 2)));
    file << "here";
  }
  describe(tensors("uint8", "1048576"), kSamples, kSample);
  const std::string at = std::to_string(kSamples - 2);
  const Played played = play_numbers("start-sample-index=" + at + " stop-sample-index=" + at);
  ASSERT_EQ(played.frames().size(), 1u);
  EXPECT_EQ(text_of(played.frames()[0]).substr(0, 5), std::string("here\0", 5));
}

TEST_F(Datareposrc, StartsWithTheDocumentedValues) {
  const auto element = lone_element("datareposrc");
  gchar *location = nullptr, *json = nullptr, *sequence = nullptr;
  GstCaps* caps = nullptr;
  guint start = 1, stop = 1, epochs = 0;
  gboolean is_shuffle = FALSE, do_timestamp = TRUE;
  gint buffers = 0;
  g_object_get(element.get(), "location", &location, "json", &json, "tensors-sequence", &sequence,
               "caps", &caps, "start-sample-index", &start, "stop-sample-index", &stop, "epochs",
               &epochs, "is-shuffle", &is_shuffle, "do-timestamp", &do_timestamp, "num-buffers",
               &buffers, nullptr);
  EXPECT_TRUE(!location && !json && !sequence && !caps);
  EXPECT_EQ(std::vector({start, stop, epochs}), (std::vector<guint>{0, 0, 1}));
  EXPECT_TRUE(is_shuffle);
  EXPECT_FALSE(do_timestamp);
  EXPECT_EQ(buffers, -1);
  for (const char* name : {"start-sample-index", "stop-sample-index", "epochs"})
    EXPECT_EQ(
        G_PARAM_SPEC_UINT(g_object_class_find_property(G_OBJECT_GET_CLASS(element.get()), name))
            ->maximum,
        2147483647u);
}

TEST_F(Datareposrc, IsNotALiveSource) {
  const auto element = lone_element("datareposrc");
  EXPECT_FALSE(gst_base_src_is_live(GST_BASE_SRC(element.get())));
  const auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "src"));
  const auto caps = Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(pad.get()));
  EXPECT_TRUE(gst_caps_is_any(caps.get()));
}

TEST_F(Datareposrc, OffersTheCapsOfItsSamples) {
  write_numbers(1);
  const auto element = lone_element("datareposrc " + files());
  const auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "src"));
  const auto offered = [&] {
    const auto caps = Ref<GstCaps>::adopt(gst_pad_query_caps(pad.get(), nullptr));
    return std::string(weir::gst::UniqueText(gst_caps_to_string(caps.get())).get());
  };
  EXPECT_EQ(offered(), "ANY");
  gst_element_set_state(element.get(), GST_STATE_PAUSED);
  EXPECT_SAYS(offered(), "other/tensors, format=(string)static");
  gst_element_set_state(element.get(), GST_STATE_NULL);
  EXPECT_EQ(offered(), "ANY");
}

}  // namespace datareposrc_test
