// tensor_query_serversrc: serves a pipeline as a model; pushes the requests of clients as frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <filesystem>
#include <functional>

#include "elements/tensor_query_serversrc/request_meta.hpp"
#include "elements/tensor_query_serversrc/request_watch.hpp"
#include "elements/tensor_query_serversrc/served_pairs.hpp"
#include "elements/tensor_query_serversrc/served_tensors.hpp"
#include "elements/tensor_query_serversrc/serversrc_settings.hpp"
#include "gstcpp/buffer/frame_pool.hpp"
#include "gstcpp/buffer/query_meta.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/base_classes.hpp"
#include "net/model_server.hpp"
#include "net/server_security.hpp"

namespace weir {
namespace {

using gst::Ref;

constexpr char kSampleCaps[] =
    "caps=\"other/tensors,format=static,num_tensors=1,dimensions=(string)3:224:224:1,"
    "types=(string)uint8,framerate=0/1\"";

std::string text_of(const GstCaps* caps) {
  const gst::UniqueText text{gst_caps_to_string(caps)};
  return text.get();
}

class TensorQueryServersrc : public gst::Element<TensorQueryServersrc, gst::PushSource> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirTensorQueryServerSrc", "tensor_query_serversrc",
                                          "TensorQueryServerSrc", "Source/Tensor/Query",
                                          "Pushes the requests of clients as frames of tensors"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY),
  };

  using Settings = ServersrcSettings;
  static constexpr std::tuple kProperties{
      gst::Property{"protocol", &Settings::protocol, "What clients speak"},
      gst::Property{"host", &Settings::host, "The address to listen on"},
      gst::Property{"port", &Settings::port,
                    "The port to listen on; 0 = a free one, which the property has while the "
                    "element is PAUSED or PLAYING",
                    gst::Changeable::InReady, 0u, 65535u},
      gst::Property{"unix-path", &Settings::unix_path,
                    "A Unix socket to listen on instead of host and port"},
      gst::Property{"id", &Settings::id,
                    "Pairs this element with the tensor_query_serversink of the same id"},
      gst::Property{"caps", &Settings::caps,
                    "Caps of the requests; without it those that the downstream element needs"},
      gst::Property{"model-name", &Settings::model_name,
                    "Name of the model; default: that of the model file of the next filter, or "
                    "this element's name"},
      gst::Property{"model-version", &Settings::model_version, "Version of the model"},
      gst::Property{"queue", &Settings::queue,
                    "Requests that wait for the pipeline; more are refused at once",
                    gst::Changeable::InReady, 1u, 65536u},
      gst::Property{"max-message", &Settings::max_message, "Largest message in bytes",
                    gst::Changeable::InReady, 1024u, 2147483647u},
      gst::Property{"max-requests", &Settings::max_requests,
                    "Requests in progress of one connection; more are refused at once; 0 = no "
                    "limit"},
      gst::Property{"max-connections", &Settings::max_connections,
                    "Connections that have requests in progress; requests of more are refused at "
                    "once; 0 = no limit"},
      gst::Property{"max-connections-per-address", &Settings::max_connections_per_address,
                    "The same of one address; 0 = no limit"},
      gst::Property{"max-bytes-in-flight", &Settings::max_bytes_in_flight,
                    "Bytes of the requests in progress of one address; more wait until earlier "
                    "ones are received, or are refused; 0 = no limit"},
      gst::Property{"idle-timeout", &Settings::idle_timeout,
                    "Milliseconds after which a connection without calls is closed",
                    gst::Changeable::InReady, 1u, 2147483647u},
      gst::Property{"model-control", &Settings::model_control,
                    "Let clients unload the model and load it again; the message weir-model-loaded "
                    "on the bus reports it"},
      gst::Property{"insecure", &Settings::insecure,
                    "Let other machines connect without TLS: only on a network that you trust"},
      gst::Property{"tls-cert", &Settings::tls_cert,
                    "File with the certificate of this server (PEM); with tls-key it enables TLS"},
      gst::Property{"tls-key", &Settings::tls_key, "File with the key of tls-cert (PEM)"},
      gst::Property{"tls-ca", &Settings::tls_ca,
                    "File with the authority whose certificate each client needs (PEM)"},
      gst::Property{
          "tls-peers", &Settings::tls_peers,
          "Names of clients' certificates that are allowed, separated by commas; default: "
          "all of tls-ca"},
      gst::Property{"token-file", &Settings::token_file,
                    "File with tokens, one on each line: a client needs one; needs TLS"},
      gst::Property{"connect-type", &Settings::connect_type, "How clients find this server"},
      gst::Property{"dest-host", &Settings::dest_host, "Accepted for compatibility; has no effect"},
      gst::Property{"dest-port", &Settings::dest_port, "Accepted for compatibility; has no effect",
                    gst::Changeable::InReady, 0u, 65535u},
      gst::Property{"topic", &Settings::topic, "Accepted for compatibility; has no effect"},
      gst::Property{"timeout", &Settings::timeout, "Accepted for compatibility; has no effect",
                    gst::Changeable::InReady, 0u, 3600u},
      gst::Property{"is-live", &Settings::is_live, "Whether the source is live"},
  };

  void constructed() {
    gst_base_src_set_live(base(), TRUE);
    gst_base_src_set_format(base(), GST_FORMAT_TIME);
    gst_base_src_set_do_timestamp(base(), TRUE);
    gst_pad_add_probe(
        pad(), GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM,
        [](GstPad*, GstPadProbeInfo* info, gpointer impl) {
          const auto* source = static_cast<TensorQueryServersrc*>(impl);
          if (source->model_ && GST_EVENT_TYPE(GST_PAD_PROBE_INFO_EVENT(info)) == GST_EVENT_EOS)
            source->model_->close();
          return GST_PAD_PROBE_OK;
        },
        this, nullptr);
  }
  void property_changed(const char* name) {
    if (std::string_view(name) == "is-live") gst_base_src_set_live(base(), settings().is_live);
  }

  Status start() {
    const Settings s = settings();
    if (auto status = check_protocol(s.protocol, s.connect_type, kInfo.factory_name); !status)
      return status;
    auto server = net::ModelServer::share(s.listen_options());
    if (!server) return server.error();
    auto model = std::make_shared<net::ServedModel>(
        net::ModelRequest{s.model_name.empty() ? default_name() : s.model_name, s.model_version},
        "weir", s.queue);
    model->set_load_handler([source = Ref<GstElement>::share(element())](bool loaded) {
      gst_element_post_message(
          source.get(),
          gst_message_new_element(
              GST_OBJECT(source.get()),
              gst_structure_new("weir-model-loaded", "loaded", G_TYPE_BOOLEAN, loaded, nullptr)));
    });
    id_ = s.id;
    wanted_port_ = s.port;
    ledger_.reset();
    if (auto status = publish(*server, model); !status) {
      model->set_load_handler(nullptr);
      return status;
    }
    if (s.unix_path.empty())
      change_settings([&](Settings& shown) { shown.port = (*server)->port(); });
    {
      std::lock_guard lock(server_mutex_);
      server_ = *std::move(server);
      model_ = std::move(model);
    }
    g_object_notify(G_OBJECT(self()), "port");
    GST_CAT_INFO_OBJECT(category(), self(), "model %s version %s listens on %s",
                        model_->model().name.c_str(), model_->model().version.c_str(),
                        net::address_text(settings().listen_options()).c_str());
    if (s.insecure && s.tls_cert.empty())
      GST_CAT_WARNING_OBJECT(category(), self(),
                             "connections are not encrypted: anyone on the network can read and "
                             "change requests (insecure=true)");
    return ok();
  }

  // Downstream elements drop their frames before this element stops.
  GstStateChangeReturn change_state(GstStateChange change) {
    if (model_ && change == GST_STATE_CHANGE_PLAYING_TO_PAUSED) model_->set_running(false);
    if (model_ && change == GST_STATE_CHANGE_PAUSED_TO_PLAYING) model_->set_running(true);
    return GST_ELEMENT_CLASS(parent_class())->change_state(element(), change);
  }

  gboolean stop() {
    watch_.stop();
    watched_ = false;
    std::shared_ptr<net::ModelServer> server;
    {
      std::lock_guard lock(server_mutex_);
      server = std::move(server_);
    }
    if (!server) return TRUE;
    change_settings([&](Settings& shown) { shown.port = wanted_port_; });
    model_->set_load_handler(nullptr);
    model_->stop();
    server->remove(*model_);
    remove_pair(id_, *model_);
    const auto c = model_->counts();
    GST_CAT_INFO_OBJECT(category(), self(),
                        "requests: %" G_GUINT64_FORMAT " received = %" G_GUINT64_FORMAT
                        " answered + %" G_GUINT64_FORMAT " refused + %" G_GUINT64_FORMAT
                        " expired + %" G_GUINT64_FORMAT " aborted",
                        c.received, c.answered, c.refused, c.expired, c.aborted);
    return TRUE;
  }

  // The caps are those that the downstream element needs: the base class would negotiate only what
  // this source can name itself. False also when a downstream element reported an error: no buffer
  // would come to report it again.
  gboolean negotiate() {
    const uint64_t errors = gst::errors_posted_by_this_thread();
    const Status status = agree_on_caps();
    if (!status) gst::post_error(element(), status.error());
    return status && gst::errors_posted_by_this_thread() == errors;
  }

  // The frames have a pool of their own.
  gboolean decide_allocation(GstQuery* query) {
    while (gst_query_get_n_allocation_pools(query) > 0)
      gst_query_remove_nth_allocation_pool(query, 0);
    return TRUE;
  }

  GstFlowReturn create(GstBuffer** out) {
    if (!std::exchange(watched_, true)) watch_.start(pad());
    while (const auto request = model_->take()) {
      ledger_.received();
      auto buffer = pool_.acquire(buffer_limit_);
      if (!buffer) {
        ledger_.dropped(DropReason::Error);
        request->fail(net::CallStatus::ResourceExhausted, buffer.error().message());
        continue;
      }
      if (const Status status = fill(buffer->get(), *request); !status) {
        ledger_.dropped(DropReason::Error);
        request->fail(net::CallStatus::InvalidArgument, status.error().message());
        continue;
      }
      set_request(buffer->get(), request);
      gst::set_client(buffer->get(), client_of(*request));
      request->pushed();
      ledger_.consumed_and_pushed();
      *out = buffer->release();
      return GST_FLOW_OK;
    }
    return GST_FLOW_FLUSHING;
  }

  gboolean unlock() {
    if (model_) model_->interrupt();
    return TRUE;
  }
  gboolean unlock_stop() {
    if (model_) model_->resume();
    return TRUE;
  }

  void add_stats(GstStructure* stats) const {
    std::lock_guard lock(server_mutex_);
    const auto c = model_ ? model_->counts() : net::ServedCounts{};
    gst_structure_set(stats, "requests-received", G_TYPE_UINT64, c.received, "requests-answered",
                      G_TYPE_UINT64, c.answered, "requests-refused", G_TYPE_UINT64, c.refused,
                      "requests-expired", G_TYPE_UINT64, c.expired, "requests-aborted",
                      G_TYPE_UINT64, c.aborted, "requests-in-flight", G_TYPE_UINT64, c.in_flight,
                      "calls-refused", G_TYPE_UINT64, server_ ? server_->refused() : 0, nullptr);
  }

  Settings settings_;
  Ledger ledger_;
  BufferLimit buffer_limit_{kInfo.factory_name};

 private:
  GstBaseSrc* base() const { return GST_BASE_SRC(self()); }
  GstPad* pad() const { return GST_BASE_SRC_PAD(self()); }

  // "mobilenet" for the next filter's model=/models/mobilenet.tflite.
  std::string default_name() const {
    const std::string model = property_downstream(pad(), "model");
    const std::string file = model.substr(0, model.find(','));
    std::string stem = std::filesystem::path(file).stem();
    if (file.find("://") == std::string::npos && !stem.empty()) return stem;
    const gst::UniqueText name{gst_element_get_name(element())};
    return name.get();
  }

  Status publish(const std::shared_ptr<net::ModelServer>& server,
                 const std::shared_ptr<net::ServedModel>& model) const {
    if (auto status = add_pair(id_, model); !status) return status;
    auto status = server->add(model);
    if (!status) remove_pair(id_, *model);
    return status;
  }

  Status agree_on_caps() {
    auto caps = Ref<GstCaps>::adopt(gst_pad_peer_query_caps(pad(), nullptr));
    if (const auto own = settings().caps)
      caps = Ref<GstCaps>::adopt(
          gst_caps_intersect_full(own.get(), caps.get(), GST_CAPS_INTERSECT_FIRST));
    if (gst_caps_is_empty(caps.get())) return rejected_caps();
    if (gst_caps_is_any(caps.get())) return unknown_caps("any caps");
    caps = Ref<GstCaps>::adopt(gst_caps_fixate(caps.release()));
    if (auto status = plan(caps.get()); !status) return status;
    return gst_base_src_set_caps(base(), caps.get()) ? ok() : Status(rejected_caps());
  }
  Error rejected_caps() const {
    const auto own = settings().caps;
    const auto peer = Ref<GstCaps>::adopt(gst_pad_peer_query_caps(pad(), nullptr));
    return gst::downstream_mismatch(pad(), peer.get(), own ? text_of(own.get()) : "any tensors",
                                    "caps that the downstream element accepts");
  }
  static Error unknown_caps(std::string offered) {
    return {
        .code = Code::OPTION_VALUE,
        .what = "the tensors of the requests are not known",
        .offered = "the downstream element accepts " + std::move(offered),
        .needed = "the caps of the requests, or a downstream element that needs certain tensors",
        .fix = kSampleCaps};
  }

  Status plan(const GstCaps* caps) {
    auto spec = gst::fixed_spec_from_caps(caps);
    if (!spec || spec->format != Format::Static) return unknown_caps(text_of(caps));
    if (auto status = buffer_limit_.check(*spec); !status) return status;
    auto pool = gst::FramePool::make(spec->tensors, Format::Static);
    if (!pool) return pool.error();
    pool_ = *std::move(pool);
    model_->set_inputs(describe_tensors(spec->tensors, "input",
                                        parse_name_list(property_downstream(pad(), "inputname"))));
    return ok();
  }

  Status fill(GstBuffer* buffer, const net::ServedRequest& request) {
    gst::FramePool::Writer writer;
    if (auto status = writer.map(pool_, buffer); !status) return status;
    for (size_t i = 0; i < writer.payloads().size(); ++i)
      if (auto status = request.read_input(i, writer.payloads()[i]); !status) return status;
    return ok();
  }

  // The same for all requests of a connection; not negative.
  static gint64 client_of(const net::ServedRequest& request) {
    return static_cast<gint64>(std::hash<std::string>{}(request.peer()) >> 1);
  }

  mutable std::mutex server_mutex_;  // guards server_, and model_ while it changes
  std::shared_ptr<net::ModelServer> server_;
  // Set in start(); streaming thread only, but for interrupt().
  std::shared_ptr<net::ServedModel> model_;
  uint32_t id_ = 0, wanted_port_ = 0;
  bool watched_ = false;
  RequestWatch watch_;
  gst::FramePool pool_;
};

}  // namespace

bool register_tensor_query_serversrc(GstPlugin* plugin) {
  return TensorQueryServersrc::register_in(plugin);
}

}  // namespace weir
