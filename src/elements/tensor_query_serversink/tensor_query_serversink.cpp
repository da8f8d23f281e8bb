// tensor_query_serversink: answers the requests of clients with the frames that it receives.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_query_serversrc/request_meta.hpp"
#include "elements/tensor_query_serversrc/request_watch.hpp"
#include "elements/tensor_query_serversrc/served_pairs.hpp"
#include "elements/tensor_query_serversrc/served_tensors.hpp"
#include "elements/tensor_query_serversrc/serversrc_settings.hpp"
#include "gstcpp/buffer/frame_reader.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/base_classes.hpp"

namespace weir {
namespace {

using gst::Ref;

struct SinkSettings {
  QueryConnectType connect_type = QueryConnectType::Tcp;
  uint32_t id = 0, timeout = 10;
  int limit = 0;
};

// The outputs of one answer: mapped until gRPC has sent them.
struct MappedAnswer {
  explicit MappedAnswer(GstBuffer* answer) : buffer(Ref<GstBuffer>::share(answer)) {}

  Ref<GstBuffer> buffer;
  gst::FrameReader reader;           // of tensors
  std::optional<gst::Mapped> whole;  // of other streams
};

class TensorQueryServersink : public gst::Element<TensorQueryServersink, gst::BaseSink> {
 public:
  static constexpr gst::ElementInfo kInfo{
      "WeirTensorQueryServerSink", "tensor_query_serversink", "TensorQueryServerSink",
      "Sink/Tensor/Query", "Answers the requests of clients with the frames that it receives"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY),
  };

  using Settings = SinkSettings;
  static constexpr std::tuple kProperties{
      gst::Property{"id", &Settings::id,
                    "Pairs this element with the tensor_query_serversrc of the same id"},
      gst::Property{"limit", &Settings::limit,
                    "Frames in a row without a request that are dropped; one more is an error",
                    gst::Changeable::InReady, 0, 65535},
      gst::Property{"connect-type", &Settings::connect_type,
                    "Accepted for compatibility; has no effect"},
      gst::Property{"timeout", &Settings::timeout, "Accepted for compatibility; has no effect",
                    gst::Changeable::InReady, 0u, 3600u},
  };

  void constructed() {
    // An answer is sent when it is there, not when a picture of its time would be shown.
    gst_base_sink_set_sync(self(), FALSE);
    // Requests come when clients want: the pipeline must not wait for a first one, and a sink must
    // not wait with its first frame for that of another.
    gst_base_sink_set_async_enabled(self(), FALSE);
    gst_base_sink_set_last_sample_enabled(self(), FALSE);
  }

  Status start() {
    ledger_.reset();
    without_request_ = 0;
    return ok();
  }

  Status set_caps(GstCaps* caps) {
    const uint32_t id = settings().id;
    const auto model = model_of_pair(id);
    if (!model)
      return Error{.code = Code::OPTION_VALUE,
                   .what = "no tensor_query_serversrc has the same id",
                   .offered = "tensor_query_serversink id=" + std::to_string(id),
                   .needed = "a tensor_query_serversrc of this process with that id",
                   .fix = "tensor_query_serversrc protocol=oip id=" + std::to_string(id)};
    has_tensors_ = has_tensors(caps);
    if (!has_tensors_) {
      outputs_ = describe_bytes("output");
    } else {
      auto spec = gst::spec_from_caps(caps);
      if (!spec) return spec.error();
      spec_ = *std::move(spec);
      outputs_ = describe_tensors(spec_.tensors, "output");
    }
    model->set_outputs(outputs_);
    return ok();
  }

  GstFlowReturn render(GstBuffer* buffer) {
    ledger_.received();
    const auto request = request_of(buffer);
    if (!request) return count_without_request();
    without_request_ = 0;
    const auto answer = std::make_shared<MappedAnswer>(buffer);
    auto tensors = read(answer.get());
    if (!tensors) {
      ledger_.dropped(DropReason::Error);
      request->fail(net::CallStatus::Internal, tensors.error().message());
      gst::post_error(element(), tensors.error());
      return GST_FLOW_ERROR;
    }
    ledger_.copied(answer->reader.bytes_copied());
    request->answer(*tensors, answer);
    ledger_.consumed();
    return GST_FLOW_OK;
  }

  Settings settings_;
  Ledger ledger_;

 private:
  GstFlowReturn count_without_request() {
    const int limit = settings().limit;
    ledger_.dropped(DropReason::Policy);
    if (++without_request_ <= limit) return GST_FLOW_OK;
    gst::post_error(
        element(),
        Error{.code = Code::OPTION_VALUE,
              .what = "frames arrive that answer no request",
              .offered = std::to_string(without_request_) + " in a row",
              .needed = "frames made from those of a tensor_query_serversrc, by elements that keep "
                        "the metadata of buffers",
              .fix = "tensor_query_serversink limit=" + std::to_string(limit + 1)});
    return GST_FLOW_ERROR;
  }

  // The tensors of the answer. They refer to outputs_ or frame_outputs_, and to `answer`.
  Result<std::vector<net::RequestTensor>> read(MappedAnswer* answer) {
    std::vector<net::RequestTensor> out;
    if (!has_tensors_) {
      answer->whole.emplace(answer->buffer.get(), GST_MAP_READ);
      if (!*answer->whole)
        return Error{.code = Code::MAPPING_FAILED, .what = "the frame cannot be mapped"};
      out.push_back(
          {outputs_[0].name, outputs_[0].datatype, outputs_[0].shape, answer->whole->bytes()});
      return out;
    }
    if (auto status = answer->reader.read(answer->buffer.get(), spec_); !status)
      return status.error();
    const auto& views = answer->reader.tensors();
    if (spec_.format != Format::Static) describe_frame(views);
    const auto& described = spec_.format == Format::Static ? outputs_ : frame_outputs_;
    for (size_t i = 0; i < views.size(); ++i)
      out.push_back(
          {described[i].name, described[i].datatype, described[i].shape, views[i].payload});
    return out;
  }
  void describe_frame(const std::vector<gst::TensorView>& views) {
    std::vector<TensorSpec> specs;
    specs.reserve(views.size());
    for (const auto& view : views) specs.push_back(view.spec);
    frame_outputs_ = describe_tensors(specs, "output");
  }

  // Streaming thread only.
  bool has_tensors_ = false;
  FrameSpec spec_;
  std::vector<net::TensorText> outputs_, frame_outputs_;
  int without_request_ = 0;
};

}  // namespace

bool register_tensor_query_serversink(GstPlugin* plugin) {
  return TensorQueryServersink::register_in(plugin);
}

}  // namespace weir
