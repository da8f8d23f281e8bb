// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net-elements/oip_query_server.hpp"

#include <algorithm>
#include <functional>
#include <mutex>
#include <utility>

#include "core/filter/described_model.hpp"
#include "core/process/listener_lease.hpp"
#include "core/tensor/frame_spec.hpp"
#include "core/tensor/model_tensor.hpp"
#include "core/tensor/tensor_header.hpp"
#include "edge/query_server.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/buffer/frame_pool.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "net/protocol/oip_messages.hpp"
#include "net/protocol/oip_types.hpp"
#include "net/server/model_server.hpp"
#include "net/server/server_security.hpp"
#include "weir/results.h"

namespace weir {
namespace {

using gst::Ref;

constexpr char kSampleCaps[] =
    "caps=\"other/tensors,format=static,num_tensors=1,dimensions=(string)3:224:224:1,"
    "types=(string)uint8,framerate=0/1\"";

net::ListenOptions listen_options(const ServersrcSettings& s) {
  net::ListenOptions out{.host = s.host,
                         .port = s.port,
                         .unix_path = s.unix_path,
                         .max_bytes = s.max_message,
                         .max_requests = s.max_requests,
                         .max_connections = s.max_connections,
                         .max_address_connections = s.max_connections_per_address,
                         .max_address_bytes = s.max_bytes_in_flight,
                         .idle_ms = s.idle_timeout,
                         .security = {.cert = s.tls_cert,
                                      .key = s.tls_key,
                                      .ca = s.tls_ca,
                                      .token_file = s.token_file,
                                      .peers = {},
                                      .insecure = s.insecure},
                         .model_control = s.model_control};
  if (!s.tls_peers.empty()) out.security.peers = parse_name_list(s.tls_peers);
  return out;
}

// The outputs of one response: mapped until gRPC has sent them.
struct MappedResponse {
  explicit MappedResponse(GstBuffer* response) : buffer(Ref<GstBuffer>::share(response)) {}

  Ref<GstBuffer> buffer;
  gst::FrameLayout reader;           // of tensors
  std::optional<gst::Mapped> whole;  // of other streams
};

// `name` for one tensor, "name_0", "name_1" for several; `names` go before those if there is one
// for each tensor.
// Dimensions that are not known are -1.
std::vector<net::TensorText> describe_tensors(const std::vector<ModelTensor>& tensors,
                                              const std::string& name,
                                              const std::vector<std::string>& names) {
  std::vector<net::TensorText> out;
  for (const auto& tensor : tensors) {
    net::TensorText text;
    text.name = tensors.size() == 1 ? name : name + "_" + std::to_string(out.size());
    if (names.size() == tensors.size() && !names[out.size()].empty()) text.name = names[out.size()];
    if (const auto* type = net::find_oip_type(static_cast<uint32_t>(tensor.type)))
      text.datatype = type->name;
    text.shape = tensor.rank_known ? tensor.shape : std::vector<int64_t>{-1};
    out.push_back(std::move(text));
  }
  return out;
}

std::vector<net::TensorText> describe_tensors(const std::vector<TensorSpec>& tensors,
                                              const std::string& name,
                                              const std::vector<std::string>& names) {
  std::vector<ModelTensor> out;
  out.reserve(tensors.size());
  for (const auto& tensor : tensors) out.push_back(model_tensor(tensor));
  return describe_tensors(out, name, names);
}

// A table of results; its number of rows differs from frame to frame.
ModelTensor describe_results(const ResultRole& role) {
  weir_result_columns columns;
  if (!weir_results_parse(role.columns.c_str(), 0, &columns)) return {};
  switch (columns.kind) {
    case WEIR_RESULT_ROWS:
      return {.type = ElementType::Float32, .rank_known = true, .shape = {-1, columns.length}};
    case WEIR_RESULT_MASKS:
      return {.type = ElementType::UInt8, .rank_known = true, .shape = {-1, -1, -1}};
    case WEIR_RESULT_SCORES:
    case WEIR_RESULT_DEPTH:
      return {.type = ElementType::Float32, .rank_known = true, .shape = {-1, -1}};
    case WEIR_RESULT_TEXT:
      return {.type = ElementType::UInt8, .rank_known = true, .shape = {-1, -1}};
    default:  // a class map may have numbers of either width
      return {};
  }
}

// The tensors of caps; none for flexible ones that each frame describes: those that are no results,
// and results of a type that the caps leave open.
std::vector<net::TensorText> describe_outputs(const GstCaps* caps, const FrameSpec& spec,
                                              const std::vector<std::string>& names) {
  std::vector<ModelTensor> results;
  if (spec.format != Format::Static)
    for (const auto& role : gst::roles_from_caps(caps)) results.push_back(describe_results(role));
  const auto is_open = [](const ModelTensor& each) { return each.type == ElementType::End; };
  if (std::any_of(results.begin(), results.end(), is_open)) results.clear();
  return results.empty() ? describe_tensors(spec.tensors, "output", names)
                         : describe_tensors(results, "output", names);
}

// A stream that has no tensors, such as image/jpeg or text: one element of bytes.
std::vector<net::TensorText> describe_bytes(const std::string& name) {
  return {{name, "BYTES", {1}}};
}

bool has_tensors(const GstCaps* caps) {
  const GstStructure* first = gst_caps_get_structure(caps, 0);
  return gst_structure_has_name(first, "other/tensor") ||
         gst_structure_has_name(first, "other/tensors");
}

class OipRequest : public QueryRequest {
 public:
  explicit OipRequest(std::shared_ptr<net::ServedRequest> request) : request_(std::move(request)) {}

