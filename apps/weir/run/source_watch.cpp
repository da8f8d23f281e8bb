// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/source_watch.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include "gstcpp/element/elements.hpp"
#include "gstcpp/element/posted_error.hpp"
#include "run/element_properties.hpp"

namespace weir::app {
namespace {

// A bin has the source flag when a child has it. A bin such as rtspsrc is a source of its own.
bool is_source(GstElement* element) {
  if (get_class(element).find("Source") != std::string_view::npos) return true;
  return GST_OBJECT_FLAG_IS_SET(element, GST_ELEMENT_FLAG_SOURCE) && !GST_IS_BIN(element);
}

// Returns the outermost source that is `object` or contains it; null if there is none.
GstElement* find_source(GstObject* object) {
  GstElement* out = nullptr;
  for (; object; object = GST_OBJECT_PARENT(object))
    if (GST_IS_ELEMENT(object) && is_source(GST_ELEMENT(object))) out = GST_ELEMENT(object);
  return out;
}

// Returns nullopt where that cannot be known yet.
std::optional<bool> is_live(GstPad* pad) {
  const auto query = gst::Ref<GstQuery>::adopt(gst_query_new_latency());
  if (!gst_pad_query(pad, query.get())) return std::nullopt;
  gboolean live = FALSE;
  gst_query_parse_latency(query.get(), &live, nullptr, nullptr);
  return live == TRUE;
}

// Returns the microseconds between two buffers that the caps of a camera or microphone promise, 0
// where they name no rate; nullopt for other streams.
std::optional<gint64> find_period(GstElement* source, GstPad* pad) {
  const auto caps = gst::Ref<GstCaps>::adopt(gst_pad_get_current_caps(pad));
  if (!caps || gst_caps_get_size(caps.get()) == 0) return std::nullopt;
  const GstStructure* structure = gst_caps_get_structure(caps.get(), 0);
  if (gst_structure_has_name(structure, "application/x-rtp")) {
    const char* media = gst_structure_get_string(structure, "media");
    return media && std::string_view(media) == "video" ? std::optional<gint64>(0) : std::nullopt;
  }
  // Others, such as sources of messages, may rest although their caps have a rate.
  const std::string_view klass = get_class(source);
  if (klass.find("Video") == std::string_view::npos &&
      klass.find("Audio") == std::string_view::npos)
    return std::nullopt;
  if (gst_structure_has_name(structure, "audio/x-raw")) return 0;
  int numerator = 0, denominator = 0;
  if (!gst_structure_get_fraction(structure, "framerate", &numerator, &denominator) ||
      numerator <= 0)
    return std::nullopt;
  return gst_util_uint64_scale_int(G_USEC_PER_SEC, denominator, numerator);
}

// What a source still holds at a warning, as the jitter buffers of rtspsrc.
constexpr gint64 kMaxDrainUs = gint64{10} * G_USEC_PER_SEC;

}  // namespace

struct SourceWatch::Stream {
  gst::Ref<GstElement> source;
  gst::Ref<GstPad> pad;
  const gint64 added = g_get_monotonic_time();
  std::atomic<gint64> last = 0;  // monotonic microseconds of the last buffer; 0 = none
  // Of find_silent(), on its thread.
  gint64 since = 0;  // its first call
  std::optional<bool> is_live{};
};

SourceWatch::SourceWatch(GstElement* pipeline) : pipeline_(gst::Ref<GstElement>::share(pipeline)) {
  g_signal_connect(pipeline, "deep-element-added",
                   G_CALLBACK(+[](GstBin*, GstBin*, GstElement* element, gpointer self) {
                     static_cast<SourceWatch*>(self)->watch(element);
                   }),
                   this);
  for (const auto& element : gst::elements_in(pipeline)) watch(element.get());
}

SourceWatch::~SourceWatch() {
  g_signal_handlers_disconnect_by_data(pipeline_.get(), this);
}

void SourceWatch::watch(GstElement* element) {
  if (find_source(GST_OBJECT(element)) != element) return;
  for (GList* item = element->srcpads; item; item = item->next) watch(element, GST_PAD(item->data));
  g_signal_connect(element, "pad-added",
                   G_CALLBACK(+[](GstElement* source, GstPad* pad, gpointer self) {
                     if (gst_pad_get_direction(pad) == GST_PAD_SRC)
                       static_cast<SourceWatch*>(self)->watch(source, pad);
                   }),
                   this);
}

void SourceWatch::watch(GstElement* source, GstPad* pad) {
  auto stream = std::make_unique<Stream>();
  stream->source = gst::Ref<GstElement>::share(source);
  stream->pad = gst::Ref<GstPad>::share(pad);
  const auto on_data = +[](GstPad*, GstPadProbeInfo*, gpointer user) {
    static_cast<Stream*>(user)->last.store(g_get_monotonic_time(), std::memory_order_relaxed);
    return GST_PAD_PROBE_OK;
  };
  gst_pad_add_probe(
      pad, static_cast<GstPadProbeType>(GST_PAD_PROBE_TYPE_BUFFER | GST_PAD_PROBE_TYPE_BUFFER_LIST),
      on_data, stream.get(), nullptr);
  std::lock_guard lock(mutex_);
  streams_.push_back(std::move(stream));
}

void SourceWatch::on_warning(GstMessage* warning) {
  GstElement* source = find_source(GST_MESSAGE_SRC(warning));
  const auto posted = gst::read_posted_error(warning);
  if (!source ||
      !g_error_matches(posted.original.get(), GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_READ))
    return;
  std::lock_guard lock(mutex_);
  losses_.push_back(
      {g_get_monotonic_time(), gst::Ref<GstElement>::share(source), parse_diagnostic(warning)});
}

std::optional<Diagnostic> SourceWatch::find_lost() const {
  std::lock_guard lock(mutex_);
  for (const auto& loss : losses_) {
    const auto delivers = [&loss](const auto& stream) {
      return stream->source == loss.source &&
             (stream->added > loss.time || stream->last > loss.time + kMaxDrainUs);
    };
    if (std::none_of(streams_.begin(), streams_.end(), delivers)) return loss.warning;
  }
  return std::nullopt;
}

std::string SourceWatch::find_silent(gint64 max_us) const {
  const gint64 now = g_get_monotonic_time();
  std::vector<Stream*> streams;  // queries may take locks that a source holds as it adds a pad
  {
    std::lock_guard lock(mutex_);
    for (const auto& stream : streams_) streams.push_back(stream.get());
  }
  for (Stream* stream : streams) {
    if (!gst_pad_is_active(stream->pad.get())) continue;  // removed
    const auto period = find_period(stream->source.get(), stream->pad.get());
    if (!period) continue;
    if (!stream->is_live) stream->is_live = is_live(stream->pad.get());
    if (!stream->is_live.value_or(false)) continue;
    if (stream->since == 0) stream->since = now;
    const gint64 last = std::max<gint64>(stream->last, stream->since);
    if (now - last > std::max(max_us, 2 * *period)) return GST_OBJECT_NAME(stream->source.get());
  }
  return "";
}

}  // namespace weir::app
