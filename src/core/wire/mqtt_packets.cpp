// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/mqtt_packets.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string>

#include "core/wire/peer_error.hpp"

namespace weir::wire {
namespace {

using Bytes = std::span<const std::byte>;

// MQTT 5, 2.1.2: types of packets.
enum Packet : uint8_t {
  kConnack = 2,
  kPublish = 3,
  kPuback = 4,
  kPubrec = 5,
  kPubcomp = 7,
  kSuback = 9,
  kUnsuback = 11,
  kPingresp = 13,
  kDisconnect = 14,
  kAuth = 15
};

enum class Kind : uint8_t { None, Byte, Two, Four, Number, Text, Pair };

// MQTT 5, 2.2.2.2: properties by their number.
constexpr auto kKinds = [] {
  std::array<Kind, 128> out{};
  for (const int id : {1, 23, 25, 36, 37, 40, 41, 42}) out[id] = Kind::Byte;
  for (const int id : {19, 33, 34, 35}) out[id] = Kind::Two;
  for (const int id : {2, 17, 24, 39}) out[id] = Kind::Four;
  for (const int id : {3, 8, 9, 18, 21, 22, 26, 28, 31}) out[id] = Kind::Text;
  out[11] = Kind::Number;
  out[38] = Kind::Pair;
  return out;
}();

Error packet_error(std::string offered, std::string needed) {
  return peer_error("a packet of the broker cannot be read", std::move(offered), std::move(needed),
                    "protocol=4, which is MQTT 3.1.1");
}

uint8_t number(std::byte byte) {
  return std::to_integer<uint8_t>(byte);
}

constexpr size_t kMaxNumberBytes = 4;

// MQTT 5, 1.5.5: a variable byte integer, up to four bytes; all but the last have their highest bit
// set.
struct VariableNumber {
  uint32_t value = 0;
  size_t bytes = 0;
};
// Nullopt if its end is not there, or it has none.
std::optional<VariableNumber> read_number(Bytes bytes) {
  VariableNumber out;
  while (out.bytes < std::min(bytes.size(), kMaxNumberBytes)) {
    const uint8_t byte = number(bytes[out.bytes]);
    out.value |= uint32_t{byte & 127u} << (7 * out.bytes);
    ++out.bytes;
    if (byte < 128) return out;
  }
  return std::nullopt;
}

void append_number(uint32_t value, std::vector<std::byte>* out) {
  for (; value > 127; value /= 128) out->push_back(static_cast<std::byte>(value % 128 + 128));
  out->push_back(static_cast<std::byte>(value));
}

// Bytes of a text with its size; more than there are if it is cut.
size_t text_size(Bytes bytes) {
  if (bytes.size() < 2) return bytes.size() + 1;
  return size_t{2} + (number(bytes[0]) << 8 | number(bytes[1]));
}

// The bytes of a value; more than there are if it is cut.
size_t value_size(Kind kind, Bytes bytes) {
  switch (kind) {
    case Kind::Byte:
      return 1;
    case Kind::Two:
      return 2;
    case Kind::Four:
      return 4;
    case Kind::Text:
      return text_size(bytes);
    case Kind::Number: {
      const auto value = read_number(bytes);
      return value ? value->bytes : bytes.size() + 1;
    }
    case Kind::Pair: {
      const size_t name = text_size(bytes);
      return name > bytes.size() ? name : name + text_size(bytes.subspan(name));
    }
    case Kind::None:
      break;
  }
  return bytes.size() + 1;
}

Status check_properties(Bytes bytes) {
  while (!bytes.empty()) {
    const uint8_t id = number(bytes[0]);
    const Kind kind = id < kKinds.size() ? kKinds[id] : Kind::None;
    if (kind == Kind::None)
      return packet_error("a property with the number " + std::to_string(id),
                          "the properties of MQTT 5");
    bytes = bytes.subspan(1);
    const size_t size = value_size(kind, bytes);
    if (size > bytes.size())
      return packet_error("a property that exceeds the properties of its packet",
                          "values within their sizes");
    bytes = bytes.subspan(size);
  }
  return ok();
}

// The bytes before the length of the properties; of a PUBLISH without its topic.
size_t fixed_size(uint8_t type) {
  switch (type >> 4) {
    case kConnack:
    case kSuback:
    case kUnsuback:
      return 2;
    case kPublish:
      return (type & 6) ? 4 : 2;  // QoS 1 and 2 have a number
    case kDisconnect:
    case kAuth:
      return 1;
    default:
      return 3;  // PUBACK to PUBCOMP
  }
}

// Packets that a client gets.
bool is_of_broker(uint8_t type) {
  const uint8_t packet = type >> 4;
  return (packet >= kConnack && packet <= kPubcomp) || packet == kSuback || packet == kUnsuback ||
         packet >= kPingresp;
}
// Whether the length of the properties may be missing, as in a CONNACK of MQTT 3.
bool may_end_early(uint8_t type) {
  const uint8_t packet = type >> 4;
  return packet == kConnack || (packet >= kPuback && packet <= kPubcomp) || packet >= kDisconnect;
}

// MQTT 5, 3.4.2.1 and 3.5.2.1: why a message is refused.
constexpr std::byte kFirstRefusal{0x80};  // for a reason that is not known
constexpr uint8_t kRefusals[] = {0x80, 0x83, 0x87, 0x90, 0x91, 0x97, 0x99};

}  // namespace

Status MqttPacketFilter::feed(Bytes bytes, std::vector<std::byte>* out) {
  while (status_ && !bytes.empty()) {
    const std::byte first = bytes[0];
    switch (part_) {
      case Part::Type:
        start_ = {first};
        type_ = number(first);
        part_ = Part::Length;
        bytes = bytes.subspan(1);
        break;
      case Part::Length:
        start_.push_back(first);
        bytes = bytes.subspan(1);
        status_ = take_length(out);
        break;
      case Part::Head:
        status_ = take_head(&bytes, out);
        break;
      case Part::Skipped:
        skip(&bytes);
        break;
      case Part::Rest:
        pass_rest(&bytes, out);
    }
  }
  return status_;
}

void MqttPacketFilter::skip(Bytes* bytes) {
  const size_t size = std::min(skipped_, bytes->size());
  *bytes = bytes->subspan(size);
  skipped_ -= size;
  if (skipped_ == 0) part_ = left_ > 0 ? Part::Rest : Part::Type;
}

void MqttPacketFilter::pass_rest(Bytes* bytes, std::vector<std::byte>* out) {
  const auto passed = bytes->first(std::min(left_, bytes->size()));
  out->insert(out->end(), passed.begin(), passed.end());
  *bytes = bytes->subspan(passed.size());
  left_ -= passed.size();
  if (left_ == 0) part_ = Part::Type;
}

Status MqttPacketFilter::take_length(std::vector<std::byte>* out) {
  if (!is_of_broker(type_))
    return packet_error("a packet of type " + std::to_string(type_ >> 4),
                        "packets that a broker sends");
  const auto length = read_number(Bytes(start_).subspan(1));
  if (!length) {
    if (start_.size() < 1 + kMaxNumberBytes) return ok();
    return packet_error("a length of more than four bytes", "packets of at most 268435455 bytes");
  }
  length_ = length->value;
  left_ = length_;
  head_.clear();
  const size_t fixed = fixed_size(type_);
  if (type_ >> 4 == kPingresp || length_ == 0) return end_head(out);
  part_ = Part::Head;
  if (length_ > fixed || may_end_early(type_)) return ok();
  return packet_error("a packet of " + std::to_string(length_) + " bytes",
                      "packets with their properties");
}

size_t MqttPacketFilter::begin_of_properties() const {
  const size_t fixed = fixed_size(type_);
  if (type_ >> 4 != kPublish) return fixed;
  return fixed - 2 + text_size(head_);
}

Result<size_t> MqttPacketFilter::head_size() const {
  if (length_ <= fixed_size(type_)) return length_;
  const size_t begin = begin_of_properties();
  if (head_.size() <= begin) return begin + 1;
  const auto after = Bytes(head_).subspan(begin);
  const auto size = read_number(after);
  if (size) return begin + size->bytes + size->value;
  if (after.size() < kMaxNumberBytes) return head_.size() + 1;
  return packet_error("a length of more than four bytes", "properties with a length");
}

Status MqttPacketFilter::take_head(Bytes* bytes, std::vector<std::byte>* out) {
  const size_t missing = *head_size() - head_.size();
  const auto taken = bytes->first(std::min(missing, bytes->size()));
  head_.insert(head_.end(), taken.begin(), taken.end());
  *bytes = bytes->subspan(taken.size());
  left_ -= taken.size();
  const auto size = head_size();
  if (!size) return size.error();
  if (*size > length_)
    return packet_error("properties that exceed their packet", "packets with their properties");
  if (*size > head_.size() + kMaxMqttPropertyBytes) return strip(*size - head_.size(), out);
  if (head_.size() < *size) return ok();
  replace_reason();
  const auto after = Bytes(head_).subspan(std::min(begin_of_properties(), head_.size()));
  const auto length = read_number(after);
  auto status = length ? check_properties(after.subspan(length->bytes)) : ok();
  return status ? end_head(out) : status;
}

void MqttPacketFilter::replace_reason() {
  const uint8_t packet = type_ >> 4;
  if ((packet != kPuback && packet != kPubrec) || head_.size() < 3 || head_[2] < kFirstRefusal ||
      std::count(std::begin(kRefusals), std::end(kRefusals), number(head_[2])) > 0)
    return;
  head_[2] = kFirstRefusal;
  ++replaced_;
}

// Writes the packet again without its properties. None of their bytes has come yet: only their
// length has.
Status MqttPacketFilter::strip(size_t properties, std::vector<std::byte>* out) {
  if (type_ >> 4 != kPublish)
    return packet_error(std::to_string(properties) + " bytes of properties",
                        "at most " + std::to_string(kMaxMqttPropertyBytes) + " bytes");
  skipped_ = properties;
  left_ -= properties;
  head_.resize(begin_of_properties());
  head_.push_back(std::byte{0});
  start_.resize(1);
  append_number(static_cast<uint32_t>(head_.size() + left_), &start_);
  ++stripped_;
  auto status = end_head(out);
  part_ = Part::Skipped;
  return status;
}

Status MqttPacketFilter::end_head(std::vector<std::byte>* out) {
  out->insert(out->end(), start_.begin(), start_.end());
  out->insert(out->end(), head_.begin(), head_.end());
  part_ = left_ > 0 ? Part::Rest : Part::Type;
  return ok();
}

}  // namespace weir::wire
