// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/ledger/ledger.hpp"

#include <numeric>

namespace weir {

std::string_view to_string(DropReason reason) noexcept {
  switch (reason) {
    case DropReason::Policy:
      return "policy";
    case DropReason::Qos:
      return "qos";
    case DropReason::Flush:
      return "flush";
    case DropReason::Eos:
      return "eos";
    case DropReason::Error:
      return "error";
    case DropReason::Time:
      return "time";
    case DropReason::Late:
      return "late";
    case DropReason::Refused:
      return "refused";
    case DropReason::Lost:
      return "lost";
  }
  return "";
}

uint64_t LedgerSnapshot::dropped_total() const noexcept {
  return std::accumulate(dropped.begin(), dropped.end(), uint64_t{0});
}

}  // namespace weir
