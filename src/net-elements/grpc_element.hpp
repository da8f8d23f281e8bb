// GrpcElement: the connection of tensor_sink_grpc and tensor_src_grpc, and the frames it carries.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string_view>
#include <utility>

#include "gstcpp/element/base_classes.hpp"
#include "net-elements/grpc_settings.hpp"
#include "transport/host_text.hpp"

namespace weir {

// Frames: net::OutgoingFrames or net::IncomingFrames.
template <class Impl, class Base, class Frames>
class GrpcElement : public gst::Element<Impl, Base> {
 public:
  // A flush may come while the element starts.
  gboolean unlock() {
    std::lock_guard lock(frames_mutex_);
    if (frames_) frames_->interrupt();
    return TRUE;
  }
  gboolean unlock_stop() {
    std::lock_guard lock(frames_mutex_);
    if (frames_) frames_->resume();
    return TRUE;
  }

  // A text that cannot be a host is not taken, as in NNStreamer.
  void property_changed(const char* name) {
    if (std::string_view(name) != "host") return;
    std::optional<std::string> refused;
    this->change_settings([&](auto& s) {
      if (transport::may_be_host(s.host))
        s.host_taken = s.host;
      else
        refused = std::exchange(s.host, s.host_taken);
    });
    if (refused)
      gst::post_warning(this->element(), Error{.code = Code::OPTION_VALUE,
                                               .what = "host cannot be a host name or an address",
                                               .offered = "\"" + *refused + "\"",
                                               .needed = "a text without blanks",
                                               .fix = "host=localhost"});
  }

  Ledger ledger_;

 protected:
  using OpenEndpoint = Result<std::unique_ptr<net::TensorEndpoint>>(
      const net::TensorServiceOptions& options, Frames* frames);

  // `direction`: what a client does, for the log.
  Status connect(const GrpcSettings& s, std::unique_ptr<Frames> frames, OpenEndpoint* open_endpoint,
                 const char* direction) {
    auto codec = MessageCodec::make(s.idl);
    if (!codec) return codec.error();
    codec_.emplace(*std::move(codec));
    const auto options = s.options(*codec_, this->element());
    if (!options) return options.error();
    auto endpoint = open_endpoint(*options, frames.get());
    if (!endpoint) return endpoint.error();
    {
      std::lock_guard lock(frames_mutex_);
      frames_ = std::move(frames);
      endpoint_ = *std::move(endpoint);
    }
    ledger_.reset();
    wanted_port_ = s.port;
    show_port(static_cast<int>(endpoint_->port()));
    GST_CAT_INFO_OBJECT(this->category(), this->self(), "%s %s, idl=%s",
                        s.server ? "listens on" : direction, net::address_text(*options).c_str(),
                        s.idl.c_str());
    return ok();
  }
  // Frames and their counts stay until connect().
  void disconnect() {
    endpoint_.reset();
    if (frames_) show_port(wanted_port_);
  }
  auto counts() const {
    std::lock_guard lock(frames_mutex_);
    return frames_ ? frames_->counts() : decltype(frames_->counts()){};
  }

  std::unique_ptr<Frames> frames_;
  std::optional<MessageCodec> codec_;  // streaming thread

 private:
  void show_port(int port) {
    this->change_settings([&](auto& shown) { shown.port = port; });
    g_object_notify(G_OBJECT(this->self()), "port");
  }

  mutable std::mutex frames_mutex_;                // guards the two pointers while they change
  std::unique_ptr<net::TensorEndpoint> endpoint_;  // uses frames_
  int wanted_port_ = 0;
};

}  // namespace weir
