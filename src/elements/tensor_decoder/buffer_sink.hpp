// BufferSink: where a decoder puts its caps and its output, over one GstBuffer.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <optional>
#include <string>
#include <vector>

#include "core/infer/host.hpp"
#include "core/ledger/ledger.hpp"
#include "core/limit/buffer_limit.hpp"
#include "gstcpp/buffer_parts.hpp"
#include "gstcpp/frame_reader.hpp"

namespace weir {

class BufferSink final : public weir_sink {
 public:
  BufferSink() = default;  // for configure: takes caps only
  BufferSink(GstBuffer* in, GstBuffer* out, const gst::FrameReader* reader,
             const BufferLimit& limit, Ledger* ledger)
      : in_(in), out_(out), reader_(reader), limit_(&limit), ledger_(ledger) {}
  ~BufferSink() = default;

  Status set_caps(const std::string& caps) override;
  void* reserve(uint64_t bytes) override;
  Status share_input(uint32_t index) override;
  // Gives the buffer what was reserved and shared, in that order: a memory for each, from the 16th
  // on one for all where there are more than 16. LIMIT_EXCEEDED, OUT_OF_MEMORY, MAP_FAILED.
  Status finish();
  const std::string& caps() const noexcept { return caps_; }
  // Why reserve() returned null: LIMIT_EXCEEDED or OUT_OF_MEMORY.
  const std::optional<Error>& refusal() const noexcept { return refusal_; }

 private:
  GstBuffer* in_ = nullptr;   // borrowed
  GstBuffer* out_ = nullptr;  // borrowed; null while configuring
  const gst::FrameReader* reader_ = nullptr;
  const BufferLimit* limit_ = nullptr;  // borrowed
  Ledger* ledger_ = nullptr;
  uint64_t reserved_ = 0;  // bytes
  std::optional<Error> refusal_;
  std::string caps_;
  std::vector<gst::BufferPart> parts_;   // of the output
  std::vector<gst::MappedMemory> maps_;  // of what was reserved, until finish()
};

}  // namespace weir
