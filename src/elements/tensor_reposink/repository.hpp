// The slots of this process, through which tensor_reposink hands frames to tensor_reposrc.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <optional>

#include "core/ledger/ledger.hpp"
#include "core/loop/slot_table.hpp"
#include "gstcpp/ref.hpp"
#include "weir/result.hpp"

namespace weir {

struct StoredFrame {
  gst::Ref<GstBuffer> buffer;  // shared: nobody writes to memory that others hold
  gst::Ref<GstCaps> caps;
  std::shared_ptr<Ledger> ledger;  // of the sink, which holds the frame until it is taken
};

using Repository = loop::SlotTable<StoredFrame>;
Repository& repository();

// For an end that waits in a slot that has no `missing`, the element of the other end.
Error lone_end(const char* missing, uint32_t slot);

// A frame that went with its slot.
inline void count_left(const std::optional<StoredFrame>& frame) {
  if (frame) frame->ledger->dropped(DropReason::Eos);
}

}  // namespace weir
