// BufferSink: receives a decoder's caps and output, and writes them to one GstBuffer.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <optional>
#include <string>
#include <vector>

#include "core/infer/module/host.hpp"
#include "core/ledger/ledger.hpp"
#include "core/limit/buffer_limit.hpp"
#include "gstcpp/buffer/buffer_parts.hpp"
#include "gstcpp/buffer/frame_reader.hpp"

namespace weir {

class BufferSink final : public weir_sink {
 public:
  BufferSink() = default;  // for configure: accepts caps only
  BufferSink(GstBuffer* in, GstBuffer* out, const gst::FrameReader* reader,
             const BufferLimit& limit, Ledger* ledger)
      : in_(in), out_(out), reader_(reader), limit_(&limit), ledger_(ledger) {}
  ~BufferSink() = default;

  Status set_caps(const std::string& caps) override;
  void* reserve(uint64_t bytes) override;
  Status share_input(uint32_t index) override;
  // Appends the reserved and shared parts to the buffer in order: one memory each; of more than 16,
  // the 16th and all later ones share one. LIMIT_EXCEEDED, OUT_OF_MEMORY, MAPPING_FAILED.
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
  std::vector<gst::BufferPart> parts_;   // parts of the output
  std::vector<gst::MappedMemory> maps_;  // of reserved parts, until finish()
};

}  // namespace weir
