// Verdict: what limits a pipeline, in one sentence, from the time that its elements take.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/trace/graph.hpp"

namespace weir::trace {

// The load of an element: shares of the time in which frames flowed. The share of one that works in
// several threads at once is per thread, so that 1 means that it can do no more.
struct Load {
  std::string name;
  double work = 0, waiting = 0;
  Waits waits = Waits::Never;
  bool is_source = false, is_sink = false;
  uint64_t in = 0, out = 0;  // frames
};

struct Failure {
  std::string element, what;  // the element is "" if none reported it
};

enum class VerdictKind {
  Failed,
  NothingRan,   // no frame came to a sink
  Bottleneck,   // one element takes most of the time
  SourceBound,  // the same, and it is a source
  SinkBound,    // or a sink
  KeepsUp,      // the pipeline waits for its clock or its live source
  Balanced      // no element stands out
};

struct Verdict {
  VerdictKind kind = VerdictKind::NothingRan;
  std::string element;  // that it is about, "" for none
  double share = 0;     // of the time, of that element
  std::string text;     // "yolox takes 87 % of the time: the bottleneck."
};

// `failures`: the cause first; empty if the pipeline did not fail.
Verdict judge(const std::vector<Load>& loads, const std::vector<Failure>& failures);

// "bottleneck", "keeps-up", and so on.
std::string to_string(VerdictKind kind);

}  // namespace weir::trace
