// Finds the elements of the cascade's pipeline by name: those it sets and GStreamer's defaults.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "copied_bytes.hpp"

namespace mtcnn {
namespace {

constexpr const char* kNamed[] = {"layers", "maps", "refined", "marked", "overlay", "out"};
constexpr const char* kNumbered[] = {"weirtensorpreprocess", "weirtensortransform",
                                     "weirtensorfilter", "weirtensormux", "weirtensordemux"};

// nullopt: no such element.
std::optional<uint64_t> copied_by(const weir::Pipeline& pipeline, const std::string& name) {
  const auto stats = pipeline.get(name, "stats");
  if (!stats) return std::nullopt;
  const std::string key = "bytes-copied=(guint64)";
  const size_t at = stats->find(key);
  if (at == std::string::npos) return 0;
  return std::strtoull(stats->c_str() + at + key.size(), nullptr, 10);
}

}  // namespace

uint64_t bytes_copied(const weir::Pipeline& pipeline) {
  uint64_t all = 0;
  for (const char* name : kNamed) all += copied_by(pipeline, name).value_or(0);
  for (const char* kind : kNumbered)
    for (int number = 0;; ++number) {
      const auto bytes = copied_by(pipeline, kind + std::to_string(number));
      if (!bytes) break;
      all += *bytes;
    }
  return all;
}

}  // namespace mtcnn
