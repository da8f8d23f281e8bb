// Every element keeps the query server client of its frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/check/gstharness.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "gstcpp/buffer/query_meta.hpp"
#include "gstcpp/element/ref.hpp"

namespace client_test {

using weir::gst::Ref;
using weir::gst::Unique;
using Harness = Unique<GstHarness, gst_harness_teardown>;

const char* const kVideo =
    "video/x-raw,format=GRAY8,width=4,height=4,framerate=10/1,interlace-mode=progressive";

std::string fake_model() {
  const std::string path = testing::TempDir() + "weir-client.bin";
  std::ofstream(path) << "the engine ignores the frame";
  return path;
}

class ClientMeta : public testing::TestWithParam<std::string> {};

TEST_P(ClientMeta, IsForwarded) {
  const Harness h{gst_harness_new_parse(GetParam().c_str())};
  gst_harness_set_src_caps_str(h.get(), kVideo);
  for (const gint64 client : {gint64{1} << 40, gint64{-3}}) {
    GstBuffer* in = gst_buffer_new_allocate(nullptr, 16, nullptr);
    gst_buffer_memset(in, 0, 0, 16);
    GST_BUFFER_PTS(in) = 0;
    ASSERT_TRUE(weir::gst::set_client(in, client));
    const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
    ASSERT_TRUE(out);
    EXPECT_EQ(weir::gst::get_client_id(out.get()), client);
  }
}
INSTANTIATE_TEST_SUITE_P(
    EachElement, ClientMeta,
    testing::Values(
        "tensor_converter", "tensor_converter ! other/tensors,format=flexible ! tensor_converter",
        "tensor_converter ! tensor_transform mode=arithmetic option=add:1",
        "tensor_converter ! tensor_transform mode=typecast option=float32 ! tensor_transform "
        "mode=transpose option=1:0:2:3",
        "tensor_preprocess width=2 height=2",
        "tensor_converter ! tensor_transform mode=dimchg option=0:2 ! tensor_transform "
        "mode=typecast option=float32 ! tensor_filter framework=fake model=" +
            fake_model(),
        "tensor_converter ! tensor_decoder mode=octet_stream",
        "tensor_converter ! tensor_decoder mode=direct_video"));

}  // namespace client_test
