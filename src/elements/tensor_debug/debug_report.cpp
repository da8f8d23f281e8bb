// Describes streams and buffers as text; unreadable data becomes part of the text, never an error.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_debug/debug_report.hpp"

#include "core/text/text.hpp"
#include "gstcpp/buffer/query_meta.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "weir/join.hpp"

namespace weir {
namespace {

std::string time_or_none(GstClockTime time) {
  return GST_CLOCK_TIME_IS_VALID(time) ? time_text(time) : "none";
}

}  // namespace

std::string caps_report(const GstCaps* caps, bool whole) {
  const auto spec = gst::spec_from_caps(caps);
  std::string out = spec ? spec->to_string() : spec.error().what;
  if (spec && spec->rate.valid())
    out += " at " + std::to_string(spec->rate.numerator) + "/" +
           std::to_string(spec->rate.denominator);
  if (!whole) return out;
  const gst::UniqueText text{gst_caps_to_string(caps)};
  return out + ": " + text.get();
}

std::string frame_report(GstBuffer* buffer, uint64_t number, DebugMetadata metadata) {
  const guint memories = gst_buffer_n_memory(buffer);
  std::vector<gsize> sizes(memories);
  for (guint i = 0; i < memories; ++i)
    sizes[i] = gst_memory_get_sizes(gst_buffer_peek_memory(buffer, i), nullptr, nullptr);
  std::string out = "frame " + std::to_string(number) + ": " + std::to_string(memories) +
                    (memories == 1 ? " memory, " : " memories, ") +
                    join(sizes, " + ", [](gsize size) { return std::to_string(size); }) + " bytes";
  const auto is_selected = [&](DebugMetadata bit) {
    return (static_cast<int>(metadata) & static_cast<int>(bit)) != 0;
  };
  if (is_selected(DebugMetadata::Timestamp))
    out += ", pts " + time_or_none(GST_BUFFER_PTS(buffer)) + ", dts " +
           time_or_none(GST_BUFFER_DTS(buffer)) + ", duration " +
           time_or_none(GST_BUFFER_DURATION(buffer));
  if (is_selected(DebugMetadata::QueryServer)) {
    const auto client = gst::client_of(buffer);
    out += client ? ", client " + std::to_string(*client) : ", no client";
  }
  return out;
}

}  // namespace weir
