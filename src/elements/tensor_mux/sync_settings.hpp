// SyncSettings: the properties of elements that bring several streams together by a policy.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <tuple>

#include "core/sync/lanes.hpp"
#include "gstcpp/backwards_time.hpp"
#include "gstcpp/property.hpp"

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
    gst::Property<Settings, std::string>{
        "sync-mode", &Settings::sync_mode,
        "Which frames go together: nosync, slowest, basepad, refresh; also base (= basepad) and "
        "fastest (= refresh)",
        gst::Changeable::WhilePlaying},
    gst::Property<Settings, std::string>{
        "sync-option", &Settings::sync_option,
        "With basepad: PAD[:DURATION], the number of the base in the order of requests, and how "
        "many nanoseconds another frame may be away; empty = 0:2147483647",
        gst::Changeable::WhilePlaying},
    gst::Property<Settings, uint64_t>{
        "max-wait", &Settings::max_wait,
        "Nanoseconds after which a pad without frames is not waited for any more; 0 = for ever",
        gst::Changeable::WhilePlaying},
    gst::Property<Settings, uint64_t>{
        "max-bytes", &Settings::max_bytes,
        "Bytes of all frames that are held, those that are used again too; a frame beyond it waits "
        "for the output that is being made, and is an error where that makes no room; 0 = any",
        gst::Changeable::WhilePlaying},
    gst::Property<Settings, OnBackwardsTime>{"on-backwards-time", &Settings::on_backwards_time,
                                             "What becomes of a frame with an earlier time than "
                                             "the one ahead of it on its pad; when all "
                                             "pads began anew, so does the output",
                                             gst::Changeable::WhilePlaying},
    gst::Property<Settings, bool>{"silent", &Settings::silent,
                                  "Accepted for compatibility; has no effect",
                                  gst::Changeable::WhilePlaying},
};

struct SyncChoice {
  sync::Options options;
  Status mode_status = ok();  // MODE_UNKNOWN: `fallback` was taken, or the word is an old one
};
// Errors: those of sync::parse_base(), for basepad only.
inline Result<SyncChoice> sync_choice(const SyncSettings& settings, sync::Mode fallback) {
  SyncChoice out;
  const auto mode = sync::parse_mode(settings.sync_mode);
  out.options.mode = mode ? *mode : fallback;
  if (!mode) {
    const std::string usual(sync::name_of(fallback));
    Error error = mode.error();
    error.what += ", and " + usual + " is taken";
    if (error.fix.empty()) error.fix = "sync-mode=" + usual;
    out.mode_status = std::move(error);
  }
  if (auto old = sync::old_word(settings.sync_mode)) out.mode_status = *std::move(old);
  if (out.options.mode != sync::Mode::BasePad) return out;
  const auto base = sync::parse_base(settings.sync_option);
  if (!base) return base.error();
  out.options.base = *base;
  return out;
}

}  // namespace weir
