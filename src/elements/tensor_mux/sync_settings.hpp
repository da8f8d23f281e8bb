// SyncSettings: the properties of elements that synchronise several streams.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <tuple>

#include "core/sync/input_queues.hpp"
#include "gstcpp/element/backwards_time.hpp"
#include "gstcpp/element/property.hpp"

namespace weir {

struct SyncSettings {
  std::string sync_mode, sync_option;
  uint64_t max_wait = 0;
  uint64_t max_bytes = 0;
  OnBackwardsTime on_backwards_time = OnBackwardsTime::Pass;
  bool silent = true;
};

template <class Settings>
inline constexpr std::tuple kSyncProperties{
    gst::Property<Settings, std::string>{"sync-mode", &Settings::sync_mode,
                                         "Which frames are combined: nosync, slowest, basepad, "
                                         "refresh; also base (= basepad) and fastest (= refresh)",
                                         gst::Changeable::WhilePlaying},
    gst::Property<Settings, std::string>{
        "sync-option", &Settings::sync_option,
        "With basepad: PAD[:DURATION], the index of the base pad in request order, and the maximum "
        "time difference of other frames in nanoseconds; empty = 0:2147483647",
        gst::Changeable::WhilePlaying},
    gst::Property<Settings, uint64_t>{
        "max-wait", &Settings::max_wait,
        "Maximum time in nanoseconds to wait for a pad without frames; 0 = no limit",
        gst::Changeable::WhilePlaying},
    gst::Property<Settings, uint64_t>{
        "max-bytes", &Settings::max_bytes,
        "Maximum bytes of all held frames, including those that are used again; at the limit a "
        "frame waits for the current output, and it is an error if that frees too little; 0 = no "
        "limit",
        gst::Changeable::WhilePlaying},
    gst::Property<Settings, OnBackwardsTime>{
        "on-backwards-time", &Settings::on_backwards_time,
        "What to do with a frame whose time is before that of the previous frame on its pad; when "
        "all pads restart, so does the output",
        gst::Changeable::WhilePlaying},
    gst::Property<Settings, bool>{"silent", &Settings::silent,
                                  "Accepted for compatibility; has no effect",
                                  gst::Changeable::WhilePlaying},
};

struct SyncChoice {
  sync::Options options;
  Status mode_status = ok();  // MODE_UNKNOWN: `fallback` is used, or the name is deprecated
};
// Errors: those of sync::parse_base(), only for basepad.
inline Result<SyncChoice> sync_choice(const SyncSettings& settings, sync::Mode fallback) {
  SyncChoice out;
  const auto mode = sync::parse_mode(settings.sync_mode);
  out.options.mode = mode ? *mode : fallback;
  if (!mode) {
    const std::string usual(sync::to_string(fallback));
    Error error = mode.error();
    error.what += "; " + usual + " is used";
    if (error.fix.empty()) error.fix = "sync-mode=" + usual;
    out.mode_status = std::move(error);
  }
  if (auto old = sync::old_name_warning(settings.sync_mode)) out.mode_status = *std::move(old);
  if (out.options.mode != sync::Mode::BasePad) return out;
  const auto base = sync::parse_base(settings.sync_option);
  if (!base) return base.error();
  out.options.base = *base;
  return out;
}

}  // namespace weir
