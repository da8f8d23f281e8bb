// Fuzz target: parses sync-mode and sync-option, and runs every policy on pads in any state.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <string>
#include <vector>

#include "core/sync/options.hpp"
#include "fuzz_input.hpp"

namespace {

using namespace weir::sync;
using weir::fuzz::FuzzInput;
using weir::fuzz::require;

Stamp stamp_from(FuzzInput* input) {
  switch (input->below(4)) {
    case 0:
      return std::nullopt;
    case 1:
      return input->take<uint64_t>();
    default:
      return input->byte();
  }
}

std::vector<PadView> pads_from(FuzzInput* input) {
  std::vector<PadView> pads(input->below(5) + 1);
  for (auto& pad : pads) {
    pad.state = static_cast<PadState>(input->below(5));
    if (pad.state == PadState::Head) pad.head = stamp_from(input);
    if (pad.state == PadState::Gap) pad.gap_end = stamp_from(input).value_or(0);
    pad.has_kept = input->flag();
    if (pad.has_kept) pad.kept = stamp_from(input);
    pad.went_back = input->flag();
  }
  return pads;
}

void check_decision(const Decision& decision, const std::vector<PadView>& pads) {
  require(decision.uses.size() == pads.size(), "every pad has a use");
  for (size_t i = 0; i < pads.size(); ++i) {
    if (decision.uses[i] == Use::Head || decision.uses[i] == Use::Discard)
      require(pads[i].state == PadState::Head, "only a head is popped");
    if (decision.uses[i] == Use::Kept) require(pads[i].has_kept, "only a kept frame is repeated");
  }
  if (decision.outcome == Outcome::Emit)
    require(decision.metadata_pad < pads.size(), "metadata comes from a pad");
}

// If no pad gets data before its frame is taken, a policy that waits would wait forever.
void check_progress(const Decision& decision, const std::vector<PadView>& pads) {
  const auto is_settled = [](const PadView& pad) {
    return pad.state == PadState::Head || pad.state == PadState::Ended;
  };
  if (!std::all_of(pads.begin(), pads.end(), is_settled)) return;
  require(decision.outcome != Outcome::Wait ||
              std::count(decision.uses.begin(), decision.uses.end(), Use::Discard) > 0,
          "frames of pads that are all known are used or discarded");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzInput input(data, size);
  const auto mode = parse_mode(input.line());
  const auto base = parse_base(input.line());
  if (!mode) require(!mode.error().what.empty(), "an error has a text");
  if (!base) require(!base.error().what.empty(), "an error has a text");
  Options options;
  options.mode = mode ? *mode : static_cast<Mode>(input.below(5));
  if (base) options.base = *base;
  options.lateness = stamp_from(&input);
  Round round;
  round.current = stamp_from(&input).value_or(0);
  round.need_set = input.flag();
  const auto first = pads_from(&input);
  for (int step = 0; step < 4; ++step) {
    auto pads = pads_from(&input);
    pads.resize(first.size());  // the number of pads never changes within a round
    if (options.mode == Mode::BasePad && options.base.pad >= pads.size()) return 0;
    const auto decision = decide(options, round, pads);
    check_decision(decision, pads);
    check_progress(decision, pads);
    round = decision.round;
  }
  return 0;
}
