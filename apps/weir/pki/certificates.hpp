// Certificates of a certificate authority of the user's own: ECDSA on P-256, in PEM.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "weir/result.hpp"

namespace weir::app {

struct Certificate {
  std::string certificate, key;  // PEM; the key is not encrypted
  std::string valid_until;       // "2027-02-24"
};

// A certificate that signs others, and itself. It signs no other authorities.
Result<Certificate> make_authority(int days);

// A certificate for servers and clients with these names, signed by `authority`, of which
// `certificate` and `key` are used. `names`: host names and IP addresses, checked by the caller;
// the first one is the subject too.
Result<Certificate> issue_certificate(const Certificate& authority,
                                      const std::vector<std::string>& names, int days);

}  // namespace weir::app
