// tensor_debug: passes every frame unchanged and logs it unless it is silent.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

#include <cstdio>
#include <deque>
#include <mutex>
#include <string>

#include "core/text/text.hpp"
#include "gstcpp/buffer/query_meta.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/counted_transform.hpp"
#include "weir/join.hpp"

namespace weir {
namespace {

// Bits of the property `metadata`.
enum class DebugMetadata : int { Disabled = 0, Timestamp = 1, QueryServer = 2 };

std::string time_or_none(GstClockTime time) {
  return GST_CLOCK_TIME_IS_VALID(time) ? time_text(time) : "none";
}

// "1 tensor: uint8 3:224:224:1 at 30/1", or why there is no such text; with `whole` also the caps.
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

// "frame 7: 2 memories, 150528 + 4 bytes", and what `metadata` selects.
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
    const auto client = gst::get_client_id(buffer);
    out += client ? ", client " + std::to_string(*client) : ", no client";
  }
  return out;
}

// The console and GStreamer's log each have two bits for the level.
enum class DebugOutput : int {
  Disabled = 0,
  ConsoleInfo = 0x11,
  ConsoleWarn = 0x12,
  ConsoleError = 0x13,
  GstDebugInfo = 0x24,
  GstDebugWarn = 0x28,
  GstDebugError = 0x2C,
  CircularBuffer = 0x100,
  FileWrite = 0x200
};
enum class DebugCapability : int { Disabled = 0, Updates, UpdatesFull, Always };

}  // namespace

}  // namespace weir

namespace weir::gst {
template <>
struct FlagsType<DebugOutput> {
  static GType type() {
    static const GFlagsValue values[] = {
        {0, "Log nothing", "disabled"},
        {0x11, "Information on the console", "console-info"},
        {0x12, "Warnings on the console", "console-warn"},
        {0x13, "Errors on the console", "console-error"},
        {0x24, "Information in GStreamer's log", "gstdebug-info"},
        {0x28, "Warnings in GStreamer's log", "gstdebug-warn"},
        {0x2C, "Errors in GStreamer's log", "gstdebug-error"},
        {0x100, "The last lines, in the property stats", "circularbuf"},
        {0x200, "Accepted; has no effect, since no property gives a file name", "filewrite"},
        {0, nullptr, nullptr}};
    static const GType t = g_flags_register_static("WeirDebugOutput", values);
    return t;
  }
};
template <>
struct FlagsType<DebugMetadata> {
  static GType type() {
    static const GFlagsValue values[] = {{0, "None", "disabled"},
                                         {1, "Timestamps", "timestamp"},
                                         {2, "The client of a query server", "queryserver"},
                                         {0, nullptr, nullptr}};
    static const GType t = g_flags_register_static("WeirDebugMetadata", values);
    return t;
  }
};
template <>
struct EnumType<DebugCapability> {
  static GType type() {
    static const GEnumValue values[] = {{0, "Nothing", "disabled"},
                                        {1, "Each change of the tensors", "updates"},
                                        {2, "Each change, with the whole caps", "updates-full"},
                                        {3, "Each change and each frame", "always"},
                                        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirDebugCapability", values);
    return t;
  }
};
}  // namespace weir::gst

namespace weir {
namespace {

constexpr size_t kLastLines = 64;

class TensorDebug : public gst::CountedTransform<TensorDebug> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirTensorDebug", "tensor_debug", "TensorDebug",
                                          "Filter/Tensor",
                                          "Passes tensors unchanged and logs them"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_CAPS_TENSORS("{ static, flexible, sparse }"))),
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_CAPS_TENSORS("{ static, flexible, sparse }"))),
  };
  struct Settings {
    bool silent = true;
    DebugOutput output_method = DebugOutput::ConsoleInfo;
    DebugCapability capability = DebugCapability::UpdatesFull;
    DebugMetadata metadata = DebugMetadata::Disabled;
  };
  static constexpr std::tuple kProperties{
      gst::Property{"silent", &Settings::silent, "False = log what passes",
                    gst::Changeable::WhilePlaying},
      gst::Property{"output-method", &Settings::output_method, "Where to log",
                    gst::Changeable::WhilePlaying},
      gst::Property{"capability", &Settings::capability, "When to log",
                    gst::Changeable::WhilePlaying},
      gst::Property{"metadata", &Settings::metadata,
                    "What to log of each frame in addition to its sizes",
                    gst::Changeable::WhilePlaying},
  };

  void constructed() { gst_base_transform_set_passthrough(self(), TRUE); }

  Status start() {
    ledger_.reset();
    frames_ = 0;
    std::lock_guard lock(lines_mutex_);
    lines_.clear();
    return ok();
  }

  gboolean set_caps(GstCaps* in, GstCaps*) {
    const Settings s = settings();
    if (!s.silent && s.capability != DebugCapability::Disabled)
      say(s, caps_report(in, s.capability == DebugCapability::UpdatesFull));
    return TRUE;
  }

  GstFlowReturn transform_ip(GstBuffer* buffer) {
    const Settings s = settings();
    if (!s.silent && s.capability == DebugCapability::Always)
      say(s, frame_report(buffer, frames_, s.metadata));
    ++frames_;
    ledger_.consumed_and_pushed();
    return GST_FLOW_OK;
  }

  void add_stats(GstStructure* stats) const {
    GValue list = G_VALUE_INIT;
    g_value_init(&list, GST_TYPE_ARRAY);
    {
      std::lock_guard lock(lines_mutex_);
      for (const auto& line : lines_) {
        GValue text = G_VALUE_INIT;
        g_value_init(&text, G_TYPE_STRING);
        g_value_set_string(&text, line.c_str());
        gst_value_array_append_and_take_value(&list, &text);
      }
    }
    gst_structure_take_value(stats, "last-lines", &list);
  }

  Settings settings_;

 private:
  void say(const Settings& s, const std::string& line) {
    const int method = static_cast<int>(s.output_method);
    if (method & 0x10) {
      static constexpr const char* kLevels[] = {"info", "info", "warning", "error"};
      const gst::UniqueText name{gst_object_get_name(GST_OBJECT_CAST(self()))};
      std::fprintf(stderr, "%s: %s: %s\n", name.get(), kLevels[method & 3], line.c_str());
    }
    if (method & 0x20) {
      static constexpr GstDebugLevel kLevels[] = {GST_LEVEL_INFO, GST_LEVEL_INFO, GST_LEVEL_WARNING,
                                                  GST_LEVEL_ERROR};
      gst_debug_log(category(), kLevels[method >> 2 & 3], __FILE__, __func__, __LINE__,
                    G_OBJECT(self()), "%s", line.c_str());
    }
    if (method & 0x100) {
      std::lock_guard lock(lines_mutex_);
      if (lines_.size() == kLastLines) lines_.pop_front();
      lines_.push_back(line);
    }
  }

  uint64_t frames_ = 0;             // streaming thread only
  mutable std::mutex lines_mutex_;  // guards lines_
  std::deque<std::string> lines_;
};

}  // namespace

bool register_tensor_debug(GstPlugin* plugin) {
  return TensorDebug::register_in(plugin);
}

}  // namespace weir
