// Metadata from another process that is damaged or lies.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/buffer_metas.hpp"

#include <gst/video/gstvideometa.h>
#include <gtest/gtest.h>

#include <cstring>

#include "core/isolate/message.hpp"
#include "gstcpp/buffer/query_meta.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"
#include "gstcpp/element/ref.hpp"
#include "says.hpp"

namespace buffer_metas_test {

using weir::gst::Ref;

Ref<GstBuffer> buffer_of(gsize bytes) {
  return Ref<GstBuffer>::adopt(gst_buffer_new_allocate(nullptr, bytes, nullptr));
}

// 16 x 16 GRAY8 with a stride of 32 at offset 64.
void add_video(GstBuffer* buffer) {
  gsize offset[GST_VIDEO_MAX_PLANES] = {64};
  gint stride[GST_VIDEO_MAX_PLANES] = {32};
  gst_buffer_add_video_meta_full(buffer, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_GRAY8, 16, 16,
                                 1, offset, stride);
}

std::vector<std::byte> all_kinds() {
  const auto buffer = buffer_of(1024);
  auto* region = gst_buffer_add_video_region_of_interest_meta(buffer.get(), "cat", 1, 2, 3, 4);
  gst_video_region_of_interest_meta_add_param(
      region, gst_structure_new("detection", "score", G_TYPE_DOUBLE, 0.5, nullptr));
  weir::gst::set_client(buffer.get(), 7);
  weir::gst::set_source_maps(buffer.get(), {weir::SourceMap{}});
  add_video(buffer.get());
  return weir::encode_metas(buffer.get());
}

TEST(BufferMetas, ABufferWithoutMetasHasNoBytes) {
  EXPECT_TRUE(weir::encode_metas(buffer_of(4).get()).empty());
}

TEST(BufferMetas, PlanesOfVideoArrive) {
  const auto from = buffer_of(1024), to = buffer_of(1024);
  add_video(from.get());
  ASSERT_TRUE(weir::decode_metas(weir::encode_metas(from.get()), to.get()));
  const auto* video = gst_buffer_get_video_meta(to.get());
  ASSERT_TRUE(video);
  EXPECT_EQ(video->format, GST_VIDEO_FORMAT_GRAY8);
  EXPECT_EQ(video->width, 16u);
  EXPECT_EQ(video->offset[0], 64u);
  EXPECT_EQ(video->stride[0], 32);
}

TEST(BufferMetas, PlanesBeyondTheFrameAreRefused) {
  const auto from = buffer_of(1024);
  add_video(from.get());
  const auto bytes = weir::encode_metas(from.get());
  // 64 + 15 * 32 + 16 = 560 bytes are just enough.
  EXPECT_TRUE(weir::decode_metas(bytes, buffer_of(560).get()));
  EXPECT_REFUSED(weir::decode_metas(bytes, buffer_of(559).get()), PEER_MESSAGE_INVALID,
                 "planes of video beyond the frame");
}

// A record of a region with one parameter, as encode_metas() writes it.
std::vector<std::byte> region_with(const std::string& parameter) {
  weir::isolate::MessageWriter out;
  enum class Kind : uint32_t { None };
  out.begin(Kind::None);
  out.put(uint32_t{1});
  out.text("cat");
  for (const int32_t id : {1, 0}) out.put(id);
  for (const uint32_t place : {1, 2, 3, 4}) out.put(place);
  out.put(uint32_t{1});
  out.text(parameter.c_str());
  const auto bytes = out.finish().subspan(sizeof(weir::isolate::MessageHead));
  return {bytes.begin(), bytes.end()};
}

TEST(BufferMetas, ParametersOfRegionsArrive) {
  const auto to = buffer_of(16);
  ASSERT_TRUE(
      weir::decode_metas(region_with("pose, score=(double)0.5, points=(int)< < 1, 2 >, < 3, 4 > >, "
                                     "part=(structure)\"head\\,\\ name\\=\\(string\\)a\\;\";"),
                         to.get()));
  const auto* region = reinterpret_cast<GstVideoRegionOfInterestMeta*>(
      gst_buffer_get_video_region_of_interest_meta_id(to.get(), 1));
  ASSERT_TRUE(region);
  const GstStructure* pose = gst_video_region_of_interest_meta_get_param(
      const_cast<GstVideoRegionOfInterestMeta*>(region), "pose");
  ASSERT_TRUE(pose);
  EXPECT_TRUE(gst_structure_has_field_typed(pose, "part", GST_TYPE_STRUCTURE));
}

TEST(BufferMetas, ParametersThatGStreamerCannotParseSafelyAreRefused) {
  for (const std::string& text :
       {"pose,a=" + std::string(30000, '<'), std::string("1pose"), std::string("pose,a=[2,1]"),
        std::string("pose,a=(buffer)abc"), std::string("pose,a=(GstElement)x")})
    EXPECT_REFUSED(weir::decode_metas(region_with(text), buffer_of(16).get()), PEER_MESSAGE_INVALID,
                   "a parameter of a region that is not a structure: ");
}

TEST(BufferMetas, EveryTruncationIsRefused) {
  const auto bytes = all_kinds();
  size_t whole = 0;
  for (size_t size = 0; size < bytes.size(); ++size) {
    const auto status = weir::decode_metas(std::span(bytes).first(size), buffer_of(1024).get());
    if (status)
      ++whole;
    else
      EXPECT_EQ(status.error().code, weir::Code::PEER_MESSAGE_INVALID) << size;
  }
  EXPECT_EQ(whole, 4u);  // nothing, and where one of the four ends and the next begins
  EXPECT_TRUE(weir::decode_metas(bytes, buffer_of(1024).get()));
}

TEST(BufferMetas, EveryChangedByteIsAcceptedOrRefused) {
  const auto bytes = all_kinds();
  for (size_t at = 0; at < bytes.size(); ++at)
    for (const int value : {0x00, 0x7f, 0x80, 0xff}) {
      auto changed = bytes;
      changed[at] = static_cast<std::byte>(value);
      const auto buffer = buffer_of(1024);
      const auto status = weir::decode_metas(changed, buffer.get());
      const auto* video = gst_buffer_get_video_meta(buffer.get());
      if (!video) continue;
      EXPECT_LE(video->offset[0] + 16, 1024u) << at;
      EXPECT_GT(video->stride[0], 0) << at;
    }
}

TEST(BufferMetas, AnUnknownKindIsRefused) {
  const uint32_t kind = 77;
  const auto bytes = std::as_bytes(std::span(&kind, 1));
  EXPECT_REFUSED(weir::decode_metas(bytes, buffer_of(4).get()), PEER_MESSAGE_INVALID,
                 "unknown kind");
}

TEST(BufferMetas, AParameterThatIsNoStructureIsRefused) {
  auto bytes = all_kinds();
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const size_t at = text.find("detection");
  ASSERT_NE(at, std::string_view::npos);
  bytes[at] = std::byte{','};
  EXPECT_REFUSED(weir::decode_metas(bytes, buffer_of(1024).get()), PEER_MESSAGE_INVALID,
                 "not a structure");
}

}  // namespace buffer_metas_test