  gint64 client() const override {
    return static_cast<gint64>(std::hash<std::string>{}(request_->peer()) >> 1);
  }
  bool end_if_expired() override { return request_->end_if_expired(); }
  void entered(const char* element) noexcept override { request_->entered(element); }
  void pushed() noexcept override { request_->pushed(); }
  net::ServedRequest& served() const noexcept { return *request_; }

 private:
  const std::shared_ptr<net::ServedRequest> request_;
};

class OipQueryServer : public QueryServer {
 public:
  OipQueryServer(std::shared_ptr<net::ModelServer> server, std::shared_ptr<net::ServedModel> model,
                 const net::ListenOptions& options)
      : server_(std::move(server)),
        model_(std::move(model)),
        port_(options.unix_path.empty() ? options.port : 0),
        address_(net::address_text(options)) {}

  Status publish() override { return server_->add(model_); }
  uint32_t port() const override { return port_; }
  std::string description() const override {
    return "model " + model_->model().name + " version " + model_->model().version +
           " listens on " + address_;
  }
  Status set_input(GstCaps* caps, const std::vector<std::string>& names,
                   const BufferLimit& limit) override {
    input_ = find_kind(caps);
    if (input_ != Input::Tensors) {
      model_->set_inputs(describe_bytes(names.size() == 1 ? names[0] : "input"));
      return ok();
    }
    auto spec = gst::fixed_spec_from_caps(caps);
    if (!spec || spec->format != Format::Static) return unknown_tensors(caps);
    if (auto status = limit.check(*spec); !status) return status;
    auto pool = gst::FramePool::make(spec->tensors, Format::Static);
    if (!pool) return pool.error();
    pool_ = *std::move(pool);
    limit_ = &limit;
    model_->set_inputs(describe_tensors(spec->tensors, "input", names));
    return ok();
  }
  Status set_output(GstCaps* caps, const std::vector<std::string>& names,
                    const DescribedModel* model) override {
    has_tensors_ = has_tensors(caps);
    if (!has_tensors_) {
      outputs_ = describe_bytes("output");
    } else {
      auto spec = gst::spec_from_caps(caps);
      if (!spec) return spec.error();
      spec_ = *std::move(spec);
      outputs_ = model && spec_.format != Format::Static
                     ? describe_tensors(model->outputs, "output", names)
                     : describe_outputs(caps, spec_, names);
    }
    names_ = names;
    model_->set_outputs(outputs_);
    return ok();
  }
  Status expect_output(GstCaps* caps, const std::vector<std::string>& names) override {
    std::vector<net::TensorText> outputs;
    if (caps && has_tensors(caps)) {
      const auto spec = gst::spec_from_caps(caps);
      if (!spec) return spec.error();
      outputs = describe_outputs(caps, *spec, names);
    } else if (caps) {
      outputs = describe_bytes("output");
    }
    model_->expect_outputs(std::move(outputs));
    return ok();
  }
  std::shared_ptr<QueryRequest> take() override {
    auto request = model_->take();
    return request ? std::make_shared<OipRequest>(std::move(request)) : nullptr;
  }
  void interrupt() override { model_->interrupt(); }
  void resume() override { model_->resume(); }

