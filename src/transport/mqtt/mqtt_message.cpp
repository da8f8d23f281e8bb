// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/mqtt/mqtt_message.hpp"

#include <glib.h>

#include "core/wire/peer_error.hpp"

namespace weir::transport {
namespace {

constexpr size_t kMaxTopicBytes = 65535;

Error topic_error(std::string_view property, std::string_view topic, std::string needed) {
  return {.code = Code::OPTION_VALUE,
          .what = "the property " + std::string(property) + " is not an MQTT topic",
          .offered = wire::quoted_text(topic),
          .needed = std::move(needed),
          .fix = std::string(property) + "=camera/tensors"};
}

bool is_text(std::string_view topic) {
  return !topic.empty() && topic.size() <= kMaxTopicBytes &&
         topic.find('\0') == std::string_view::npos &&
         g_utf8_validate(topic.data(), static_cast<gssize>(topic.size()), nullptr);
}

// `#` is the last level, and `+` and `#` are whole levels.
bool has_valid_wildcards(std::string_view filter) {
  while (true) {
    const size_t slash = filter.find('/');
    const std::string_view level = filter.substr(0, slash);
    const bool last = slash == std::string_view::npos;
    if (level.find_first_of("+#") != std::string_view::npos && level.size() > 1) return false;
    if (level == "#" && !last) return false;
    if (last) return true;
    filter.remove_prefix(slash + 1);
  }
}

}  // namespace

std::optional<std::string_view> MqttProperties::find(std::string_view name) const {
  for (const auto& [key, value] : user)
    if (key == name) return value;
  return std::nullopt;
}

size_t MqttProperties::bytes() const {
  size_t out = content_type.size() + response_topic.size() + correlation_data.size() +
               user.capacity() * sizeof user[0];
  for (const auto& [name, value] : user) out += name.size() + value.size();
  return out;
}

Status check_topic(std::string_view property, std::string_view topic) {
  if (is_text(topic) && topic.find_first_of("+#") == std::string_view::npos) return ok();
  return topic_error(property, topic,
                     "1 to 65535 bytes of UTF-8 without the wildcards + and #, and without NUL");
}

Status check_topic_filter(std::string_view property, std::string_view filter) {
  if (is_text(filter) && has_valid_wildcards(filter)) return ok();
  return topic_error(property, filter,
                     "1 to 65535 bytes of UTF-8 without NUL, with + as a whole level and # as the "
                     "last one");
}

}  // namespace weir::transport
