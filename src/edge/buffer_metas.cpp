// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/buffer_metas.hpp"

#include <gst/video/gstvideometa.h>

#include <string>
#include <utility>

#include "core/isolate/message.hpp"
#include "gstcpp/buffer/caps_text.hpp"
#include "gstcpp/buffer/query_meta.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir {
namespace {

using isolate::MessageReader;
using isolate::MessageWriter;
using Region = GstVideoRegionOfInterestMeta;

enum class MetaKind : uint32_t { None = 0, Region, Client, SourceMaps, Video };

constexpr uint32_t kMaxParameters = 64, kMaxMaps = 65536;

void put_kind(MessageWriter* out, MetaKind kind) {
  out->put(static_cast<uint32_t>(kind));
}

Error invalid(std::string what) {
  return Error{.code = Code::PEER_MESSAGE_INVALID,
               .what = "the metadata of a frame from another process cannot be used",
               .offered = std::move(what),
               .needed = "an edgesink of the same version"};
}

Error invalid(const char* what, const Error& cause) {
  return invalid(std::string(what) + ": " + cause.offered + ", not " + cause.needed);
}

void encode_region(const Region& region, MessageWriter* out) {
  put_kind(out, MetaKind::Region);
  const char* type = g_quark_to_string(region.roi_type);
  out->text(type ? type : "");
  for (const gint value : {region.id, region.parent_id}) out->put(int32_t{value});
  for (const guint value : {region.x, region.y, region.w, region.h}) out->put(uint32_t{value});
  out->put(static_cast<uint32_t>(g_list_length(region.params)));
  for (const GList* at = region.params; at; at = at->next) {
    const gst::UniqueText text{gst_structure_to_string(static_cast<GstStructure*>(at->data))};
    out->text(text.get());
  }
}

Status decode_region(MessageReader* in, GstBuffer* buffer) {
  const std::string type = in->text();
  const gint id = in->take<int32_t>(), parent = in->take<int32_t>();
  uint32_t place[4];
  for (uint32_t& value : place) value = in->take<uint32_t>();
  Region* region = gst_buffer_add_video_region_of_interest_meta(buffer, type.c_str(), place[0],
                                                                place[1], place[2], place[3]);
  region->id = id;
  region->parent_id = parent;
  for (uint32_t left = in->count(kMaxParameters); left > 0; --left) {
    auto parameter = gst::structure_from_text(in->text());
    if (!parameter)
      return invalid("a parameter of a region that is not a structure", parameter.error());
    gst_video_region_of_interest_meta_add_param(region, parameter->release());
  }
  return ok();
}

void encode_maps(GstBuffer* buffer, MessageWriter* out) {
  const auto maps = gst::source_maps(buffer);
  if (maps.empty()) return;
  put_kind(out, MetaKind::SourceMaps);
  out->put(static_cast<uint32_t>(gst::maps_of(buffer)));
  out->put(static_cast<uint32_t>(maps.size()));
  for (const auto& map : maps) out->put(abi_map(map));
}

Status decode_maps(MessageReader* in, GstBuffer* buffer) {
  const auto of = in->take<uint32_t>();
  if (of > static_cast<uint32_t>(gst::MapsOf::Regions))
    return invalid("source maps of an unknown kind");
  std::vector<SourceMap> maps;
  for (uint32_t left = in->count(kMaxMaps); left > 0; --left) {
    const auto map = in->take<weir_source_map>();
    if (map.x_dimension > 15 || map.y_dimension > 15)
      return invalid("a source map of a dimension beyond 15");
    maps.push_back(source_map(map));
  }
  gst::set_source_maps(buffer, std::move(maps), static_cast<gst::MapsOf>(of));
  return ok();
}

void encode_video(const GstVideoMeta& video, MessageWriter* out) {
  put_kind(out, MetaKind::Video);
  out->text(gst_video_format_to_string(video.format));
  for (const guint value : {guint(video.flags), video.width, video.height, video.n_planes})
    out->put(uint32_t{value});
  for (guint i = 0; i < GST_VIDEO_MAX_PLANES; ++i) {
    out->put(uint64_t{video.offset[i]});
    out->put(int32_t{video.stride[i]});
  }
}

// Whether each plane lies within `size` bytes.
bool fits(const GstVideoFormatInfo* format, guint width, guint height, guint planes,
          const gsize* offset, const gint* stride, gsize size) {
  if (planes != GST_VIDEO_FORMAT_INFO_N_PLANES(format) || width == 0 || height == 0 ||
      width > 65536 || height > 65536 || GST_VIDEO_FORMAT_INFO_IS_TILED(format))
    return false;
  for (guint i = 0; i < GST_VIDEO_FORMAT_INFO_N_COMPONENTS(format); ++i) {
    const guint plane = GST_VIDEO_FORMAT_INFO_PLANE(format, i);
    const auto rows = static_cast<gsize>(GST_VIDEO_FORMAT_INFO_SCALE_HEIGHT(format, i, height));
    const auto row = static_cast<gsize>(GST_VIDEO_FORMAT_INFO_SCALE_WIDTH(format, i, width)) *
                     static_cast<gsize>(GST_VIDEO_FORMAT_INFO_PSTRIDE(format, i));
    if (stride[plane] <= 0 || row > static_cast<gsize>(stride[plane])) return false;
    const gsize bytes = (rows - 1) * static_cast<gsize>(stride[plane]) + row;
    if (offset[plane] > size || bytes > size - offset[plane]) return false;
  }
  return true;
}

Status decode_video(MessageReader* in, GstBuffer* buffer) {
  const GstVideoFormat format = gst_video_format_from_string(in->text().c_str());
  uint32_t values[4];
  for (uint32_t& value : values) value = in->take<uint32_t>();
  gsize offset[GST_VIDEO_MAX_PLANES] = {};
  gint stride[GST_VIDEO_MAX_PLANES] = {};
  for (guint i = 0; i < GST_VIDEO_MAX_PLANES; ++i) {
    offset[i] = in->take<uint64_t>();
    stride[i] = in->take<int32_t>();
  }
  if (format == GST_VIDEO_FORMAT_UNKNOWN ||
      !fits(gst_video_format_get_info(format), values[1], values[2], values[3], offset, stride,
            gst_buffer_get_size(buffer)))
    return invalid("planes of video beyond the frame");
  gst_buffer_add_video_meta_full(buffer, static_cast<GstVideoFrameFlags>(values[0]), format,
                                 values[1], values[2], values[3], offset, stride);
  return ok();
}

Status decode_one(MetaKind kind, MessageReader* in, GstBuffer* buffer) {
  switch (kind) {
    case MetaKind::Region:
      return decode_region(in, buffer);
    case MetaKind::Client:
      gst::set_client(buffer, in->take<gint64>());
      return ok();
    case MetaKind::SourceMaps:
      return decode_maps(in, buffer);
    case MetaKind::Video:
      return decode_video(in, buffer);
    case MetaKind::None:
      break;
  }
  return invalid("metadata of an unknown kind");
}

}  // namespace

