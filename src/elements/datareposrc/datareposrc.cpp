// datareposrc: pushes the samples that datareposink wrote, in epochs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <optional>
#include <string>

#include "core/dataset/sample_order.hpp"
#include "elements/datareposrc/sample_reader.hpp"
#include "gstcpp/buffer/caps_text.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/base_classes.hpp"

namespace weir {
namespace {

using gst::Ref;

constexpr uint32_t kLargestIndex = INT32_MAX;

Error property_not_set(std::string property, std::string needed) {
  return Error{.code = Code::OPTION_VALUE,
               .what = "the property " + std::move(property) + " is not set",
               .needed = std::move(needed),
               .fix = "datareposrc location=samples.bin json=samples.json"};
}

class Datareposrc : public gst::Element<Datareposrc, gst::PushSource> {
 public:
  static constexpr gst::ElementInfo kInfo{
      "WeirDatareposrc", "datareposrc", "DataRepoSrc", "Source/File",
      "Pushes the samples that datareposink wrote to files, in epochs"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY),
  };

  struct Settings {
    std::optional<std::string> location, json;
    uint32_t start_sample_index = 0;
    uint32_t stop_sample_index = 0;
    uint32_t epochs = 1;
    bool is_shuffle = true;
    std::optional<std::string> tensors_sequence;
    Ref<GstCaps> caps;
    uint32_t seed = 0;
  };
  static constexpr std::tuple kProperties{
      gst::Property{"location", &Settings::location,
                    "File of the samples; for pictures a pattern of files such as img_%04d.png"},
      gst::Property{"json", &Settings::json, "JSON file that describes the samples"},
      gst::Property{"start-sample-index", &Settings::start_sample_index, "First sample to read",
                    gst::Changeable::InReady, 0u, kLargestIndex},
      gst::Property{"stop-sample-index", &Settings::stop_sample_index,
                    "Last sample to read; 0 = the last one of the file", gst::Changeable::InReady,
                    0u, kLargestIndex},
      gst::Property{"epochs", &Settings::epochs, "Number of passes over the samples",
                    gst::Changeable::InReady, 0u, kLargestIndex},
      gst::Property{"is-shuffle", &Settings::is_shuffle,
                    "Shuffle the samples in every epoch except the first"},
      gst::Property{"tensors-sequence", &Settings::tensors_sequence,
                    "Indices of the static tensors to push, in this order; unset = all"},
      gst::Property{"caps", &Settings::caps, "Caps of the samples, for files without a JSON file"},
      gst::Property{"seed", &Settings::seed,
                    "Seed of the shuffled order; 0 = a different order in each run"},
  };

  void constructed() { gst_base_src_set_format(GST_BASE_SRC(self()), GST_FORMAT_TIME); }

  Status start() {
    const Settings s = settings();
    if (s.location.value_or("").empty())
      return property_not_set("location", "the file of the samples");
    const std::string json = s.json.value_or("");
    if (json.empty() && !s.caps)
      return property_not_set("json", "the JSON file of the samples, or the property caps");
    auto reader = SampleReader::open({.location = *s.location,
                                      .json = json,
                                      .caps = s.caps,
                                      .block_bytes = gst_base_src_get_blocksize(base()),
                                      .tensor_sequence = s.tensors_sequence.value_or("")});
    if (!reader) return reader.error();
    auto order = dataset::SampleOrder::make({.start = s.start_sample_index,
                                             .stop = s.stop_sample_index,
                                             .epochs = s.epochs,
                                             .is_shuffled = s.is_shuffle,
                                             .seed = s.seed},
                                            reader->count());
    if (!order) return order.error();
    for (const auto& warning : reader->warnings()) gst::post_warning(element(), warning);
    if (reader->sample().medium == SampleCaps::Medium::Audio) report_missing_times();
    ledger_.reset();
    pushed_ = 0;
    order_ = *std::move(order);
    set_reader(*std::move(reader));
    return ok();
  }

  gboolean stop() {
    set_reader({});
    return TRUE;
  }

  GstCaps* get_caps(GstCaps* filter) {
    const auto caps = [&] {
      std::lock_guard lock(caps_mutex_);
      return caps_;
    }();
    if (!caps) return filter ? gst_caps_ref(filter) : gst_caps_new_any();
    return filter ? gst_caps_intersect_full(filter, caps.get(), GST_CAPS_INTERSECT_FIRST)
                  : gst_caps_ref(caps.get());
  }

  Status negotiate() {
    GstCaps* caps = reader_.caps();
    if (auto status = gst::check_downstream(GST_BASE_SRC_PAD(self()), caps, ""); !status)
      return status;
    gst_base_src_set_caps(base(), caps);
    return ok();
  }

  // The buffers have memory of their own.
  gboolean decide_allocation(GstQuery* query) {
    while (gst_query_get_n_allocation_pools(query) > 0)
      gst_query_remove_nth_allocation_pool(query, 0);
    return TRUE;
  }

  GstFlowReturn create(GstBuffer** out) {
    const auto index = order_.next();
    if (!index) return GST_FLOW_EOS;
    ledger_.received();
    auto buffer = reader_.read(*index, buffer_limit_);
    if (!buffer) {
      ledger_.dropped(DropReason::Error);
      gst::post_error(element(), buffer.error());
      return GST_FLOW_ERROR;
    }
    set_times(buffer->get());
    ledger_.consumed_and_pushed();
    *out = buffer->release();
    return GST_FLOW_OK;
  }

  Settings settings_;
  Ledger ledger_;
  BufferLimit buffer_limit_{kInfo.factory_name};

 private:
  GstBaseSrc* base() const { return GST_BASE_SRC(self()); }

  void set_reader(SampleReader reader) {
    reader_ = std::move(reader);
    std::lock_guard lock(caps_mutex_);
    caps_ = Ref<GstCaps>::share(reader_.caps());
  }

  void report_missing_times() {
    gst::post_warning(element(), Error{.code = Code::TIME_INVALID,
                                       .what = "buffers of audio have no timestamps",
                                       .needed = "sinks that do not wait for the time of a buffer",
                                       .fix = "sync=false at the sink"});
  }

  // The second buffer has the time of the first one, as programs for NNStreamer expect
  // (docs/compatibility/io.md 7.2).
  void set_times(GstBuffer* buffer) {
    const Fraction rate = reader_.sample().rate;
    const uint64_t number = pushed_++;
    if (rate.numerator <= 0 || rate.denominator <= 0) return;
    const auto numerator = static_cast<guint64>(rate.numerator);
    const guint64 seconds = static_cast<guint64>(rate.denominator) * GST_SECOND;
    GST_BUFFER_PTS(buffer) =
        gst_util_uint64_scale(number == 0 ? 0 : number - 1, seconds, numerator);
    GST_BUFFER_DURATION(buffer) = gst_util_uint64_scale(1, seconds, numerator);
  }

  // Set in start(), then streaming thread only.
  SampleReader reader_;
  dataset::SampleOrder order_;
  uint64_t pushed_ = 0;
  std::mutex caps_mutex_;  // guards caps_, which queries of any thread read
  Ref<GstCaps> caps_;      // of reader_
};

}  // namespace

bool register_datareposrc(GstPlugin* plugin) {
  return Datareposrc::register_in(plugin);
}

}  // namespace weir
