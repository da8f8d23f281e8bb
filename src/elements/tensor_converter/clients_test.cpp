// Frames of several query server clients in one stream: each client has its own adapter and times,
// and lost frames are counted.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>

#include "elements/tensor_converter/converter_test_support.hpp"
#include "gstcpp/buffer/query_meta.hpp"
#include "gstcpp/element/per_client.hpp"

namespace clients_test {

using namespace weir;
using namespace weir::testing_tensor_converter;

GstBuffer* of_client(int64_t client, uint8_t value, GstClockTime pts = GST_CLOCK_TIME_NONE) {
  GstBuffer* b = frame(Bytes(4, value));
  GST_BUFFER_PTS(b) = pts;
  EXPECT_TRUE(gst::set_client(b, client));
  return b;
}
Harness pairs() {
  return harness("input-dim=4 input-type=uint8 frames-per-tensor=2",
                 "application/octet-stream,framerate=10/1");
}
Bytes two(uint8_t first, uint8_t second) {
  Bytes out(8, first);
  std::fill(out.begin() + 4, out.end(), second);
  return out;
}

TEST(QueryMeta, HasTheNamesThatOthersUse) {
  auto b = Ref<GstBuffer>::adopt(gst_buffer_new());
  EXPECT_EQ(gst::get_client_id(b.get()), std::nullopt);
  ASSERT_TRUE(gst::set_client(b.get(), INT64_MIN));
  ASSERT_TRUE(gst::set_client(b.get(), -7)) << "replaces the earlier client";
  EXPECT_EQ(gst::get_client_id(b.get()), -7);
  const GstMetaInfo* info = gst_meta_get_info("GstMetaQuery");
  ASSERT_TRUE(info);
  EXPECT_STREQ(g_type_name(info->api), "GstMetaQueryAPI");
  GstMeta* meta = gst_buffer_get_meta(b.get(), g_type_from_name("GstMetaQueryAPI"));
  ASSERT_TRUE(meta);
  gint64 number = 0;
  std::memcpy(&number, reinterpret_cast<const char*>(meta) + sizeof(GstMeta), sizeof number);
  EXPECT_EQ(number, -7) << "as a program without this file reads it";
  EXPECT_EQ(gst_buffer_get_n_meta(b.get(), info->api), 1u);
}

TEST(QueryMeta, GoesWithCopies) {
  auto b = Ref<GstBuffer>::adopt(gst_buffer_new());
  ASSERT_TRUE(gst::set_client(b.get(), INT64_MAX));
  auto copy = Ref<GstBuffer>::adopt(gst_buffer_copy(b.get()));
  EXPECT_EQ(gst::get_client_id(copy.get()), INT64_MAX);
}

TEST(PerClient, KeepsOneForEachAndForgetsWhoWasSilentLongest) {
  int made = 0;
  std::vector<int> gone;
  gst::PerClient<int> clients([&] { return ++made; }, [&](int& value) { gone.push_back(value); },
                              2);
  EXPECT_EQ(clients.of(7), 1);
  EXPECT_EQ(clients.of(-8), 2);
  EXPECT_EQ(clients.of(7), 1);
  EXPECT_EQ(clients.of(0), 3) << "takes the place of -8";
  EXPECT_EQ(gone, std::vector<int>{2});
  EXPECT_EQ(clients.of(7), 1);
  EXPECT_EQ(clients.of(-8), 4);
  EXPECT_EQ(gone, (std::vector<int>{2, 3}));
  EXPECT_EQ(clients.size(), 2u);
}

TEST(ConverterClients, HaveFramesOfTheirOwn) {
  auto h = pairs();
  const auto none = [] { return frame(Bytes(4, 90)); };
  for (GstBuffer* in :
       {of_client(1, 10), of_client(2, 20), none(), of_client(2, 21), of_client(1, 11), none()})
    ASSERT_EQ(gst_harness_push(h.get(), in), GST_FLOW_OK);
  const struct {
    Bytes bytes;
    std::optional<gint64> client;
  } expected[] = {{two(20, 21), 2}, {two(10, 11), 1}, {two(90, 90), std::nullopt}};
  for (const auto& [bytes, client] : expected) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(content(out.get()), bytes);
    EXPECT_EQ(gst::get_client_id(out.get()), client);
  }
  EXPECT_EQ(stat(h, "consumed"), 6u);
  EXPECT_EQ(stat(h, "held"), 0u);
}

TEST(ConverterClients, HaveATimeOfTheirOwn) {
  auto h = pairs();
  for (GstBuffer* in : {of_client(1, 0, GST_SECOND), of_client(2, 0, 0), of_client(2, 0),
                        of_client(1, 0), of_client(1, 0), of_client(1, 0)})
    ASSERT_EQ(gst_harness_push(h.get(), in), GST_FLOW_OK);
  for (const GstClockTime tenths : {0, 10, 12}) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), tenths * 100 * GST_MSECOND);
  }
  EXPECT_EQ(stat(h, "backwards-times"), 0u) << "client 2 never went back";
  EXPECT_EQ(stat(h, "missing-times"), 4u);
}

TEST(ConverterClients, ThatAreTooManyLoseWhatWaitsInTheOpen) {
  auto h = pairs();
  Errors errors(h);
  constexpr int64_t kMore = 3;
  const auto limit = static_cast<int64_t>(gst::kClientLimit);
  for (int64_t client = 1; client <= limit + kMore; ++client)
    ASSERT_EQ(gst_harness_push(h.get(), of_client(client, 1)), GST_FLOW_OK);
  EXPECT_EQ(stat(h, "clients-given-up"), 3u);
  EXPECT_EQ(stat(h, "dropped-policy"), 3u);
  EXPECT_EQ(stat(h, "held"), gst::kClientLimit);
  const auto warning = errors.next_warning();
  EXPECT_SAYS(warning, "WEIR-2006: more clients are active than frames are kept for");
  EXPECT_SAYS(warning, "needed: at most 64");
  EXPECT_EQ(errors.next_warning(), "") << "reported once";
  // Client 4 is the oldest whose frame is still held.
  ASSERT_EQ(gst_harness_push(h.get(), of_client(kMore + 1, 2)), GST_FLOW_OK);
  auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(content(out.get()), two(1, 2));
  gst_harness_push_event(h.get(), gst_event_new_eos());
  EXPECT_EQ(stat(h, "dropped-eos"), gst::kClientLimit - 1);
  EXPECT_EQ(stat(h, "held"), 0u);
}

TEST(ConverterClients, ThatComeAndGoLoseNothing) {
  auto h = harness("input-dim=4 input-type=uint8", "application/octet-stream,framerate=10/1");
  Errors errors(h);
  for (int64_t client = 0; client < 200; ++client)
    ASSERT_EQ(gst_harness_push(h.get(), of_client(client, 1)), GST_FLOW_OK);
  EXPECT_EQ(gst_harness_buffers_received(h.get()), 200u);
  EXPECT_EQ(errors.next_warning(), "");
  EXPECT_EQ(stat(h, "clients-given-up"), 0u);
  EXPECT_EQ(stat(h, "dropped"), 0u);
}

}  // namespace clients_test
