// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/server/reflection.hpp"

#include "net/protocol/oip_contents.hpp"
#include "net/protocol/outcome.hpp"

namespace weir::net {
namespace {

#ifdef WEIR_SERVICE_DESCRIPTORS
constexpr unsigned char kFiles[] = {
#include WEIR_SERVICE_DESCRIPTORS
};
#else
constexpr unsigned char kFiles[] = {0};
#endif

constexpr size_t kMaxRequestBytes = 4096;  // which come back with the response

// ServerReflectionRequest.message_request by field number.
enum Question : uint32_t {
  kFileByName = 3,
  kFileOfSymbol = 4,
  kFileOfExtension = 5,
  kExtensionsOfType = 6,
  kServices = 7
};
// ServerReflectionResponse.message_response.
enum Response : uint32_t { kFile = 4, kExtensions = 5, kServiceList = 6, kError = 7 };

Chunks split_chunks(std::string_view bytes) {
  return Chunks({std::as_bytes(std::span(bytes))});
}

// The name in a descriptor, which is its first field.
std::string name_in(const Chunks& chunks, Range range) {
  FieldReader reader(chunks, range);
  for (Field field; reader.next(&field);)
    if (field.number == 1) return reader.text(field, kMaxNameBytes);
  return "";
}

std::string error_response(const std::string& text) {
  std::string error, out;
  put_number(&error, 1, static_cast<uint64_t>(CallStatus::NotFound));
  put_bytes(&error, 2, text);
  put_bytes(&out, kError, error);
  return out;
}

std::string file_response(std::string_view file) {
  std::string list, out;
  put_bytes(&list, 1, file);
  put_bytes(&out, kFile, list);
  return out;
}

}  // namespace

const Reflection& Reflection::of_this_server() {
  static const Reflection all(
      sizeof kFiles == 1 ? std::string_view()
                         : std::string_view(reinterpret_cast<const char*>(kFiles), sizeof kFiles));
  return all;
}

Reflection::Reflection(std::string_view files) {
  const Chunks chunks = split_chunks(files);
  FieldReader reader(chunks, {0, chunks.size()});
  for (Field field; reader.next(&field);)
    if (field.number == 1)
      add_file(chunks, field.range, files.substr(field.range.begin, field.range.size()));
}

void Reflection::add_file(const Chunks& chunks, Range file, std::string_view bytes) {
  std::string scope;
  FieldReader reader(chunks, file);
  for (Field field; reader.next(&field);) {
    if (field.number == 1) files_[reader.text(field, kMaxNameBytes)] = bytes;
    if (field.number == 2) scope = reader.text(field, kMaxNameBytes) + ".";
    if (field.number == 4) add_type(chunks, field.range, scope, bytes);
    if (field.number == 5) symbols_[scope + name_in(chunks, field.range)] = bytes;
    if (field.number == 6) add_service(chunks, field.range, scope, bytes);
  }
}

void Reflection::add_type(const Chunks& chunks, Range type, const std::string& scope,
                          std::string_view file) {
  const std::string name = scope + name_in(chunks, type);
  symbols_[name] = file;
  messages_[name] = true;
  FieldReader reader(chunks, type);
  for (Field field; reader.next(&field);) {
    if (field.number == 3) add_type(chunks, field.range, name + ".", file);
    if (field.number == 4) symbols_[name + "." + name_in(chunks, field.range)] = file;
  }
}

void Reflection::add_service(const Chunks& chunks, Range service, const std::string& scope,
                             std::string_view file) {
  const std::string name = scope + name_in(chunks, service);
  services_.push_back(name);
  symbols_[name] = file;
  FieldReader reader(chunks, service);
  for (Field field; reader.next(&field);)
    if (field.number == 2) symbols_[name + "." + name_in(chunks, field.range)] = file;
}

std::string Reflection::make_response(uint32_t question, const std::string& name) const {
  std::string list, out;
  if (question == kServices) {
    for (const auto& service : services_) {
      std::string entry;
      put_bytes(&entry, 1, service);
      put_bytes(&list, 1, entry);
    }
    put_bytes(&out, kServiceList, list);
    return out;
  }
  if (question == kExtensionsOfType && messages_.count(name) != 0) {  // proto3 has none
    put_bytes(&list, 1, name);
    put_bytes(&out, kExtensions, list);
    return out;
  }
  const auto& files = question == kFileByName ? files_ : symbols_;
  const auto found = files.find(name);
  if (question <= kFileOfSymbol && found != files.end()) return file_response(found->second);
  return error_response(question == kFileByName        ? "there is no file " + name + " here"
                        : question == kFileOfExtension ? "there are no extensions here"
                                                       : "there is no symbol " + name + " here");
}

Result<Pieces> Reflection::respond(const Chunks& request) const {
  uint32_t question = 0;
  std::string host, name;
  FieldReader reader(request, {0, request.size()});
  for (Field field; request.size() <= kMaxRequestBytes && reader.next(&field);) {
    if (field.number == 1) host = reader.text(field, kMaxNameBytes);
    if (field.number < kFileByName || field.number > kServices) continue;
    question = field.number;
    name = reader.text(field, kMaxNameBytes);
  }
  if (reader.failed() || question == 0)
    return damaged_message(Sender::Client, "ServerReflectionRequest");
  std::string original(request.size(), '\0'), out;
  request.copy({0, request.size()}, original.data());
  if (!host.empty()) put_bytes(&out, 1, host);
  put_bytes(&out, 2, original);
  out += make_response(question, name);
  return Pieces{{std::move(out), {}}};
}

}  // namespace weir::net
