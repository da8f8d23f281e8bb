// SPDX-License-Identifier: LGPL-2.1-or-later
#include "honest_peers.hpp"

#include <gio/gio.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <thread>

#include "gstcpp/element/ref.hpp"
#include "hostile_messages.hpp"
#include "net/client/link.hpp"
#include "net/protocol/oip_contents.hpp"
#include "net/tensor_service/tensor_service.hpp"
#include "transport/edge/query_link.hpp"
#include "transport/edge/stream_subscriber.hpp"
#include "transport/local/subscriber.hpp"

namespace weir::fuzz {
namespace {

using std::chrono::milliseconds;
constexpr char kHere[] = "127.0.0.1";
constexpr milliseconds kMaxWait{5000};

std::span<const std::byte> frame() {
  return std::as_bytes(std::span(kHonestFrame));
}
bool is_frame(std::span<const std::byte> bytes) {
  return std::ranges::equal(bytes, frame());
}

net::TensorServiceOptions tensor_client(const Place& place) {
  net::TensorServiceOptions out;
  out.host = kHere;
  out.port = place.port;
  return out;
}

}  // namespace

bool receives_stream(const Place& place) {
  auto subscriber = edge::StreamSubscriber::connect(kHere, place.port, {});
  if (!subscriber) return false;
  const auto received = subscriber->receive();
  return received && received->memories.size() == 1 && is_frame(received->memories[0].bytes());
}

bool receives_local_stream(const Place& place) {
  auto subscriber = local::Subscriber::connect(place.path);
  while (subscriber) {
    const auto event = subscriber->receive();
    if (!event || event->kind == local::StreamEvent::Kind::Lost) return false;
    if (event->frame) return is_frame(event->frame->memories.at(0));
  }
  return false;
}

bool queries(const Place& place) {
  auto link = edge::QueryLink::connect(
      {.host = kHere, .server_host = kHere, .server_port = place.port, .handshake_time = kMaxWait});
  if (!link || !(*link)->confirm(io::deadline_in(kMaxWait))) return false;
  const auto request = (*link)->make_request({frame()}, 1);
  if (!request) return false;
  if (const auto sent = (*link)->send(*request); !sent || *sent) return false;
  const auto received = (*link)->receive(io::deadline_in(kMaxWait));
  return received && received->response && received->response->memories.size() == 1 &&
         is_frame(received->response->memories[0].bytes());
}

bool infers(const Place& place) {
  const auto address =
      net::ServerAddress::parse("grpc://127.0.0.1:" + std::to_string(place.port) + "/m");
  auto link = net::Link::open(*address, {}, size_t{1} << 20);
  if (!link) return false;
  const auto deadline = net::Link::Clock::now() + kMaxWait;
  const auto described =
      (*link)->call("ModelMetadata", net::encode_model_request("m", ""), nullptr, deadline);
  const auto model = net::parse_model_metadata(described.chunks);
  if (described.status != 0 || !model || model->inputs.size() != 1) return false;
  const int64_t shape[] = {4};
  const net::RequestTensor input{model->inputs[0].name, "UINT8", shape, frame()};
  uint64_t copied = 0;
  const auto request =
      net::encode_infer_request("m", "", {&input, 1}, net::Contents::Raw, false, &copied);
  const auto reply = (*link)->call("ModelInfer", *request, nullptr, deadline);
  const auto response = net::parse_infer_response(reply.chunks);
  Bytes output(kHonestFrame.size());
  return reply.status == 0 && response && response->outputs.size() == 1 &&
         net::read_elements(reply.chunks, response->outputs[0], output, net::Sender::Server) &&
         is_frame(output);
}

bool sends_tensors(const Place& place) {
  std::atomic<bool> has_come{false};
  GstElement* end = gst_bin_get_by_name(GST_BIN(place.pipeline), "end");
  const auto handler = g_signal_connect(
      end, "handoff", G_CALLBACK(+[](GstElement*, GstBuffer* buffer, GstPad*, gpointer user) {
        if (gst_buffer_get_size(buffer) == kHonestFrame.size() &&
            gst_buffer_memcmp(buffer, 0, kHonestFrame.data(), kHonestFrame.size()) == 0)
          *static_cast<std::atomic<bool>*>(user) = true;
      }),
      &has_come);
  const auto message = std::make_shared<const std::string>(tensor_message(kHonestFrame));
  net::OutgoingFrames frames({.queue = 1, .waits = true, .keeps = true});
  if (auto sender = net::open_sender(tensor_client(place), &frames)) {
    frames.send({std::as_bytes(std::span(*message)), message});
    const auto until = std::chrono::steady_clock::now() + kMaxWait;
    while (!has_come && std::chrono::steady_clock::now() < until)
      std::this_thread::sleep_for(milliseconds(1));
  }
  g_signal_handler_disconnect(end, handler);
  gst_object_unref(end);
  return has_come;
}

bool receives_tensors(const Place& place) {
  net::IncomingFrames frames({});
  const auto receiver = net::open_receiver(tensor_client(place), &frames);
  if (!receiver) return false;
  const auto taken = frames.take();
  if (taken.outcome != net::IncomingFrames::Outcome::Message) return false;
  std::string bytes(taken.message.chunks.size(), '\0');
  taken.message.chunks.copy({0, bytes.size()}, bytes.data());
  return bytes.find(kHonestFrame) != std::string::npos;
}

bool reads_metrics(const Place& place) {
  const gst::Unique<GSocketClient, g_object_unref> client(g_socket_client_new());
  g_socket_client_set_timeout(client.get(), 1);
  const gst::Unique<GSocketConnection, g_object_unref> connection(
      g_socket_client_connect_to_host(client.get(), kHere, place.port, nullptr, nullptr));
  if (!connection) return false;
  constexpr std::string_view kRequest = "GET /metrics HTTP/1.1\r\n\r\n";
  GIOStream* const stream = G_IO_STREAM(connection.get());
  if (!g_output_stream_write_all(g_io_stream_get_output_stream(stream), kRequest.data(),
                                 kRequest.size(), nullptr, nullptr, nullptr))
    return false;
  std::array<char, 1024> response{};
  gsize size = 0;
  return g_input_stream_read_all(g_io_stream_get_input_stream(stream), response.data(),
                                 response.size(), &size, nullptr, nullptr) &&
         std::string_view(response.data(), size).ends_with(kHonestFrame);
}

}  // namespace weir::fuzz
