// tensor_decoder: the results of a network become labels, pictures or bytes.
#include <array>
#include <cstring>
#include <memory>

#include "core/infer/decoder.hpp"
#include "core/infer/module_library.hpp"
#include "elements/tensor_decoder/buffer_sink.hpp"
#include "gstcpp/base_classes.hpp"
#include "gstcpp/frame_arguments.hpp"
#include "gstcpp/property_file.hpp"
#include "gstcpp/tensor_caps.hpp"

namespace weir {
namespace {

using gst::Ref;

class TensorDecoder : public gst::Element<TensorDecoder, gst::BaseTransform> {
 public:
  static constexpr gst::ElementInfo kInfo{
      "WeirTensorDecoder", "tensor_decoder", "TensorDecoder", "Converter/Tensor",
      "Turns the results of a network into labels, pictures or bytes"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE(
          "sink", GST_PAD_SINK, GST_PAD_ALWAYS,
          GST_STATIC_CAPS(WEIR_CAPS_TENSOR
                          "; other/tensors, format=(string)static, num_tensors=(int)[ 1, 256 "
                          "], " WEIR_CAPS_RATE "; " WEIR_CAPS_TENSORS("flexible"))),
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY),
  };

  struct Settings {
    bool silent = true;
    std::string mode;
    std::optional<std::string> option1, option2, option3, option4, option5, option6, option7,
        option8, option9;
    std::string config_file;
    Status config_status = ok();  // of reading it; told when the stream starts
    std::vector<Error> config_warnings;
  };
  std::string sub_plugins() const {
    std::string out;
    for (const auto& name : infer::ModuleLibrary::instance().decoder_names())
      out += (out.empty() ? "" : ",") + name;
    return out;
  }
  static constexpr char kOption[] = "An option of the decoder; see its README";
  static constexpr std::tuple kProperties{
      gst::Property{"silent", &Settings::silent, "Accepted for compatibility; has no effect"},
      gst::Property{"mode", &Settings::mode, "Name of the decoder"},
      gst::Property{"option1", &Settings::option1, kOption},
      gst::Property{"option2", &Settings::option2, kOption},
      gst::Property{"option3", &Settings::option3, kOption},
      gst::Property{"option4", &Settings::option4, kOption},
      gst::Property{"option5", &Settings::option5, kOption},
      gst::Property{"option6", &Settings::option6, kOption},
      gst::Property{"option7", &Settings::option7, kOption},
      gst::Property{"option8", &Settings::option8, kOption},
      gst::Property{"option9", &Settings::option9, kOption},
      gst::Property{"config-file", &Settings::config_file,
                    "File with lines of property=value, read when this is set"},
      gst::ReadOnly{"sub-plugins", &TensorDecoder::sub_plugins, "Decoders that are installed"},
  };

  void property_changed(const char* name) {
    if (std::strcmp(name, "config-file") != 0) return;
    const std::string path = settings().config_file;
    std::vector<Error> passed_over;
    Status status = path.empty()
                        ? ok()
                        : gst::set_properties_from_file(G_OBJECT(element()), path, &passed_over);
    change_settings([&](Settings& s) {
      s.config_status = std::move(status);
      s.config_warnings = std::move(passed_over);
    });
  }

  Status start() {
    ledger_.reset();
    const Settings given = settings();
    if (!given.config_status) return given.config_status;
    // Not before: an element that is being made has no bus.
    for (const auto& warning : given.config_warnings) gst::post_warning(element(), warning);
    auto decoder = open();
    if (!decoder) return decoder.error();
    auto probe = open();
    if (!probe) return probe.error();
    std::lock_guard lock(probe_mutex_);
    decoder_ = *std::move(decoder);
    probe_ = *std::move(probe);
    return ok();
  }
  bool stop() {
    std::lock_guard lock(probe_mutex_);
    decoder_.reset();
    probe_.reset();
    return true;
  }

  GstCaps* transform_caps(GstPadDirection direction, GstCaps* caps, GstCaps* filter) {
    auto result = direction == GST_PAD_SRC ? Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(
                                                 GST_BASE_TRANSFORM_SINK_PAD(self())))
                                           : output_for(caps);
    if (!filter) return result.release();
    return gst_caps_intersect_full(filter, result.get(), GST_CAPS_INTERSECT_FIRST);
  }

  Status set_caps(GstCaps* in, GstCaps*) {
    auto spec = gst::fixed_spec_from_caps(in);
    if (!spec) return spec.error();
    input_ = *std::move(spec);
    auto caps = configure(decoder_.get(), input_);
    return caps ? ok() : Status(caps.error());
  }

