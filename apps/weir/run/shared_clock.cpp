// Opens network clocks of GStreamer's network library, and serves one.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/shared_clock.hpp"

#include <gst/net/net.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>

namespace weir::app {
namespace {

constexpr GstClockTime kClockWait = 10 * GST_SECOND;  // until the clock is synchronised
constexpr int kNtpPort = 123, kMaxPort = 65535, kMaxDomain = 255;

Error unreadable_clock(const std::string& address, std::string difference) {
  return {.code = Code::OPTION_VALUE,
          .what = "the address of a clock cannot be read",
          .offered = "--clock " + address,
          .needed = "net://HOST:PORT, ntp://HOST, ntp://HOST:PORT or ptp://DOMAIN",
          .difference = std::move(difference),
          .fix = "--clock net://192.168.1.2:5637"};
}

std::optional<int> number(std::string_view text, int min, int max) {
  int out = 0;
  const auto [end, bad] = std::from_chars(text.data(), text.data() + text.size(), out);
  if (bad != std::errc{} || end != text.data() + text.size() || out < min || out > max)
    return std::nullopt;
  return out;
}

struct HostPort {
  std::string host;
  int port = 0;
};

// "host:port", "[::1]:port"; `port` is the default, 0 = there is none.
std::optional<HostPort> host_and_port(std::string_view text, int port) {
  const size_t bracket = text.rfind(']');
  const size_t colon = text.find(':', bracket == std::string_view::npos ? 0 : bracket);
  std::string_view host = text.substr(0, colon);
  if (colon != std::string_view::npos) {
    const auto read = number(text.substr(colon + 1), 1, kMaxPort);
    if (!read) return std::nullopt;
    port = *read;
  }
  if (host.size() > 2 && host.front() == '[' && host.back() == ']')
    host = host.substr(1, host.size() - 2);
  if (host.empty() || port == 0) return std::nullopt;
  return HostPort{std::string(host), port};
}

Result<gst::Ref<GstClock>> open_ptp(const std::string& address, std::string_view rest) {
  const auto domain = number(rest, 0, kMaxDomain);
  if (!domain) return unreadable_clock(address, "a PTP domain is a number from 0 to 255");
  if (!gst_ptp_is_initialized() && !gst_ptp_init(GST_PTP_CLOCK_ID_NONE, nullptr))
    return Error{
        .code = Code::OPTION_VALUE,
        .what = "PTP cannot be used on this machine",
        .offered = "--clock " + address,
        .needed =
            "GStreamer's program gst-ptp-helper with the right to use the ports 319 "
            "and 320, and a network interface",
        .fix = "setcap cap_net_bind_service,cap_net_admin+ep gst-ptp-helper, or ntp://HOST"};
  return gst::Ref<GstClock>::adopt(gst_ptp_clock_new("shared", static_cast<guint>(*domain)));
}

Result<gst::Ref<GstClock>> open_clock(const std::string& address) {
  const std::string_view all = address, scheme = all.substr(0, std::min<size_t>(6, all.size()));
  const std::string_view rest = all.substr(scheme.size());
  if (scheme == "ptp://") return open_ptp(address, rest);
  if (scheme != "net://" && scheme != "ntp://")
    return unreadable_clock(address, "the scheme is unknown");
  const bool is_ntp = scheme == "ntp://";
  const auto server = host_and_port(rest, is_ntp ? kNtpPort : 0);
  if (!server) return unreadable_clock(address, "no host and port");
  const auto open = is_ntp ? gst_ntp_clock_new : gst_net_client_clock_new;
  return gst::Ref<GstClock>::adopt(open("shared", server->host.c_str(), server->port, 0));
}

Error not_synchronised(const std::string& address) {
  const bool is_net = address.rfind("net:", 0) == 0;
  return {.code = Code::SERVER_UNREACHABLE,
          .what = "the clock did not synchronise within 10 seconds",
          .offered = "--clock " + address,
          .needed = is_net ? "a pipeline on that machine that serves its clock"
                           : "an NTP server at this address",
          .fix = is_net ? "weir run --serve-clock 5637 PIPELINE, on that machine"
                        : "--clock net://HOST:PORT of a machine with weir run --serve-clock PORT"};
}

std::string seconds_text(double nanoseconds) {
  const gst::UniqueText text(g_strdup_printf("%.6f s", nanoseconds / GST_SECOND));
  return text.get();
}

std::string microseconds_text(double nanoseconds) {
  const gst::UniqueText text(g_strdup_printf("%.1f us", nanoseconds / GST_USECOND));
  return text.get();
}

}  // namespace

Result<std::unique_ptr<SharedClock>> SharedClock::open(const ClockOptions& options) {
  std::unique_ptr<SharedClock> out(new SharedClock);
  if (options.address.empty())
    out->clock_ = gst::Ref<GstClock>::adopt(gst_system_clock_obtain());
  else if (auto status = out->connect(options.address); !status)
    return status.error();
  if (!options.serving_port) return out;
  if (auto status = out->serve(*options.serving_port); !status) return status.error();
  return out;
}

Status SharedClock::connect(const std::string& address) {
  auto clock = open_clock(address);
  if (!clock) return clock.error();
  address_ = address;
  clock_ = *std::move(clock);
  if (!clock_) return unreadable_clock(address, "GStreamer does not accept it");
  watch_responses();
  return gst_clock_wait_for_sync(clock_.get(), kClockWait) ? ok()
                                                           : Status(not_synchronised(address));
}

// The clock posts a message for each response of its server.
void SharedClock::watch_responses() {
  if (!g_object_class_find_property(G_OBJECT_GET_CLASS(clock_.get()), "bus")) return;
  bus_ = gst::Ref<GstBus>::adopt(gst_bus_new());
  gst_bus_set_sync_handler(
      bus_.get(),
      [](GstBus*, GstMessage* message, gpointer self) {
        guint64 local = 0, remote = 0, round_trip = 0;
        const GstStructure* response = gst_message_get_structure(message);
        if (response &&
            gst_structure_get(response, "local", G_TYPE_UINT64, &local, "remote", G_TYPE_UINT64,
                              &remote, "rtt", G_TYPE_UINT64, &round_trip, nullptr)) {
          auto* clock = static_cast<SharedClock*>(self);
          std::lock_guard lock(clock->mutex_);
          clock->response_ = {GST_CLOCK_DIFF(local, remote), static_cast<int64_t>(round_trip)};
        }
        gst_message_unref(message);
        return GST_BUS_DROP;
      },
      this, nullptr);
  g_object_set(clock_.get(), "bus", bus_.get(), nullptr);
}

Status SharedClock::serve(int port) {
  provider_ = gst::Ref<GstObject>::adopt(
      GST_OBJECT_CAST(gst_net_time_provider_new(clock_.get(), nullptr, port)));
  if (provider_) return ok();
  return Error{.code = Code::OPTION_VALUE,
               .what = "the clock cannot be served",
               .offered = "--serve-clock " + std::to_string(port),
               .needed = "a UDP port that no other program uses",
               .fix = "--serve-clock 0, which uses a free port"};
}

void SharedClock::apply_to(GstElement* pipeline) const {
  gst_pipeline_use_clock(GST_PIPELINE(pipeline), clock_.get());
  gst_element_set_start_time(pipeline, GST_CLOCK_TIME_NONE);
  gst_element_set_base_time(pipeline, 0);
}

int SharedClock::serving_port() const {
  gint port = 0;
  if (provider_) g_object_get(provider_.get(), "port", &port, nullptr);
  return port;
}

int64_t SharedClock::offset() const {
  const auto own = gst::Ref<GstClock>::adopt(gst_system_clock_obtain());
  const GstClockTime before = gst_clock_get_time(own.get());
  const GstClockTime shared = gst_clock_get_time(clock_.get());
  const GstClockTime after = gst_clock_get_time(own.get());
  return GST_CLOCK_DIFF(before + (after - before) / 2, shared);
}

SharedClock::Exactness SharedClock::exactness() const {
  std::optional<Response> response;
  {
    std::lock_guard lock(mutex_);  // not while the clock is read: it may post with a lock held
    response = response_;
  }
  Exactness out{.offset = offset(), .round_trip = {}, .error = {}};
  if (!response) return out;
  out.round_trip = response->round_trip;
  out.error = response->round_trip / 2 + std::abs(out.offset - response->offset);
  return out;
}

Json SharedClock::state() const {
  const Exactness now = exactness();
  Json out{{"address", address_},
           {"offset_ns", now.offset},
           {"round_trip_ns", nullptr},
           {"error_ns", nullptr}};
  if (now.round_trip) out["round_trip_ns"] = *now.round_trip;
  if (now.error) out["error_ns"] = *now.error;
  if (provider_) out["port"] = serving_port();
  return out;
}

std::string SharedClock::state_text() const {
  if (address_.empty()) return "Clock served on port " + std::to_string(serving_port());
  const Exactness now = exactness();
  std::string out = "Clock " + address_ + ": " + seconds_text(static_cast<double>(now.offset)) +
                    " ahead of this machine's";
  if (now.round_trip)
    out += ", round trip " + microseconds_text(static_cast<double>(*now.round_trip)) +
           ", error at most " + microseconds_text(static_cast<double>(*now.error));
  return out;
}

}  // namespace weir::app
