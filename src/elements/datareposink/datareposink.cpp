// datareposink: writes the samples of a stream to files, and a JSON file that describes them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <optional>
#include <string>

#include "elements/datareposink/recording.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/base_classes.hpp"
#include "gstcpp/element/described_caps.hpp"

namespace weir {
namespace {

class Datareposink : public gst::Element<Datareposink, gst::BaseSink> {
 public:
  static constexpr gst::ElementInfo kInfo{
      "WeirDatareposink", "datareposink", "DataRepoSink", "Sink/File",
      "Writes the samples of a stream to files, and a JSON file that describes them"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE(
          "sink", GST_PAD_SINK, GST_PAD_ALWAYS,
          GST_STATIC_CAPS(WEIR_CAPS_TENSORS(
              "{ static, flexible, sparse }") "; video/x-raw, format=(string){ RGB, BGR, RGBx, "
                                              "BGRx, xRGB, xBGR, RGBA, BGRA, ARGB, "
                                              "ABGR, GRAY8 }, width=(int)[ 1, 2147483647 ], "
                                              "height=(int)[ 1, 2147483647 ], " WEIR_CAPS_RATE
                                              ", interlace-mode=(string)progressive"
                                              "; audio/x-raw, format=(string){ S8, U8, S16LE, "
                                              "S16BE, U16LE, U16BE, S32LE, S32BE, "
                                              "U32LE, U32BE, F32LE, F32BE, F64LE, F64BE }, "
                                              "rate=(int)[ 1, 2147483647 ], "
                                              "channels=(int)[ 1, 2147483647 ], "
                                              "layout=(string)interleaved"
                                              "; image/png, width=(int)[ 16, 1000000 ], "
                                              "height=(int)[ 16, 1000000 ], " WEIR_CAPS_RATE
                                              "; image/jpeg, width=(int)[ 16, 65535 ], "
                                              "height=(int)[ 16, 65535 ], " WEIR_CAPS_RATE
                                              ", sof-marker=(int){ 0, 1, 2, 4, 9 }"
                                              "; image/tiff, endianness=(int){ 4321, 1234 }; "
                                              "image/gif; image/bmp"
                                              "; text/x-raw, format=(string)utf8; "
                                              "application/octet-stream")),
  };

  struct Settings {
    std::optional<std::string> location, json;
  };
  static constexpr std::tuple kProperties{
      gst::Property{"location", &Settings::location,
                    "File of the samples; for pictures a pattern of files such as img_%04d.png"},
      gst::Property{"json", &Settings::json,
                    "JSON file that describes the samples, written when the element stops"},
  };

  Status start() {
    const Settings s = settings();
    if (!is_set(s.location)) return not_set("location", "the file of the samples");
    if (!is_set(s.json)) return not_set("json", "the file that describes the samples");
    return dataset::check_writable("json", *s.json);
  }

  // GstBaseSink calls start() and stop() for READY and NULL. Each stream replaces the files.
  GstStateChangeReturn change_state(GstStateChange change) {
    if (change == GST_STATE_CHANGE_READY_TO_PAUSED) {
      const Settings s = settings();
      ledger_.reset();
      recording_ = Recording(s.location.value_or(""));
      json_ = s.json.value_or("");
    }
    return GST_ELEMENT_CLASS(parent_class())->change_state(element(), change);
  }

  gboolean query(GstQuery* query) {
    return gst::with_static_filter(
        query, [&](GstQuery* described) { return parent_class()->query(self(), described); });
  }

  Status set_caps(GstCaps* caps) {
    const auto sample = read_sample_caps(caps);
    return sample ? recording_.set_caps(*sample) : Status(sample.error());
  }

  GstFlowReturn render(GstBuffer* buffer) {
    ledger_.received();
    const Status status = recording_.has_caps()
                              ? recording_.add(buffer)
                              : Status(gst::buffer_before_caps("tensor_converter ! datareposink"));
    if (!status) {
      ledger_.dropped(DropReason::Error);
      gst::post_error(element(), status.error());
      return recording_.has_caps() ? GST_FLOW_ERROR : GST_FLOW_NOT_NEGOTIATED;
    }
    ledger_.consumed();
    if (const auto warning = recording_.take_warning()) gst::post_warning(element(), *warning);
    return GST_FLOW_OK;
  }

  // Also after an error: the samples before it are described.
  Status stop() { return std::exchange(recording_, {}).finish(json_); }

  Settings settings_;
  Ledger ledger_;

 private:
  static bool is_set(const std::optional<std::string>& text) { return text && !text->empty(); }
  static Error not_set(const char* property, const char* needed) {
    return Error{.code = Code::OPTION_VALUE,
                 .what = std::string("the property ") + property + " is not set",
                 .needed = needed,
                 .fix = "datareposink location=samples.bin json=samples.json"};
  }

  // Set while the element is in READY, then streaming thread only.
  Recording recording_;
  std::string json_;
};

}  // namespace

bool register_datareposink(GstPlugin* plugin) {
  return Datareposink::register_in(plugin);
}

}  // namespace weir
