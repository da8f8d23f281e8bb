// Reflection: describes the services of a server to clients that know nothing of them, as gRPC's
// server reflection does (v1 and v1alpha, which have the same messages).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "net/protocol/oip_messages.hpp"

namespace weir::net {

class Reflection {
 public:
  // `files`: a FileDescriptorSet of protoc whose files import nothing. Borrowed.
  explicit Reflection(std::string_view files);
  // Answers from the files in src/net/protocol.
  static const Reflection& of_this_server();

  // Without descriptions, as in a build without protoc, there is nothing to answer.
  bool empty() const noexcept { return services_.empty(); }
  // ServerReflectionResponse to a ServerReflectionRequest; what is not there is an error in it.
  // PEER_MESSAGE_INVALID for bytes that are no such message, or have names of more than 1024 bytes.
  Result<Pieces> respond(const Chunks& request) const;

 private:
  void add_file(const Chunks& chunks, Range file, std::string_view bytes);
  void add_type(const Chunks& chunks, Range type, const std::string& scope, std::string_view file);
  void add_service(const Chunks& chunks, Range service, const std::string& scope,
                   std::string_view file);
  std::string make_response(uint32_t question, const std::string& name) const;

  std::vector<std::string> services_;
  std::map<std::string, std::string_view> files_;    // FileDescriptorProto by its name
  std::map<std::string, std::string_view> symbols_;  // by types, services and methods
  std::map<std::string, bool> messages_;             // the types that could have extensions
};

}  // namespace weir::net
