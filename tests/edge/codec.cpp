// Writes nnstreamer-edge messages from lines of JSON, and the reverse, with the code of core/wire.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/wire/edge_message_reader.hpp"
#include "core/wire/edge_metadata.hpp"
#include "core/wire/mqtt_frame.hpp"
#include "core/wire/mqtt_header.hpp"

namespace weir::wire {
namespace {

using Bytes = std::vector<std::byte>;
using Json = nlohmann::json;

constexpr MessageLimits kLimits;
const std::map<int, HeaderForm> kForms{
    {160, HeaderForm::Bytes160}, {168, HeaderForm::Bytes168}, {2088, HeaderForm::Bytes2088}};
const std::map<int, MqttForm> kMqttForms{
    {144, MqttForm::Bytes144}, {160, MqttForm::Bytes160}, {2080, MqttForm::Bytes2080}};

template <class T>
T get_or_exit(Result<T> result) {
  if (result) return *std::move(result);
  std::fprintf(stderr, "%s\n", result.error().message().c_str());
  std::exit(1);
}

template <class Form>
int find_bytes(const std::map<int, Form>& forms, Form wanted) {
  for (const auto& [bytes, form] : forms)
    if (form == wanted) return bytes;
  std::abort();
}

Bytes from_hex(const std::string& text) {
  Bytes out;
  for (size_t i = 0; i + 1 < text.size(); i += 2)
    out.push_back(static_cast<std::byte>(std::stoi(text.substr(i, 2), nullptr, 16)));
  return out;
}

std::string to_hex(std::span<const std::byte> bytes) {
  std::string out;
  for (const std::byte byte : bytes) {
    out += "0123456789abcdef"[std::to_integer<int>(byte) >> 4];
    out += "0123456789abcdef"[std::to_integer<int>(byte) & 15];
  }
  return out;
}

void write(std::span<const std::byte> bytes) {
  if (!bytes.empty()) std::fwrite(bytes.data(), 1, bytes.size(), stdout);
}

// The metadata in the order of the pairs: the last one that is set comes first.
Bytes to_metadata(const Json& pairs) {
  EdgeMetadata metadata;
  for (size_t i = pairs.size(); i-- > 0;)
    get_or_exit(metadata.set(pairs[i][0].get<std::string>(), pairs[i][1].get<std::string>()));
  return metadata.encode();
}

Json to_pairs(std::span<const std::byte> bytes) {
  Json out = Json::array();
  const auto metadata = get_or_exit(EdgeMetadata::parse(bytes));
  for (const auto& [key, value] : metadata.pairs()) out.push_back({key, value});
  return out;
}

Command parse_command(const std::string& name) {
  for (const auto command :
       {Command::Error, Command::TransferData, Command::HostInfo, Command::Capability})
    if (to_string(command) == name) return command;
  std::abort();
}

void encode_frame(const Json& fields, bool mqtt) {
  std::vector<Bytes> memories;
  std::vector<uint64_t> sizes;
  for (const auto& memory : fields["memories"]) {
    memories.push_back(from_hex(memory.get<std::string>()));
    sizes.push_back(memories.back().size());
  }
  const Bytes metadata = to_metadata(fields["metadata"]);
  const int form = fields["form"].get<int>();
  write(mqtt ? get_or_exit(write_mqtt_frame_header(kMqttForms.at(form), sizes, metadata.size()))
             : get_or_exit(write_header(
                   kForms.at(form), {.command = parse_command(fields["command"].get<std::string>()),
                                     .client_id = fields["client_id"].get<int64_t>(),
                                     .sizes = sizes,
                                     .metadata_bytes = metadata.size()})));
  for (const auto& memory : memories) write(memory);
  write(metadata);
}

std::optional<uint64_t> read_time(const Json& value) {
  return value.is_null() ? std::nullopt : std::optional(value.get<uint64_t>());
}

Json time_json(std::optional<uint64_t> time) {
  return time ? Json(*time) : Json();
}

void encode_mqtt_header(const Json& fields) {
  write(get_or_exit(write_mqtt_header({.sizes = fields["sizes"].get<std::vector<uint64_t>>(),
                                       .base_time_epoch = fields["base_time_epoch"].get<int64_t>(),
                                       .sent_time_epoch = fields["sent_time_epoch"].get<int64_t>(),
                                       .duration = read_time(fields["duration"]),
                                       .dts = read_time(fields["dts"]),
                                       .pts = read_time(fields["pts"]),
                                       .caps = fields["caps"].get<std::string>()})));
}

void decode_messages(std::span<const std::byte> bytes, size_t piece) {
  EdgeMessageReader reader(kLimits);
  while (!bytes.empty()) {
    const size_t taken = get_or_exit(reader.feed(bytes.first(std::min(piece, bytes.size()))));
    bytes = bytes.subspan(taken);
    if (!reader.complete()) continue;
    const auto message = reader.take();
    Json memories = Json::array();
    for (const auto& memory : message.memories) memories.push_back(to_hex(memory.bytes()));
    std::cout << Json{{"form", find_bytes(kForms, reader.form().value())},
                      {"command", to_string(message.command)},
                      {"client_id", message.client_id},
                      {"memories", memories},
                      {"metadata", to_pairs(message.metadata.bytes())}}
              << '\n';
  }
  get_or_exit(reader.end());
}

void decode_mqtt(std::span<const std::byte> payload) {
  const auto frame = get_or_exit(parse_mqtt_frame(payload, kLimits));
  Json memories = Json::array();
  for (const auto& memory : frame.memories) memories.push_back(to_hex(memory));
  std::cout << Json{{"form", find_bytes(kMqttForms, frame.form)},
                    {"memories", memories},
                    {"metadata", to_pairs(frame.metadata)}}
            << '\n';
}

void decode_mqtt_header(std::span<const std::byte> bytes) {
  const auto header = get_or_exit(parse_mqtt_header(bytes));
  std::cout << Json{{"sizes", header.sizes},
                    {"base_time_epoch", header.base_time_epoch},
                    {"sent_time_epoch", header.sent_time_epoch},
                    {"duration", time_json(header.duration)},
                    {"dts", time_json(header.dts)},
                    {"pts", time_json(header.pts)},
                    {"caps", header.caps}}
            << '\n';
}

void encode(const std::string& kind) {
  for (std::string line; std::getline(std::cin, line);) {
    const auto fields = Json::parse(line);
    if (kind == "mqtt-header")
      encode_mqtt_header(fields);
    else
      encode_frame(fields, kind == "mqtt");
  }
}

void decode(const std::string& kind, size_t piece) {
  const std::string input((std::istreambuf_iterator<char>(std::cin)), {});
  const auto bytes = std::as_bytes(std::span(input));
  if (kind == "mqtt-header")
    decode_mqtt_header(bytes);
  else if (kind == "mqtt")
    decode_mqtt(bytes);
  else
    decode_messages(bytes, piece);
}

}  // namespace
}  // namespace weir::wire

// encode KIND, decode KIND [PIECE]: KIND is message, mqtt or mqtt-header. PIECE is the number of
// bytes that arrive at once.
int main(int argc, char** argv) {
  if (argc < 3) return 2;
  if (argv[1] == std::string("encode"))
    weir::wire::encode(argv[2]);
  else
    weir::wire::decode(argv[2], argc > 3 ? std::strtoul(argv[3], nullptr, 10) : 4096);
  return 0;
}