  GstFlowReturn submit_input_buffer(gboolean discont, GstBuffer* buffer) {
    ledger_.received();
    const auto flow = parent_class()->submit_input_buffer(self(), discont, buffer);
    if (flow != GST_FLOW_OK)
      ledger_.dropped(flow == GST_BASE_TRANSFORM_FLOW_DROPPED ? DropReason::Qos
                                                              : DropReason::Error);
    return flow;
  }

  GstFlowReturn prepare_output_buffer(GstBuffer* in, GstBuffer** out) {
    *out = gst_buffer_new();
    gst_buffer_copy_into(*out, in, GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
    return GST_FLOW_OK;
  }

  gboolean sink_event(GstEvent* event) {
    const bool flushed = GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_STOP;
    if (flushed && decoder_) decoder_->reset();
    return parent_class()->sink_event(self(), event);
  }

  GstFlowReturn transform(GstBuffer* in, GstBuffer* out) {
    const auto kept = decode(in, out);
    reader_.clear();
    if (!kept) {
      gst::post_error(element(), kept.error());
      ledger_.dropped(DropReason::Error);
      return GST_FLOW_ERROR;
    }
    if (!*kept) {
      ledger_.dropped(DropReason::Policy);
      return GST_BASE_TRANSFORM_FLOW_DROPPED;
    }
    ledger_.consumed_and_pushed();
    return GST_FLOW_OK;
  }

  Settings settings_;
  Ledger ledger_;

 private:
  Result<std::unique_ptr<infer::Decoder>> open() const {
    const Settings s = settings();
    if (s.mode.empty())
      return Error{Code::DECODER_UNKNOWN,
                   "no mode is set",
                   "mode=\"\"",
                   "one of: " + sub_plugins(),
                   "",
                   "tensor_decoder mode=octet_stream"};
    const auto type = infer::ModuleLibrary::instance().decoder(s.mode);
    if (!type) return type.error();
    const std::array options{&s.option1, &s.option2, &s.option3, &s.option4, &s.option5,
                             &s.option6, &s.option7, &s.option8, &s.option9};
    infer::Decoder::Options given;
    for (size_t i = 0; i < options.size(); ++i)
      if (*options[i]) given.emplace_back("option" + std::to_string(i + 1), **options[i]);
    return infer::Decoder::open(**type, given);
  }

  // Tells the decoder its input and gives the caps it answers, with the stream's rate.
  static Result<Ref<GstCaps>> configure(infer::Decoder* decoder, const FrameSpec& spec) {
    std::vector<weir_tensor_info> infos;
    if (spec.format == Format::Static)
      for (const auto& tensor : spec.tensors) infos.push_back(gst::tensor_info(tensor));
    BufferSink sink;
    if (auto status = decoder->configure(infos, &sink); !status) return status.error();
    auto caps = Ref<GstCaps>::adopt(
        sink.caps().empty() ? nullptr : gst_caps_from_string(sink.caps().c_str()));
    if (!caps || gst_caps_is_empty(caps.get()) || gst_caps_is_any(caps.get()))
      return Error{Code::INTERNAL,
                   "the decoder gives no caps that can be read",
                   "\"" + sink.caps() + "\"",
                   "caps as text, for example text/x-raw,format=(string)utf8",
                   "",
                   "mend the decoder's configure"};
    if (spec.rate.valid())
      gst_caps_set_simple(caps.get(), "framerate", GST_TYPE_FRACTION, spec.rate.numerator,
                          spec.rate.denominator, nullptr);
    return caps;
  }

  Ref<GstCaps> output_for(GstCaps* caps) {
    const auto any = [] { return Ref<GstCaps>::adopt(gst_caps_new_any()); };
    if (!gst_caps_is_fixed(caps)) return any();
    std::lock_guard lock(probe_mutex_);
    if (!probe_) return any();
    const auto spec = gst::fixed_spec_from_caps(caps);
    auto out = spec ? configure(probe_.get(), *spec) : spec.error();
    if (out) return *out;
    gst::post_error(element(), out.error());
    return Ref<GstCaps>::adopt(gst_caps_new_empty());
  }

  Result<bool> decode(GstBuffer* in, GstBuffer* out) {
    if (auto status = reader_.read(in, input_); !status) return status.error();
    ledger_.copied(reader_.bytes_copied());
    BufferSink sink(in, out, &reader_, &ledger_);
    return decoder_->decode(arguments_.fill(reader_, in), &sink);
  }

  std::mutex probe_mutex_;                   // guards probe_
  std::unique_ptr<infer::Decoder> probe_;    // answers caps queries, which come from any thread
  std::unique_ptr<infer::Decoder> decoder_;  // streaming thread
  FrameSpec input_;                          // streaming thread
  gst::FrameReader reader_;                  // streaming thread
  gst::FrameArguments arguments_;            // streaming thread
};

}  // namespace

bool register_tensor_decoder(GstPlugin* plugin) {
  return TensorDecoder::register_in(plugin);
}

}  // namespace weir
