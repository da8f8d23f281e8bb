// LiveSettings: properties written while frames flow, applied between two frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <bitset>
#include <tuple>

namespace weir::gst {

// A set of an element's properties, by index in its kProperties.
using PropertyMask = std::bitset<64>;

template <class Table, class F>
void each_setting(const Table& properties, F&& f) {
  std::apply(
      [&](const auto&... p) {
        size_t i = 0;
        const auto one = [&](const auto& property) {
          if constexpr (requires { property.field; }) f(property, i);
          ++i;
        };
        (one(p), ...);
      },
      properties);
}

// Properties are written one by one, and a frame may pass between two writes that are only valid
// together. A rejected value reads back as before but is kept: it is judged again together with the
// next write, so that the second write completes the first. See Element::follow_settings().
//
// Used on the streaming thread, or while no frames flow.
template <class Settings>
struct LiveSettings {
  Settings in_force;
  Settings refused;      // values of the `waiting` properties; the rest is unused
  PropertyMask waiting;  // rejected, and not written since

  // Merges the waiting values into `now`, whose `written` properties are new.
  template <class Table>
  Settings joined(const Table& properties, Settings now, const PropertyMask& written) {
    waiting &= ~written;
    copy(properties, refused, &now, waiting);
    return now;
  }
  // Compares the properties for which `counts(name)` is true.
  template <class Table, class F>
  bool differs(const Table& properties, const Settings& settings, F&& counts) const {
    bool other = false;
    each_setting(properties, [&](const auto& p, size_t) {
      other = other || (counts(p.name) && settings.*p.field != in_force.*p.field);
    });
    return other;
  }
  // `unwritten`: the properties that were not written meanwhile.
  template <class Table>
  void accept(const Table& properties, const Settings& whole, Settings* shown,
              const PropertyMask& unwritten) {
    copy(properties, whole, shown, waiting & unwritten);
    in_force = whole;
    waiting.reset();
  }
  template <class Table>
  void refuse(const Table& properties, const Settings& whole, const PropertyMask& written,
              Settings* shown, const PropertyMask& undone) {
    copy(properties, in_force, shown, undone);
    refused = whole;
    waiting |= written;
  }

 private:
  template <class Table>
  static void copy(const Table& properties, const Settings& from, Settings* to,
                   const PropertyMask& which) {
    each_setting(properties, [&](const auto& p, size_t i) {
      if (which[i]) (*to).*p.field = from.*p.field;
    });
  }
};

}  // namespace weir::gst
