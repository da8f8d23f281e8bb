// MqttElement: the client of the broker and the times of the stream, for mqttsink and mqttsrc.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "edge/broker_settings.hpp"
#include "gstcpp/element/base_classes.hpp"
#include "transport/mqtt/broker_client.hpp"

namespace weir {

// Impl's start() ends with set_client().
template <class Impl, class Base>
class MqttElement : public gst::Element<Impl, Base> {
 public:
  gboolean stop() {
    std::unique_ptr<transport::BrokerClient> client;  // its end takes time, so not under the lock
    std::lock_guard lock(client_mutex_);
    client = std::move(client_);
    return TRUE;
  }
  GstStateChangeReturn change_state(GstStateChange change) {
    if (change == GST_STATE_CHANGE_PAUSED_TO_PLAYING) base_epoch_valid_ = false;
    return GST_ELEMENT_CLASS(this->parent_class())->change_state(this->element(), change);
  }
  gboolean unlock() {
    interrupted_ = true;  // first: the streaming thread reads it when interrupt() wakes it
    interrupt(true);
    return TRUE;
  }
  gboolean unlock_stop() {
    interrupt(false);
    interrupted_ = false;
    return TRUE;
  }

 protected:
  void set_client(std::unique_ptr<transport::BrokerClient> client) {
    base_epoch_valid_ = false;
    std::lock_guard lock(client_mutex_);
    client_ = std::move(client);
  }
  transport::BrokerCounts counts() const {
    std::lock_guard lock(client_mutex_);
    return client_ ? client_->counts() : transport::BrokerCounts{};
  }
  // Call it before base_epoch_ is used. `now`: Unix time in ns.
  void update_base_epoch(int64_t now) {
    if (base_epoch_valid_.exchange(true)) return;
    base_epoch_ = now;
    const auto clock = gst::Ref<GstClock>::adopt(gst_element_get_clock(this->element()));
    if (!clock) return;
    const GstClockTime time = gst_clock_get_time(clock.get());
    const GstClockTime base = gst_element_get_base_time(this->element());
    if (time > base) base_epoch_ -= static_cast<int64_t>(time - base);
  }

  std::unique_ptr<transport::BrokerClient> client_;
  int64_t base_epoch_ = 0;  // Unix time in ns when the running time was 0; streaming thread
  std::atomic<bool> interrupted_{false};  // from unlock() to unlock_stop()

 private:
  // A flush may come while the element starts or stops.
  void interrupt(bool interrupted) const {
    std::lock_guard lock(client_mutex_);
    if (client_) client_->interrupt(interrupted);
  }

  mutable std::mutex client_mutex_;  // guards client_ while it changes
  std::atomic<bool> base_epoch_valid_{false};
};

}  // namespace weir
