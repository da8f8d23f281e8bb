// tensor_query_serversink: answers the requests of clients with the frames that it receives.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>

#include "edge/query_server_registry.hpp"
#include "edge/request_meta.hpp"
#include "edge/request_watch.hpp"
#include "edge/serversrc_settings.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/base_classes.hpp"
#include "gstcpp/element/model_event.hpp"

namespace weir {
namespace {

using gst::Ref;

// The first of `offered` that leave no choice but that of the framerate, which is that of the
// requests. Null if there are none.
Ref<GstCaps> first_known_caps(const GstCaps* offered, const Fraction& rate) {
  if (gst_caps_is_any(offered)) return {};
  for (guint i = 0; i < gst_caps_get_size(offered); ++i) {
    auto caps = Ref<GstCaps>::adopt(gst_caps_copy_nth(offered, i));
    GstStructure* structure = gst_caps_get_structure(caps.get(), 0);
    const bool is_tensors = gst_structure_has_name(structure, "other/tensors") ||
                            gst_structure_has_name(structure, "other/tensor");
    if (gst_structure_has_field(structure, "framerate"))
      gst_structure_fixate_field_nearest_fraction(structure, "framerate", rate.numerator,
                                                  rate.denominator);
    else if (is_tensors)
      gst_structure_set(structure, "framerate", GST_TYPE_FRACTION, rate.numerator, rate.denominator,
                        nullptr);
    if (gst_caps_is_fixed(caps.get()) && (!is_tensors || gst::fixed_spec_from_caps(caps.get())))
      return caps;
  }
  return {};
}

struct SinkSettings {
  QueryConnectType connect_type = QueryConnectType::Tcp;
  uint32_t id = 0, timeout = 10;
  int limit = 0;
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
      gst::Property{
          "limit", &Settings::limit,
          "Number of frames in a row without a request that is an error; fewer are dropped; 0 = 1",
          gst::Changeable::InReady, 0, 65535},
      gst::Property{"connect-type", &Settings::connect_type,
                    "Accepted for compatibility; has no effect"},
      gst::Property{"timeout", &Settings::timeout, "Accepted for compatibility; has no effect",
                    gst::Changeable::InReady, 0u, 3600u},
  };

  void constructed() {
    // A response is sent when it is there, not when a picture of its time would be shown.
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

  gboolean stop() {
    server_ = nullptr;
    return TRUE;
  }

  Status set_caps(GstCaps* caps) {
    const uint32_t id = settings().id;
    auto server = find_server(id);
    if (!server)
      return Error{.code = Code::OPTION_VALUE,
                   .what = "no tensor_query_serversrc has the same id",
                   .offered = "tensor_query_serversink id=" + std::to_string(id),
                   .needed = "a tensor_query_serversrc of this process with that id",
                   .fix = "tensor_query_serversrc id=" + std::to_string(id)};
    if (!caps) return gst::buffer_before_caps();
    server_ = std::move(server);
    const auto model = gst::find_model(GST_BASE_SINK_PAD(self()));
    return server_->set_output(
        caps, parse_name_list(property_upstream(GST_BASE_SINK_PAD(self()), "outputname")),
        model ? &*model : nullptr);
  }

  // A tensor_query_serversrc that starts again has another server, but its caps may be the same:
  // then GstBaseSink does not call set_caps().
  gboolean event(GstEvent* event) {
    const bool has_server = is_server_event(event);
    const gboolean handled = parent_class()->event(self(), event);
    return handled && (!has_server || follow_server());
  }

  gboolean query(GstQuery* query) {
    if (!is_output_query(query)) return parent_class()->query(self(), query);
    expect_output(get_input_rate(query));
    return TRUE;
  }

  GstFlowReturn render(GstBuffer* buffer) {
    ledger_.received();
    const auto request = get_request(buffer);
    uint64_t copied = 0;
    const auto delivery = respond(request.get(), buffer, &copied);
    if (!delivery) {
      ledger_.dropped(DropReason::Error);
      gst::post_error(element(), delivery.error());
      return GST_FLOW_ERROR;
    }
    if (*delivery == Delivery::NoRequest) return count_without_request(nullptr);
    if (*delivery == Delivery::OtherServer) return count_without_request(request.get());
    without_request_ = 0;
    ledger_.copied(copied);
    if (*delivery == Delivery::Lost)
      ledger_.dropped(DropReason::Lost);
    else
      ledger_.consumed();
    return GST_FLOW_OK;
  }

  Settings settings_;
  Ledger ledger_;

 private:
  Result<Delivery> respond(QueryRequest* request, GstBuffer* buffer, uint64_t* copied) {
    if (!server_)  // a stream without caps: set_caps() was not called
      if (auto status = set_current_caps(); !status) return status.error();
    return server_->respond(request, buffer, copied);
  }
  // On the source's streaming thread. The caps may come later than this, or with a request.
  void expect_output(const Fraction& rate) {
    const auto server = find_server(settings().id);
    GstPad* const pad = GST_BASE_SINK_PAD(self());
    if (!server || gst_pad_has_current_caps(pad)) return;
    const auto offered = Ref<GstCaps>::adopt(gst_pad_peer_query_caps(pad, nullptr));
    const auto expected = first_known_caps(offered.get(), rate);
    const auto names = parse_name_list(property_upstream(pad, "outputname"));
    if (auto status = server->expect_output(expected.get(), names); !status)
      GST_CAT_WARNING_OBJECT(category(), self(), "%s", status.error().message().c_str());
  }
  bool follow_server() {
    const auto server = find_server(settings().id);
    if (!server_ || !server || server == server_) return true;
    const auto status = set_current_caps();
    if (!status) gst::post_error(element(), status.error());
    return bool(status);
  }
  Status set_current_caps() {
    const auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(GST_BASE_SINK_PAD(self())));
    return set_caps(caps.get());
  }
  // `others`: the request of another server; null for a frame without one.
  GstFlowReturn count_without_request(const QueryRequest* others) {
    const int limit = std::max(settings().limit, 1);
    ledger_.dropped(DropReason::Policy);
    if (++without_request_ < limit) return GST_FLOW_OK;
    gst::post_error(element(), others ? other_requests(others->source_id()) : no_requests(limit));
    return GST_FLOW_ERROR;
  }

  Error no_requests(int limit) const {
    return {.code = Code::OPTION_VALUE,
            .what = "frames arrive that do not belong to a request",
            .offered = std::to_string(without_request_) + " in a row",
            .needed =
                "frames of a tensor_query_serversrc, passed through elements that keep the "
                "metadata of buffers",
            .fix = "tensor_query_serversink limit=" + std::to_string(limit + 1)};
  }
  Error other_requests(uint32_t source) const {
    const std::string sink = "tensor_query_serversink id=", own = std::to_string(settings().id);
    return {.code = Code::OPTION_VALUE,
            .what = "frames arrive that answer requests of a server with another protocol",
            .offered = "at " + sink + own +
                       ": requests of tensor_query_serversrc id=" + std::to_string(source),
            .needed = "frames of tensor_query_serversrc id=" + own +
                      "; those of another protocol need a tensor_query_serversink of their own",
            .fix = sink + std::to_string(source) + " for these frames"};
  }

  // Streaming thread only.
  std::shared_ptr<QueryServer> server_;
  int without_request_ = 0;
};

}  // namespace

bool register_tensor_query_serversink(GstPlugin* plugin) {
  return TensorQueryServersink::register_in(plugin);
}

}  // namespace weir
