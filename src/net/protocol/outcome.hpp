// How a request to a server ended. Every request ends once, in one of these ways.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string_view>

namespace weir::net {

// Answered: with a result. Late: at its deadline. Refused: the server rejected it. Lost: the
// connection or the server ended, or no server could be reached.
enum class Outcome { Answered, Late, Refused, Lost };

// The status codes of gRPC that are used here.
enum class CallStatus {
  Ok = 0,
  Cancelled = 1,
  InvalidArgument = 3,
  DeadlineExceeded = 4,
  NotFound = 5,
  PermissionDenied = 7,
  ResourceExhausted = 8,
  FailedPrecondition = 9,
  Aborted = 10,
  Unimplemented = 12,
  Internal = 13,
  Unavailable = 14,
  Unauthenticated = 16,
};

// `status`: a status code of gRPC.
constexpr Outcome to_outcome(int status) noexcept {
  switch (status) {
    case 0:
      return Outcome::Answered;
    case 4:
      return Outcome::Late;  // DEADLINE_EXCEEDED
    case 1:                  // CANCELLED, by the server
    case 2:                  // UNKNOWN
    case 10:                 // ABORTED
    case 13:                 // INTERNAL
    case 14:                 // UNAVAILABLE
    case 15:
      return Outcome::Lost;  // DATA_LOSS
    default:
      return Outcome::Refused;
  }
}

}  // namespace weir::net
