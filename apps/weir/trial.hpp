// Something that may end the process, tried in another one first.
#pragma once
#include <functional>
#include <string>

namespace weir::app {

// "" when `load` returns in a copy of this process; else how that ended, for people. The copy has
// ten seconds, says nothing on the standard output and leaves nothing behind.
std::string ending_of(const std::function<void()>& load);

}  // namespace weir::app