  Result<Ref<GstBuffer>> make_frame(QueryRequest& request) override {
    net::ServedRequest& served = static_cast<OipRequest&>(request).served();  // of take()
    if (input_ != Input::Tensors) return make_frame_of_bytes(served);
    auto buffer = pool_.acquire(*limit_);
    if (!buffer) {
      served.fail(net::CallStatus::ResourceExhausted, buffer.error().message());
      return buffer;
    }
    if (const Status status = fill(buffer->get(), served); !status) {
      served.fail(net::CallStatus::InvalidArgument, status.error().message());
      return status.error();
    }
    return buffer;
  }
  Result<Delivery> respond(QueryRequest* request, GstBuffer* buffer,
                           uint64_t* bytes_copied) override {
    if (!request) return Delivery::NoRequest;
    const auto* own = dynamic_cast<OipRequest*>(request);
    if (!own) return Delivery::OtherServer;
    const auto response = std::make_shared<MappedResponse>(buffer);
    auto tensors = read(response.get());
    if (!tensors) {
      own->served().fail(net::CallStatus::Internal, tensors.error().message());
      return tensors.error();
    }
    *bytes_copied += response->reader.bytes_copied();
    own->served().respond(*tensors, response);
    return Delivery::Sent;
  }
  Status set_running(bool running) override {
    model_->set_running(running);
    return ok();
  }
  void close() override { model_->close(); }
  void stop() override {
    model_->stop();
    server_->remove(*model_);
    // Waits for the last calls of the address.
    const auto released = release();
  }
  std::string summary() const override {
    const auto c = model_->counts();
    return "requests: " + std::to_string(c.received) + " received = " + std::to_string(c.answered) +
           " answered + " + std::to_string(c.refused) + " refused + " + std::to_string(c.expired) +
           " expired + " + std::to_string(c.aborted) + " aborted";
  }
  void add_stats(GstStructure* stats) const override {
    const auto c = model_->counts();
    gst_structure_set(stats, "requests-received", G_TYPE_UINT64, c.received, "requests-answered",
                      G_TYPE_UINT64, c.answered, "requests-refused", G_TYPE_UINT64, c.refused,
                      "requests-expired", G_TYPE_UINT64, c.expired, "requests-aborted",
                      G_TYPE_UINT64, c.aborted, "requests-in-flight", G_TYPE_UINT64, c.in_flight,
                      "calls-refused", G_TYPE_UINT64, calls_refused(), nullptr);
  }

 private:
  std::shared_ptr<net::ModelServer> release() {
    std::lock_guard lock(server_mutex_);
    calls_refused_ = server_->refused();
    return std::exchange(server_, nullptr);
  }
  uint64_t calls_refused() const {
    std::lock_guard lock(server_mutex_);
    return server_ ? server_->refused() : calls_refused_;
  }
  static Error unknown_tensors(const GstCaps* caps) {
    const gst::UniqueText text{gst_caps_to_string(caps)};
    return {
        .code = Code::OPTION_VALUE,
        .what = "the tensors of the requests are not known",
        .offered = "the downstream element accepts " + std::string(text.get()),
        .needed = "the caps of the requests, or a downstream element that needs certain tensors",
        .fix = kSampleCaps};
  }
  // Static tensors; one flexible tensor of bytes; or a stream without tensors, such as image/jpeg.
  // The last two are one element of type BYTES.
  enum class Input { Tensors, Flexible, Medium };
  static Input find_kind(const GstCaps* caps) {
    if (!has_tensors(caps)) return Input::Medium;
    const auto spec = gst::spec_from_caps(caps);
    return spec && spec->format == Format::Flexible ? Input::Flexible : Input::Tensors;
  }
  Result<Ref<GstBuffer>> make_frame_of_bytes(net::ServedRequest& served) const {
    const size_t header = input_ == Input::Flexible ? kTensorHeaderBytes : 0;
    const size_t size = served.size_of_bytes(0);
    if (size == 0)
      return refuse(served, net::CallStatus::InvalidArgument,
                    {.code = Code::FRAME_SIZE,
                     .what = "the element of bytes is empty",
                     .needed = "one byte or more"});
    auto buffer = Ref<GstBuffer>::adopt(gst_buffer_new_allocate(nullptr, header + size, nullptr));
    if (!buffer) return refuse(served, net::CallStatus::ResourceExhausted, no_memory());
    const gst::Mapped mapped(buffer.get(), GST_MAP_WRITE);
    if (!mapped) return refuse(served, net::CallStatus::ResourceExhausted, no_memory());
    const std::span<std::byte> bytes = mapped.bytes();
    if (header > 0) {
      const TensorSpec spec{ElementType::UInt8, Shape{static_cast<uint32_t>(size)}, ""};
      write_tensor_header({.spec = spec, .format = Format::Flexible},
                          bytes.first<kTensorHeaderBytes>());
    }
    served.copy_bytes(0, bytes.subspan(header));
    return buffer;
  }
  static Error refuse(net::ServedRequest& served, net::CallStatus status, Error error) {
    served.fail(status, error.message());
    return error;
  }
  static Error no_memory() {
    return {.code = Code::OUT_OF_MEMORY, .what = "no memory for the frame of a request"};
  }
  Status fill(GstBuffer* buffer, const net::ServedRequest& request) {
    gst::FramePool::Writer writer;
    if (auto status = writer.map(pool_, buffer); !status) return status;
    for (size_t i = 0; i < writer.payloads().size(); ++i)
      if (auto status = request.read_input(i, writer.payloads()[i]); !status) return status;
    return ok();
  }