std::vector<std::byte> encode_metas(GstBuffer* buffer) {
  MessageWriter out;
  out.begin(MetaKind::None);
  gpointer state = nullptr;
  while (GstMeta* meta = gst_buffer_iterate_meta(buffer, &state)) {
    if (meta->info->api == GST_VIDEO_REGION_OF_INTEREST_META_API_TYPE)
      encode_region(*reinterpret_cast<Region*>(meta), &out);
    if (meta->info->api == GST_VIDEO_META_API_TYPE)
      encode_video(*reinterpret_cast<GstVideoMeta*>(meta), &out);
  }
  if (const auto client = gst::get_client_id(buffer)) {
    put_kind(&out, MetaKind::Client);
    out.put(*client);
  }
  encode_maps(buffer, &out);
  const auto bytes = out.finish().subspan(sizeof(isolate::MessageHead));
  return {bytes.begin(), bytes.end()};
}

Status decode_metas(std::span<const std::byte> bytes, GstBuffer* buffer) {
  MessageReader in(bytes);
  while (!in.complete()) {
    const auto kind = static_cast<MetaKind>(in.take<uint32_t>());
    if (auto status = decode_one(kind, &in, buffer); !status) return status;
    if (in.is_spoiled()) return invalid("metadata that is cut off");
  }
  return ok();
}

}  // namespace weir
