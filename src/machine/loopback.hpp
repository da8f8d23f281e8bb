// Which hosts are this machine, for the rules on encryption.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string_view>

namespace weir {

// Whether only programs of this machine are reached under `host`: "localhost", 127.x.x.x, ::1, with
// or without brackets. A name such as 127.0.0.1.example is another machine.
bool is_loopback(std::string_view host);

}  // namespace weir
