// How many threads a computation of this process should use.
#pragma once

namespace weir::engine {

// Physical cores that the process may run on: its affinity mask with the siblings of one core
// counted once, and no more than its control group's quota. At least 1.
int usable_cores();

}  // namespace weir::engine