  // The tensors of the response. They refer to outputs_ or frame_outputs_, and to `response`.
  Result<std::vector<net::RequestTensor>> read(MappedResponse* response) {
    std::vector<net::RequestTensor> out;
    if (!has_tensors_) {
      response->whole.emplace(response->buffer.get(), GST_MAP_READ);
      if (!*response->whole)
        return Error{.code = Code::MAPPING_FAILED, .what = "the frame cannot be mapped"};
      out.push_back(
          {outputs_[0].name, outputs_[0].datatype, outputs_[0].shape, response->whole->bytes()});
      return out;
    }
    if (auto status = response->reader.read(response->buffer.get(), spec_); !status)
      return status.error();
    const auto& views = response->reader.tensors();
    if (spec_.format != Format::Static) describe_frame(views);
    const auto& described = spec_.format == Format::Static ? outputs_ : frame_outputs_;
    for (size_t i = 0; i < views.size(); ++i)
      out.push_back(
          {described[i].name, described[i].datatype, described[i].shape, views[i].payload});
    return out;
  }
  void describe_frame(const std::vector<gst::TensorPlace>& views) {
    std::vector<TensorSpec> specs;
    specs.reserve(views.size());
    for (const auto& view : views) specs.push_back(view.spec);
    frame_outputs_ = describe_tensors(specs, "output", names_);
  }

  mutable std::mutex server_mutex_;           // guards server_ while it changes
  std::shared_ptr<net::ModelServer> server_;  // null after stop()
  uint64_t calls_refused_ = 0;                // by stop()
  const std::shared_ptr<net::ServedModel> model_;
  const uint32_t port_;
  const std::string address_;
  // The source's streaming thread.
  Input input_ = Input::Tensors;
  gst::FramePool pool_;
  const BufferLimit* limit_ = nullptr;  // the source's
  // The sink's streaming thread.
  bool has_tensors_ = false;
  FrameSpec spec_;
  std::vector<net::TensorText> outputs_, frame_outputs_;
  std::vector<std::string> names_;  // of the outputs
};

Result<std::shared_ptr<QueryServer>> open(const ServersrcSettings& s,
                                          const std::string& default_name) {
  const auto options = listen_options(s);
  auto server = net::ModelServer::share(options);
  if (!server) return server.error();
  auto model = std::make_shared<net::ServedModel>(
      net::ModelRequest{s.model_name.empty() ? default_name : s.model_name, s.model_version},
      "weir", s.queue);
  // With the port that it got.
  auto shown = options;
  if (s.unix_path.empty()) shown.port = (*server)->port();
  return std::shared_ptr<QueryServer>(
      std::make_shared<OipQueryServer>(*std::move(server), std::move(model), shown));
}

std::shared_ptr<const void> keep(const std::string& address) {
  return net::ModelServer::listening_on(address);
}

}  // namespace

void register_oip_query_server() {
  process::lease_listener() = keep;
  query_protocols().oip = open;
}

}  // namespace weir
