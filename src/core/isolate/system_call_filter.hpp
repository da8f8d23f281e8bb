// The system calls that a worker process may not make.
#pragma once
#include <string>

namespace weir::isolate {

// Puts the filter on this thread and those it will start, for ever. "" or why it could not.
std::string filter_system_calls();

}  // namespace weir::isolate
