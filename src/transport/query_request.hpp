// QueryRequest: a frame of a client that waits for its response, in the protocol of any server.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>

namespace weir {

// One request of a client. Ends when its last reference goes. Thread-safe.
class QueryRequest {
 public:
  QueryRequest() = default;
  QueryRequest(const QueryRequest&) = delete;
  QueryRequest& operator=(const QueryRequest&) = delete;
  virtual ~QueryRequest() = default;

  // The same for all requests of a connection; not negative.
  virtual int64_t client() const = 0;
  // Ends the request if its client no longer waits for the response: true when it has ended.
  virtual bool end_if_expired() = 0;
  // `element`: a text that lives as long as the process.
  virtual void entered(const char* element) noexcept = 0;
  virtual void pushed() noexcept = 0;

  // Returns the id of the tensor_query_serversrc that received it; set before its frame is pushed.
  uint32_t source_id() const noexcept { return source_id_; }
  void set_source_id(uint32_t id) noexcept { source_id_ = id; }

 private:
  uint32_t source_id_ = 0;
};

}  // namespace weir
