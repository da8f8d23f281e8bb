// FollowedSettings: properties that were written while frames flow, judged between two frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <bitset>
#include <tuple>

namespace weir::gst {

// Properties of an element, by their place in its kProperties.
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

// Settings are written one by one, and a frame may pass between two that make sense only together.
// What is refused reads back as before, but its value waits: it is judged again together with what
// is written next, so that the second write completes the first. See Element::follow_settings().
//
// Streaming thread, and while nothing streams.
template <class Settings>
struct FollowedSettings {
  Settings in_force;
  Settings refused;      // the values of `waiting`; others have no meaning
  PropertyMask waiting;  // refused, and not written since

  // `now`, of which `written` is new, together with what waits.
  template <class Table>
  Settings joined(const Table& properties, Settings now, const PropertyMask& written) {
    waiting &= ~written;
    copy(properties, refused, &now, waiting);
    return now;
  }
  // Of the properties whose name `counts`.
  template <class Table, class F>
  bool differs(const Table& properties, const Settings& settings, F&& counts) const {
    bool other = false;
    each_setting(properties, [&](const auto& p, size_t) {
      other = other || (counts(p.name) && settings.*p.field != in_force.*p.field);
    });
    return other;
  }
  // `unwritten`: of the properties, those that no write changed meanwhile.
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
