// The slots of this process, through which tensor_reposink passes frames to tensor_reposrc.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "core/ledger/ledger.hpp"
#include "core/loop/slot_table.hpp"
#include "gstcpp/element/ref.hpp"
#include "gstcpp/element/result_events.hpp"
#include "weir/result.hpp"

namespace weir {

// Labels by source.
using LabelsBySource = std::map<std::string, gst::LabelsOfSource>;

struct StoredFrame {
  gst::Ref<GstBuffer> buffer;  // shared: not writable while others hold it
  gst::Ref<GstCaps> caps;
  std::shared_ptr<Ledger> ledger;  // of the sink, which holds the frame until it is consumed
  std::shared_ptr<const LabelsBySource> labels;  // of the stream; null = none
};

using Repository = loop::SlotTable<StoredFrame>;
Repository& repository();

// The error for a waiting element whose slot has no element `missing` at the other end.
Error lone_end(const char* missing, uint32_t slot);

// Counts a frame that was dropped with its slot.
inline void count_left(const std::optional<StoredFrame>& frame) {
  if (frame) frame->ledger->dropped(DropReason::Eos);
}

}  // namespace weir
